"""Atoms under an indenter, as most tests need them."""

from ase_roughcontact import RoughContact, substrate


def atoms_under(
    indenter,
    wall=None,
    shape=(8, 8),
    *,
    modulus=1.0,
    solid=None,
    spacing=1.0,
    load=0.0,
    heterogeneity=None,
    **options,
):
    """Copper atoms with a calculator, in units of contact modulus and spacing."""
    atoms = substrate("Cu", shape, indenter, spacing=spacing, **options)
    atoms.calc = RoughContact(
        indenter,
        None if solid else modulus,
        wall,
        solid=solid,
        load=load,
        heterogeneity=heterogeneity,
    )
    return atoms
