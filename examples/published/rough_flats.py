"""Periodic rough flats that are pressed on an elastic half space, with a hard wall.

The contact modulus is 1, and lengths are in grid spacings.
"""

from collections.abc import Iterator

from ase import Atoms

from ase_roughcontact import (
    HardWall,
    LoadStep,
    RoughContact,
    SelfAffine,
    load_path,
    substrate,
)


def pressed(
    rough: SelfAffine, points: int, pressures
) -> Iterator[tuple[LoadStep, Atoms]]:
    """Yield the relaxed step and the atoms under rising mean pressures.

    Pressures are in units of rms slope times contact modulus, and the period is that of
    the roughness.
    """
    spacing = rough.domain / points
    shape = points, points
    atoms = substrate("Cu", shape, rough, spacing=spacing, periodic=True, fixed=False)
    atoms.calc = RoughContact(rough, 1.0, HardWall())
    loads = [each * rough.rms_slope * rough.domain**2 for each in pressures]
    for step in load_path(atoms, loads=loads, window="fixed", validity="ignore"):
        if not step.converged:
            raise RuntimeError(step.message)
        yield step, atoms
