r"""Bulk crystals: their lattice constant, stress and moduli, from energies.

The moduli are those of the nominal stress under a deformation gradient F,

.. math:: A_{iJkL} = \frac{1}{V} \frac{\partial^2 E}
                          {\partial F_{iJ}\, \partial F_{kL}},

the elastic constants of a crystal without stress. They give the response to small
displacements also under stress.
"""

from __future__ import annotations

from itertools import combinations_with_replacement, product
from typing import Any

import numpy as np
from ase import Atoms
from ase.build import bulk
from ase.data import atomic_numbers, reference_states
from ase.neighborlist import neighbor_list
from scipy.optimize import brentq

from ase_roughcontact._util.validation import positive
from ase_roughcontact.elasticity.crystals.force_constants import SURFACES

_ATOMS = {"fcc": 4, "bcc": 2, "diamond": 8}  # in a cubic cell
# Distance, in lattice constants, up to which neighbours distinguish structures.
_SHELLS = 1.3
# Range of strains in which a stress is expected to vanish.
_RANGE = 0.1
# Strains of the differences that give stress and moduli.
_STRAIN, _LARGE_STRAIN = 1e-4, 1e-3


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
            f"{(1.0 - _RANGE) * guess:.3f} and {(1.0 + _RANGE) * guess:.3f} Å with "
            "this calculator: give lattice_constant"
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


def deformed(crystal: Atoms, gradient: np.ndarray) -> Atoms:
    """Return a periodic crystal under a deformation gradient, without calculator."""
    atoms = crystal.copy()
    atoms.set_cell(crystal.cell.array @ gradient.T, scale_atoms=True)
    return atoms


def stress(calculator: Any, crystal: Atoms, axes: tuple[int, ...]) -> float:
    """Return the mean normal stress of a bulk crystal along some axes (eV/Å^3).

    It is positive under tension.
    """
    strain = np.zeros(3)
    strain[list(axes)] = _STRAIN
    low, high = (
        _energy(calculator, crystal, np.diag(1.0 + sign * strain)) for sign in (-1, 1)
    )
    return (high - low) / (2.0 * _STRAIN * len(axes) * crystal.cell.volume)


def nominal_moduli(calculator: Any, crystal: Atoms, sublattices: int = 1) -> np.ndarray:
    """Return the moduli ``A_iJkL`` of a bulk crystal, shape (3, 3, 3, 3) (eV/Å^3).

    Two sublattices, which alternate among the atoms, are displaced by a strain.
    """
    number = 6 + 3 * sublattices  # strains, and displacements of the second sublattice
    steps = _LARGE_STRAIN * np.eye(number)
    hessian = np.zeros((number, number))
    for m, n in combinations_with_replacement(range(number), 2):
        for s, t in product((1, -1), repeat=2):
            strain, shift = np.split(s * steps[m] + t * steps[n], [9])
            gradient = np.eye(3) + strain.reshape(3, 3)
            hessian[m, n] += s * t * _energy(calculator, crystal, gradient, shift)
        hessian[n, m] = hessian[m, n]
    hessian /= (2.0 * _LARGE_STRAIN) ** 2 * crystal.cell.volume
    relaxed = np.linalg.solve(hessian[9:, 9:], hessian[9:, :9])
    return (hessian[:9, :9] - hessian[:9, 9:] @ relaxed).reshape(3, 3, 3, 3)


def stretch_without_stress(
    calculator: Any, crystal: Atoms, axes: tuple[int, ...]
) -> float | None:
    """Return the stretch along axes at which the stress along them vanishes.

    It is None if there is none up to a strain of `_RANGE`.
    """

    def stretched(stretch: float) -> float:
        factors = np.ones(3)
        factors[list(axes)] = stretch
        return stress(calculator, deformed(crystal, np.diag(factors)), axes)

    for width in (0.1 * _RANGE, 0.3 * _RANGE, _RANGE):
        if stretched(1.0 - width) < 0.0 < stretched(1.0 + width):
            return float(brentq(stretched, 1.0 - width, 1.0 + width))
    return None


def _energy(
    calculator: Any,
    crystal: Atoms,
    gradient: np.ndarray,
    shift: np.ndarray | tuple = (),
) -> float:
    """Return the energy under a deformation gradient and a shift of a sublattice."""
    atoms = deformed(crystal, gradient)
    if len(shift):
        atoms.positions[1::2] += shift
    atoms.calc = calculator
    try:
        return float(atoms.get_potential_energy())
    except Exception as error:
        raise ValueError(
            f"{type(calculator).__name__} gives no energy for a crystal of "
            f"{crystal.symbols[0]}: {error}"
        ) from error
