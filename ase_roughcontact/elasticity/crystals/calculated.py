"""A crystal and its relaxed surface as an ASE calculator describes them, checked."""

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
from ase_roughcontact.elasticity.crystals.cubic import surface_modulus
from ase_roughcontact.elasticity.crystals.force_constants import (
    SUBLATTICES,
    SURFACES,
    ForceConstants,
    force_constants,
    relaxed_slab,
)
from ase_roughcontact.elasticity.crystals.lattice_greens import LatticeGreensFunction
from ase_roughcontact.elasticity.harmonics import cos2, sin2

#: What to do about an error of a crystal, by its name.
ADVICE = {
    "repetition": "the calculator returns other forces when asked again",
    "rest": "the relaxed slab has forces once it is repeated along the surface: the "
    "calculator describes large slabs in another way than small ones",
    "sum_rule": "the forces on all atoms have a resultant that is not zero",
    "symmetry": "the forces are not those of an energy, or change the displacement",
    "reach": "the forces reach beyond the slab: increase size and layers",
    "thickness": "the slab is too thin, or its forces are not linear in the "
    "displacement: increase layers, or decrease displacement",
    "square": "the surface does not have the symmetry of its structure",
    "interpolation": "the modulus is not smooth: check the force constants",
    "long_waves": "the forces in the slab are not those of the energies of strained "
    "bulk: the calculator describes slabs in another way than crystals, or its forces "
    "have noise that a larger displacement reduces",
}

# Waves along the surface, times the spacing, at which the modulus is compared.
_NUMBERS = np.linspace(0.03, 0.97, 12) * np.pi
_WAVES = np.array([[q, q * part] for q in _NUMBERS for part in np.linspace(0, 1, 5)])
# Wave number, times the spacing, and directions of long waves.
_LONG, _ANGLES = 1e-3, np.linspace(0.0, np.pi, 24, endpoint=False)
# Residual stress, relative to the contact modulus, of which a warning is given.
_STRESSED = 1e-3
# Layers of a slab whose thinner one still has a layer of the bulk between its surfaces.
_LEAST_LAYERS = 9


class CalculatedSurface(NamedTuple):
    """Crystal with a relaxed surface, from an ASE calculator.

    Attributes
    ----------
    symbol : str
        Chemical symbol.
    lattice_constant : float
        Of the cubic crystal (Å).
    slab : Atoms
        One surface cell of the relaxed slab, ordered from the surface down.
    constants : ForceConstants
        With the errors "thickness" and "long_waves", too.
    greens : LatticeGreensFunction
        Of the force constants.
    stress : float
        Stress of the crystal below the surface along x and y (eV/Å^3).
    """

    symbol: str
    lattice_constant: float
    slab: Atoms
    constants: ForceConstants
    greens: LatticeGreensFunction
    stress: float


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
    """Calculate a surface, and raise `ValueError` if it has too large errors.

    See `Crystal.from_calculator` for the parameters.
    """
    lookup(surface, SURFACES, "surface")
    positive(tolerance=tolerance)
    integer("layers", layers, _LEAST_LAYERS)
    symbol, a = bulk_crystals.chosen_crystal(
        calculator, bulk, surface[:-3], lattice_constant
    )
    below = bulk_crystals.bulk_below(calculator, symbol, surface, a)
    slab, thinner = (
        relaxed_slab(calculator, symbol, surface, a, number)
        for number in (layers, layers - 4)
    )
    constants, thin = (
        force_constants(calculator, each, size, displacement, SUBLATTICES[surface])
        for each in (slab, thinner)
    )
    name = f"{surface} {symbol} with {type(calculator).__name__}"
    check_errors(constants.figures, tolerance, name)
    greens = LatticeGreensFunction(constants)
    area = float(np.linalg.norm(np.cross(*slab.cell.array[:2])))
    moduli = bulk_crystals.nominal_moduli(calculator, below, constants.sublattices)
    q, inverse = _WAVES / constants.spacing, long_wave_compliance(greens, area)
    change = inverse_modulus(LatticeGreensFunction(thin), q, 1.0)
    change /= inverse_modulus(greens, q, 1.0)
    long = inverse * surface_modulus(moduli, _ANGLES)
    errors = {
        "thickness": float(abs(change - 1.0).max()),
        "long_waves": float(abs(long - 1.0).max()),
    }
    check_errors(errors, tolerance, name)
    residual = bulk_crystals.stress(calculator, below, (0, 1))
    if abs(residual) * inverse.mean() > _STRESSED:
        warnings.warn(
            f"{name} is under a stress of {residual / GPa:.3g} GPa along the surface "
            f"at the lattice constant {a:g} Å, which changes its moduli: omit "
            "lattice_constant to relax it",
            stacklevel=3,
        )
    constants = replace(constants, figures=constants.figures | errors)
    return CalculatedSurface(symbol, a, slab, constants, greens, residual)


def inverse_modulus(
    greens: LatticeGreensFunction, q: np.ndarray, cell_area: float
) -> np.ndarray:
    """Return ``1/E*(q) = cell_area |q| G_zz(q) / 2`` at wave vectors, shape (n, 2)."""
    return 0.5 * cell_area * np.hypot(*q.T) * greens(q)[:, 2, 2].real


def long_wave_compliance(greens: LatticeGreensFunction, cell_area: float) -> np.ndarray:
    """Return ``1/E*(theta)`` of long waves at angles between 0 and pi, shape (n,)."""
    waves = _LONG / greens.spacing * np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1)
    once, twice = (inverse_modulus(greens, n * waves, cell_area) for n in (1, 2))
    return 2.0 * once - twice  # linear in the wave number


def tables(
    greens: LatticeGreensFunction,
) -> tuple[np.ndarray, np.ndarray, dict[str, float]]:
    """Return the coefficients of ``1/E*`` and of the lateral components, see `Crystal`.

    With them are the errors "square" and "interpolation" of the first.
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
        other[3] = 0.0  # but for rounding, which its expansion would amplify
    halves = np.stack([values + exchanged, other], axis=1) / 2.0
    table, *lateral = [
        np.array([kernel.interpolation_table(half) for half in both]) for both in halves
    ]
    if equivalent:  # the rows of atoms along x and y
        table = kernel.interpolation_table(values[0])
    x, y = _WAVES.T
    interpolation, *square = (
        float(abs(inverse_modulus(greens, q, area) / found - 1.0).max())
        for q, found in (
            (np.stack(q, -1) / greens.spacing, kernel.interpolate(table, *q))
            for q in ((x, y), (x, -y), (y, x), (-x, y))
        )
    )
    errors = {"square": max(square), "interpolation": interpolation}
    return table, np.array(lateral), errors


def check_errors(figures: dict[str, float], tolerance: float, name: str) -> None:
    """Raise an error about the first figure in the order of the advice."""
    for figure, advice in ADVICE.items():
        if not figures.get(figure, 0.0) <= tolerance:  # or not a number
            raise ValueError(
                f"the relative error {figure!r} of {name} is {figures[figure]:.2g}, "
                f"above {tolerance:g}: {advice}"
            )
