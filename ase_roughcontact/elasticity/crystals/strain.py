r"""Stress and moduli of bulk crystals, by differences of their energy.

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
from scipy.optimize import brentq

#: Range of strains in which a stress is expected to vanish.
RANGE = 0.1
# Strains of the differences that give stress and moduli.
_STRAIN, _LARGE_STRAIN = 1e-4, 1e-3


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

    It is None if there is none up to a strain of `RANGE`.
    """

    def stretched(stretch: float) -> float:
        factors = np.ones(3)
        factors[list(axes)] = stretch
        return stress(calculator, deformed(crystal, np.diag(factors)), axes)

    for width in (0.1 * RANGE, 0.3 * RANGE, RANGE):
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
