"""Atoms under an indenter, as most tests need them, and differences of their energy."""

import numpy as np

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


def up(atoms, index):
    """Direction in which only one atom moves, along z."""
    direction = np.zeros((len(atoms), 3))
    direction[index, 2] = 1.0
    return direction


def force_along(atoms, direction, step=1e-5):
    """Force along a direction of all atoms, by differences of the energy."""
    positions, energies = atoms.positions.copy(), []
    for sign in (1, -1):
        atoms.positions = positions + sign * step * direction
        energies.append(atoms.get_potential_energy())
    atoms.positions = positions
    return (energies[1] - energies[0]) / (2 * step)
