"""Bulk crystals: their element, lattice constant, and state below a surface."""

from __future__ import annotations

from typing import Any

import numpy as np
from ase import Atoms
from ase.build import bulk
from ase.data import atomic_numbers, reference_states
from ase.neighborlist import neighbor_list

from ase_roughcontact._util.validation import positive
from ase_roughcontact.elasticity.crystals.force_constants import SURFACES
from ase_roughcontact.elasticity.crystals.strain import (
    RANGE,
    deformed,
    stretch_without_stress,
)

_ATOMS = {"fcc": 4, "bcc": 2, "diamond": 8}  # in a cubic cell
# Distance, in lattice constants, up to which neighbours distinguish structures.
_SHELLS = 1.3


def element(bulk: Atoms | str, structure: str) -> tuple[str, float]:
    """Return the symbol of a crystal and a first guess of its lattice constant.

    The guess has the volume per atom of the given crystal, or of that in ASE's table.
    """
    if isinstance(bulk, Atoms):
        if len(set(bulk.symbols)) != 1 or not bulk.pbc.all():
            raise ValueError(
                f"bulk must be a periodic crystal of one element, got {bulk!r}"
            )
        symbol, volume = bulk.symbols[0], bulk.cell.volume / len(bulk)
        found = next((kind for kind in _ATOMS if _has_structure(bulk, kind)), None)
    else:
        symbol, reference = bulk, reference_states[atomic_numbers.get(bulk, 0)] or {}
        found = reference.get("symmetry", "")
        volume = reference.get("a", 0.0) ** 3 / _ATOMS.get(found, 1)
    if found not in _ATOMS:
        raise ValueError(
            f"bulk must be one of the crystals {', '.join(_ATOMS)}, got {bulk!r}: give "
            "one of them as Atoms, or describe the solid by its elastic constants "
            "(Cubic, Isotropic)"
        )
    if found != structure:
        raise ValueError(
            f"{symbol} is {found}, and this surface is {structure}: give surface="
            f"{found + '100'!r}, or a crystal of the other structure as Atoms"
        )
    return symbol, float((volume * _ATOMS[structure]) ** (1 / 3))


def _has_structure(crystal: Atoms, structure: str) -> bool:
    """Return whether the neighbours of all atoms are those of a cubic crystal."""
    a = (crystal.cell.volume / len(crystal) * _ATOMS[structure]) ** (1 / 3)
    ideal = bulk(crystal.symbols[0], structure, a)
    found, expected = (
        np.sort(np.tile(neighbor_list("d", one, _SHELLS * a), len(other)))
        for one, other in ((crystal, ideal), (ideal, crystal))
    )
    return found.shape == expected.shape and np.allclose(found, expected, rtol=0.02)


def chosen_crystal(
    calculator: Any,
    crystal: Atoms | str,
    structure: str,
    lattice_constant: float | None,
) -> tuple[str, float]:
    """Return the symbol of a crystal and its lattice constant.

    It is that at which the crystal has no stress, unless it is given (Å).
    """
    symbol, guess = element(crystal, structure)
    if lattice_constant is not None:
        positive(lattice_constant=lattice_constant)
        return symbol, float(lattice_constant)
    stretch = stretch_without_stress(
        calculator, bulk(symbol, structure, a=guess), (0, 1, 2)
    )
    if stretch is None:
        raise ValueError(
            f"{structure} {symbol} has no lattice constant without stress between "
            f"{(1.0 - RANGE) * guess:.3f} and {(1.0 + RANGE) * guess:.3f} Å with this "
            "calculator: give lattice_constant"
        )
    return symbol, guess * stretch


def bulk_below(calculator: Any, symbol: str, surface: str, a: float) -> Atoms:
    """Return a periodic cell of the bulk below a surface, without stress along z.

    Its axes are those of the surface, and ``a`` is its lattice constant along them (Å).
    """
    layers = {"fcc111": 3, "diamond100": 4}.get(surface, 2)  # after which they repeat
    crystal = SURFACES[surface](symbol, (1, 1, layers), a=a, periodic=True)
    stretch = stretch_without_stress(calculator, crystal, (2,))
    if stretch is None:
        raise ValueError(
            f"{symbol} with {type(calculator).__name__} is not stable at the lattice "
            f"constant {a:g} Å along the surface {surface}: omit lattice_constant"
        )
    return deformed(crystal, np.diag([1.0, 1.0, stretch]))
