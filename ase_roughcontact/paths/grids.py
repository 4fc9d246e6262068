"""Grids for the continuum: which spacing a wanted error of the contact area needs."""

from __future__ import annotations

import math

from ase_roughcontact.interactions import Interaction
from ase_roughcontact.topography import Surface
from ase_roughcontact.topography.facts import IndenterFacts
from ase_roughcontact.windows.regrid import GridChange

# Errors of the area and the points on the shortest wave for which they were measured,
# at contact radii above 32 times that wave: see examples/benchmarks/answer_errors.py.
_POINTS = {0.05: 4, 0.01: 8, 0.002: 16}
# Smallest error that is attempted, with twice the points for half the error.
_SMALLEST = 5e-4
# Spacings on the shortest wave of a surface whose wavelengths are not known.
_UNKNOWN_WAVE = 4.0
# Largest coarsening under hard, soft and attractive walls. The range of a soft wall is
# about a spacing of the atoms, and the edge of an adhesive contact must be resolved.
_COARSEST = {"hard": 8, "soft": 2, "attractive": 1}
# Tolerance within which a number is whole.
_ROUNDING = 1e-6


def grid_for(
    error: float,
    indenter: Surface,
    wall: Interaction,
    spacing: float,
    shape: tuple[int, int] | None = None,
) -> GridChange:
    """Return the grid with which the area of the continuum has a wanted error.

    Parameters
    ----------
    error : float
        Relative error of the contact area.
    indenter : Surface
        Its shortest wavelength is resolved.
    wall : Interaction
    spacing : float
        Distance of the atoms (length).
    shape : (int, int), optional
        Of a fixed window of atoms.

    Returns
    -------
    GridChange
        Of a grid that is finer by a power of two, or a coarser one if it divides the
        window and the period of the indenter.

    Raises
    ------
    ValueError
        If the error is smaller than 5e-4.
    """
    wave = IndenterFacts(indenter).short_wavelength
    if math.isnan(wave):
        wave = _UNKNOWN_WAVE * spacing
    finest = wave / _points(error) / spacing
    coarsest = min(finest, _COARSEST[wall.family])
    power = math.floor(math.log2(coarsest) + _ROUNDING)
    while power >= 0:
        change = GridChange(1, 2**power)
        if _fits(change, indenter, spacing, shape):
            return change
        power -= 1
    return GridChange(2**-power)


def _points(error: float) -> float:
    """Return the number of points on the shortest wave for an error of the area."""
    if error < _SMALLEST:
        raise ValueError(
            f"an accuracy of the continuum is at least {_SMALLEST:g}, got {error:g}; "
            "with a grid of your own (refine, coarsen) it is that of the solver"
        )
    sufficient = [points for level, points in _POINTS.items() if level <= error]
    smallest = min(_POINTS)
    return min(sufficient, default=_POINTS[smallest] * smallest / error)


def _fits(
    change: GridChange,
    indenter: Surface,
    spacing: float,
    shape: tuple[int, int] | None,
) -> bool:
    """Return whether a grid divides the window and the period of the roughness."""
    try:
        change.shape(shape or 2 * (max(_COARSEST.values()),))
        change.surface(indenter, spacing)
    except ValueError:
        return False
    return True
