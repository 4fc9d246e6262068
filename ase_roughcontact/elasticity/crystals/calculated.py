"""Crystal and relaxed surface from an ASE calculator, with checks of their errors."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from ase import Atoms
from ase.units import GPa

from ase_roughcontact._util.validation import integer, lookup, positive
from ase_roughcontact.elasticity.crystals import bulk as bulk_crystals
from ase_roughcontact.elasticity.crystals import kernel
from ase_roughcontact.elasticity.crystals.force_constants import (
    SUBLATTICES,
    SURFACES,
    ForceConstants,
    force_constants,
    relaxed_slab,
)
from ase_roughcontact.elasticity.crystals.impedance import surface_modulus
from ase_roughcontact.elasticity.crystals.lattice_greens import LatticeGreensFunction
from ase_roughcontact.elasticity.harmonics import cos2, sin2

#: Cause of an error of a crystal and advice against it, by the name of the error.
ADVICE = {
    "repetition": "the calculator returns other forces when asked again",
    "rest": "the relaxed slab has forces once it is repeated along the surface: the "
    "calculator describes large slabs in another way than small ones",
    "sum_rule": "the forces on all atoms have a resultant that is not zero",
    "symmetry": "the forces are no derivatives of an energy, or the calculator changes "
    "the displacement",
    "reach": "the forces reach beyond the slab: increase size and layers",
    "thickness": "the slab is too thin, or its forces are not linear in the "
    "displacement: increase layers, or decrease displacement",
    "square": "the surface does not have the symmetry of its structure",
    "interpolation": "the modulus is not smooth: check the force constants",
    "long_waves": "the forces in the slab do not fit the energies of strained bulk: "
    "the calculator describes slabs in another way than crystals, or its forces have "
    "noise that a larger displacement reduces",
}

# Components qx of the waves at which moduli are compared, times the spacing.
_COMPARED_QX = np.linspace(0.03, 0.97, 12) * np.pi
# Wave vectors of these waves, times the spacing.
_COMPARED_WAVES = np.array(
    [[qx, qx * ratio] for qx in _COMPARED_QX for ratio in np.linspace(0, 1, 5)]
)
# Wave number of long waves, times the spacing.
_LONG_WAVE_NUMBER = 1e-3
# Directions of long waves (rad).
_ANGLES = np.linspace(0.0, np.pi, 24, endpoint=False)
# Largest residual stress, relative to the contact modulus, without a warning.
_MAX_STRESS = 1e-3
# Smallest number of layers of a slab. With four layers less, it still has a layer of
# the bulk between its surfaces.
_MIN_LAYERS = 9


class CalculatedSurface(NamedTuple):
    """Crystal with a relaxed surface, from an ASE calculator.

    Attributes
    ----------
    symbol : str
        Chemical symbol.
    lattice_constant : float
        Lattice constant of the cubic crystal (Å).
    slab : Atoms
        One surface cell of the relaxed slab, ordered from the surface down.
    constants : ForceConstants
        Force constants. Their errors include "thickness" and "long_waves".
    greens : LatticeGreensFunction
        Green's function from the force constants.
    stress : float
        Stress of the crystal below the surface along x and y (eV/Å^3).
    moduli : ndarray, shape (3, 3, 3, 3)
        Moduli of the crystal below the surface, see `nominal_moduli` (eV/Å^3).
    """

    symbol: str
    lattice_constant: float
    slab: Atoms
    constants: ForceConstants
    greens: LatticeGreensFunction
    stress: float
    moduli: np.ndarray


def calculated_surface(
    calculator: Any,
    bulk: Atoms | str,
    surface: str,
    *,
    tolerance: float,
    lattice_constant: float | None = None,
    layers: int = 15,
    size: int = 9,
    displacement: float = 1e-3,
) -> CalculatedSurface:
    """Calculate a surface, and raise `ValueError` if an error is above the tolerance.

    See `Crystal.from_calculator` for the parameters.
    """
    lookup(surface, SURFACES, "surface")
    positive(tolerance=tolerance)
    integer("layers", layers, _MIN_LAYERS)
    symbol, a = bulk_crystals.chosen_crystal(
        calculator, bulk, surface[:-3], lattice_constant
    )
    below = bulk_crystals.bulk_below(calculator, symbol, surface, a)
    slab = relaxed_slab(calculator, symbol, surface, a, layers)
    thin_slab = relaxed_slab(calculator, symbol, surface, a, layers - 4)
    sublattices = SUBLATTICES[surface]
    constants = force_constants(calculator, slab, size, displacement, sublattices)
    thin = force_constants(calculator, thin_slab, size, displacement, sublattices)
    name = f"{surface} {symbol} with {type(calculator).__name__}"
    check_errors(constants.figures, tolerance, name)
    greens = LatticeGreensFunction(constants)
    area = float(np.linalg.norm(np.cross(*slab.cell.array[:2])))
    moduli = bulk_crystals.nominal_moduli(calculator, below, constants.sublattices)
    q, inverse = _COMPARED_WAVES / constants.spacing, long_wave_compliance(greens, area)
    thickness_ratio = inverse_modulus(LatticeGreensFunction(thin), q, 1.0)
    thickness_ratio /= inverse_modulus(greens, q, 1.0)
    long_wave_ratio = inverse * surface_modulus(moduli, _ANGLES)
    errors = {
        "thickness": float(abs(thickness_ratio - 1.0).max()),
        "long_waves": float(abs(long_wave_ratio - 1.0).max()),
    }
    check_errors(errors, tolerance, name)
    residual = bulk_crystals.stress(calculator, below, (0, 1))
    if abs(residual) * inverse.mean() > _MAX_STRESS:
        warnings.warn(
            f"{name} is under a stress of {residual / GPa:.3g} GPa along the surface "
            f"at the lattice constant {a:g} Å, which changes its moduli: omit "
            "lattice_constant to relax it",
            stacklevel=3,
        )
    constants = replace(constants, figures=constants.figures | errors)
    return CalculatedSurface(symbol, a, slab, constants, greens, residual, moduli)


def inverse_modulus(
    greens: LatticeGreensFunction, q: np.ndarray, cell_area: float
) -> np.ndarray:
    """Return ``1/E*(q) = cell_area |q| G_zz(q) / 2`` at wave vectors, shape (n, 2)."""
    return 0.5 * cell_area * np.hypot(*q.T) * greens(q)[:, 2, 2].real


def long_wave_compliance(greens: LatticeGreensFunction, cell_area: float) -> np.ndarray:
    """Return ``1/E*(theta)`` of long waves at angles between 0 and pi, shape (n,)."""
    directions = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1)
    waves = _LONG_WAVE_NUMBER / greens.spacing * directions
    once = inverse_modulus(greens, waves, cell_area)
    twice = inverse_modulus(greens, 2 * waves, cell_area)
    return 2.0 * once - twice  # extrapolated linearly to wave number zero


def tables(
    greens: LatticeGreensFunction,
) -> tuple[np.ndarray, np.ndarray, dict[str, float]]:
    """Return the coefficients of ``1/E*`` and of the lateral components, see `Crystal`.

    The third value are the errors "square" and "interpolation" of ``1/E*``.
    """

    def components(q: np.ndarray) -> np.ndarray:
        matrix, number = greens(q / greens.spacing), np.hypot(*q.T)
        direct = matrix[:, (2, 0, 1, 0), (2, 0, 1, 1)].real.T
        direct[3] /= sin2(*q.T)
        cross = -matrix[:, :2, 2].imag.T * number / q.T
        return 0.5 * greens.spacing * number * np.concatenate([direct, cross])

    area = greens.spacing**2
    nodes, equivalent = kernel.node_vectors(), greens.sublattices == 1
    values, exchanged = components(nodes), components(nodes[:, ::-1])
    values[5], exchanged[5] = exchanged[5], values[5].copy()  # y before x
    other = (values - exchanged) / cos2(*nodes.T)
    if equivalent:
        # zero up to rounding errors, which the expansion would amplify
        other[3] = 0.0
    halves = np.stack([values + exchanged, other], axis=1) / 2.0
    table, *lateral = [
        np.array([kernel.interpolation_table(half) for half in both]) for both in halves
    ]
    if equivalent:  # the rows of atoms along x and y
        table = kernel.interpolation_table(values[0])

    def deviation(qx: np.ndarray, qy: np.ndarray) -> float:
        q = np.stack([qx, qy], -1) / greens.spacing
        exact = inverse_modulus(greens, q, area)
        return float(abs(exact / kernel.interpolate(table, qx, qy) - 1.0).max())

    x, y = _COMPARED_WAVES.T
    errors = {
        "square": max(deviation(x, -y), deviation(y, x), deviation(-x, y)),
        "interpolation": deviation(x, y),
    }
    return table, np.array(lateral), errors


def check_errors(figures: dict[str, float], tolerance: float, name: str) -> None:
    """Raise `ValueError` for the first error, by order of advice, above tolerance."""
    for figure, advice in ADVICE.items():
        if not figures.get(figure, 0.0) <= tolerance:  # true for NaN
            raise ValueError(
                f"the relative error {figure!r} of {name} is {figures[figure]:.2g}, "
                f"above {tolerance:g}: {advice}"
            )
