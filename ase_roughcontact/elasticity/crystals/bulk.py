r"""Lattice constant, stress and moduli of bulk crystals, from energies.

The moduli are derivatives of the nominal stress with the deformation gradient F,

.. math:: A_{iJkL} = \frac{1}{V} \frac{\partial^2 E}
                          {\partial F_{iJ}\, \partial F_{kL}} .

They give the response to small displacements also under stress; without stress they are
the elastic constants.
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

# Number of atoms in a cubic cell, by structure.
_ATOMS_PER_CELL = {"fcc": 4, "bcc": 2, "diamond": 8}
# Distance, in lattice constants, up to which neighbours are compared.
_NEIGHBOUR_DISTANCE = 1.3
# Largest strain at which the stress is expected to vanish.
_MAX_STRAIN = 0.1
# Strain of the differences that give a stress.
_STRESS_STRAIN = 1e-4
# Strain of the differences that give moduli.
_MODULI_STRAIN = 1e-3


def element(bulk: Atoms | str, structure: str) -> tuple[str, float]:
    """Return the symbol of a crystal and a first guess of its lattice constant (Å).

    The guess has the volume per atom of the given crystal, or of ASE's table.
    """
    if isinstance(bulk, Atoms):
        if len(set(bulk.symbols)) != 1 or not bulk.pbc.all():
            raise ValueError(
                f"bulk must be a periodic crystal of one element, got {bulk!r}"
            )
        symbol, volume = bulk.symbols[0], bulk.cell.volume / len(bulk)
        found = ""
        for each in _ATOMS_PER_CELL:
            if _has_structure(bulk, each):
                found = each
                break
    else:
        symbol, reference = bulk, reference_states[atomic_numbers.get(bulk, 0)] or {}
        found = reference.get("symmetry", "")
        volume = reference.get("a", 0.0) ** 3 / _ATOMS_PER_CELL.get(found, 1)
    if found not in _ATOMS_PER_CELL:
        raise ValueError(
            f"bulk must be one of the crystals {', '.join(_ATOMS_PER_CELL)}, got "
            f"{bulk!r}: give one of them as Atoms, or describe the solid by its "
            "elastic constants (Cubic, Isotropic)"
        )
    if found != structure:
        raise ValueError(
            f"{symbol} is {found}, and this surface is {structure}: give surface="
            f"{found + '100'!r}, or a crystal of the other structure as Atoms"
        )
    return symbol, float((volume * _ATOMS_PER_CELL[structure]) ** (1 / 3))


def _has_structure(crystal: Atoms, structure: str) -> bool:
    """Return whether all atoms have the neighbours of atoms in a cubic crystal."""
    a = (crystal.cell.volume / len(crystal) * _ATOMS_PER_CELL[structure]) ** (1 / 3)
    ideal = bulk(crystal.symbols[0], structure, a)
    distance = _NEIGHBOUR_DISTANCE * a
    # repeated, so that both lists have the neighbours of equally many atoms
    found = np.tile(neighbor_list("d", crystal, distance), len(ideal))
    expected = np.tile(neighbor_list("d", ideal, distance), len(crystal))
    if found.shape != expected.shape:
        return False
    return np.allclose(np.sort(found), np.sort(expected), rtol=0.02)


def chosen_crystal(
    calculator: Any,
    crystal: Atoms | str,
    structure: str,
    lattice_constant: float | None,
) -> tuple[str, float]:
    """Return the symbol of a crystal and its lattice constant (Å).

    The lattice constant is the given one, or else the one without stress.
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
            f"{(1.0 - _MAX_STRAIN) * guess:.3f} and {(1.0 + _MAX_STRAIN) * guess:.3f} "
            "Å with this calculator: give lattice_constant"
        )
    return symbol, guess * stretch


def bulk_below(calculator: Any, symbol: str, surface: str, a: float) -> Atoms:
    """Return a periodic cell of the bulk below a surface, without stress along z.

    It has the axes of the surface, and the lattice constant ``a`` along x and y (Å).
    """
    layers = {"fcc111": 3, "diamond100": 4}.get(surface, 2)  # period of the stacking
    crystal = SURFACES[surface](symbol, (1, 1, layers), a=a, periodic=True)
    stretch = stretch_without_stress(calculator, crystal, (2,))
    if stretch is None:
        raise ValueError(
            f"{symbol} with {type(calculator).__name__} is not stable at the lattice "
            f"constant {a:g} Å along the surface {surface}: omit lattice_constant"
        )
    return deformed(crystal, np.diag([1.0, 1.0, stretch]))


def deformed(crystal: Atoms, gradient: np.ndarray) -> Atoms:
    """Return a crystal under a deformation gradient, without calculator."""
    atoms = crystal.copy()
    atoms.set_cell(crystal.cell.array @ gradient.T, scale_atoms=True)
    return atoms


def stress(calculator: Any, crystal: Atoms, axes: tuple[int, ...]) -> float:
    """Return the mean normal stress of a bulk crystal along some axes (eV/Å^3).

    It is positive under tension.
    """
    strain = np.zeros(3)
    strain[list(axes)] = _STRESS_STRAIN
    low = _energy(calculator, crystal, np.diag(1.0 - strain))
    high = _energy(calculator, crystal, np.diag(1.0 + strain))
    return (high - low) / (2.0 * _STRESS_STRAIN * len(axes) * crystal.cell.volume)


def nominal_moduli(calculator: Any, crystal: Atoms, sublattices: int = 1) -> np.ndarray:
    """Return the moduli ``A_iJkL`` of a bulk crystal, shape (3, 3, 3, 3) (eV/Å^3).

    With two sublattices, which alternate among the atoms, their relative displacement
    is relaxed.
    """
    # 9 strains, and the displacement of the second sublattice
    number = 6 + 3 * sublattices
    steps = _MODULI_STRAIN * np.eye(number)
    hessian = np.zeros((number, number))
    for m, n in combinations_with_replacement(range(number), 2):
        for s, t in product((1, -1), repeat=2):
            strain, displacement = np.split(s * steps[m] + t * steps[n], [9])
            gradient = np.eye(3) + strain.reshape(3, 3)
            energy = _energy(calculator, crystal, gradient, displacement)
            hessian[m, n] += s * t * energy
        hessian[n, m] = hessian[m, n]
    hessian /= (2.0 * _MODULI_STRAIN) ** 2 * crystal.cell.volume
    relaxed = np.linalg.solve(hessian[9:, 9:], hessian[9:, :9])
    return (hessian[:9, :9] - hessian[:9, 9:] @ relaxed).reshape(3, 3, 3, 3)


def stretch_without_stress(
    calculator: Any, crystal: Atoms, axes: tuple[int, ...]
) -> float | None:
    """Return the stretch along axes at which the stress along them vanishes.

    Return None if the stress does not vanish up to a strain of `_MAX_STRAIN`.
    """

    def stretched_stress(stretch: float) -> float:
        factors = np.ones(3)
        factors[list(axes)] = stretch
        return stress(calculator, deformed(crystal, np.diag(factors)), axes)

    for strain in (0.1 * _MAX_STRAIN, 0.3 * _MAX_STRAIN, _MAX_STRAIN):
        low, high = 1.0 - strain, 1.0 + strain
        if stretched_stress(low) < 0.0 < stretched_stress(high):
            return float(brentq(stretched_stress, low, high))
    return None


def _energy(
    calculator: Any,
    crystal: Atoms,
    gradient: np.ndarray,
    displacement: np.ndarray | tuple = (),
) -> float:
    """Return the energy of a deformed crystal with a displaced second sublattice."""
    atoms = deformed(crystal, gradient)
    if len(displacement):
        atoms.positions[1::2] += displacement
    atoms.calc = calculator
    try:
        return float(atoms.get_potential_energy())
    except Exception as error:
        raise ValueError(
            f"{type(calculator).__name__} gives no energy for a crystal of "
            f"{crystal.symbols[0]}: {error}"
        ) from error
