"""Accuracy of a path: the force tolerance and the grid that a relative error requires.

The error is that of the answer to the question asked: for the model of atoms that of
the solver, for the continuum also that of the grid, see `grid_for`. It does not cover
the wall and its cutoff.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction

from ase_roughcontact._util.validation import positive, unknown
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.topography import Surface
from ase_roughcontact.topography.known import topography_of
from ase_roughcontact.windows.regrid import GridChange

# Largest ratio of the relative error in the normal force to the relative tolerance of
# the forces on atoms. No ratio is safe at an instability.
_ERROR_PER_TOLERANCE = 4.0
# Largest error of the area, and the points on the shortest wave for it, at contact
# radii above 32 times that wave; a fifth of the error needs twice the points: see
# examples/benchmarks/answer_errors.py.
_LARGEST, _FEWEST, _PER_DOUBLING = 0.05, 4.0, 5.0
# Fewest points on the shortest wave where spots of the contact flow, which are a few
# points wide: with 4 of them areas of flats were wrong by up to 1.6 times as much as
# without a hardness, with 6 of them by less.
_FEWEST_PLASTIC = 6.0
# Error below which half of it needs twice the points, and the smallest one attempted.
_LINEAR, _SMALLEST = 2e-3, 5e-4
# Largest denominator of a spacing in units of a0, and their ratio if both are integers.
_DENOMINATOR = 8
# Spacings on the shortest wave of a surface whose wavelengths are not known.
_UNKNOWN_WAVE = 4.0
# Largest coarsening under hard, soft and attractive walls. The range of a soft wall is
# about a spacing of the atoms, and the edge of an adhesive contact must be resolved.
_COARSEST = {"hard": 8, "soft": 2, "attractive": 1}
# Tolerance within which a number is whole.
_ROUNDING = 1e-6


@dataclass(frozen=True)
class Accuracy:
    """Allowed error, and the relative tolerance of forces for it.

    Attributes
    ----------
    error : float
        Largest error of the normal force, relative to the sum of the magnitudes of the
        forces in contact, and of the contact area, relative to it, beyond one atom.
        States at an instability are excepted, and for the continuum contacts of few
        grid points.
    tolerance : float
        Largest remaining force on any atom, relative to the mean force on the atoms in
        contact.
    """

    error: float
    tolerance: float


#: Relative errors of the area of the continuum by name, at contact radii above 32 times
#: the shortest wavelength.
LEVELS = {"fast": 0.05, "normal": 0.01, "high": 0.002}
#: Relative error of force and area for the model of atoms, where nothing but the
#: tolerance is numerical.
OF_ATOMS = 1e-4
# Part of the error of the continuum that the solver may contribute.
_SOLVER_PART = 0.1


def accuracy_of(wanted: str | float, continuum: bool = False) -> Accuracy:
    """Return the accuracy of a name, or for a relative error in force and area.

    Parameters
    ----------
    wanted : {"fast", "normal", "high"} or float
        A number is a relative error, from 1e-12 to below 1.
    continuum : bool
        Whether the continuum is asked for. For the model of atoms all names mean the
        same.

    Returns
    -------
    Accuracy

    Raises
    ------
    ValueError
        If the name is unknown, or the error out of range.
    """
    if isinstance(wanted, str):
        if wanted not in LEVELS:
            raise ValueError(unknown(wanted, list(LEVELS), "accuracy"))
        error = LEVELS[wanted] if continuum else OF_ATOMS
    else:
        positive(accuracy=wanted)
        if not 1e-12 <= wanted < 1.0:
            raise ValueError(
                f"accuracy must be a relative error from 1e-12 to 1, got {wanted:g}"
            )
        error = float(wanted)
    part = _SOLVER_PART if continuum else 1.0
    return Accuracy(error, tolerance_for(part * error))


def tolerance_for(error: float) -> float:
    """Return the relative tolerance of forces that leaves a relative error of them."""
    return error / _ERROR_PER_TOLERANCE


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
        The coarsest grid that suffices, with a multiple of up to an eighth of the
        spacing that divides the window and the period of the indenter.

    Raises
    ------
    ValueError
        If the error is smaller than 5e-4.
    """
    if error < _SMALLEST:
        raise ValueError(
            f"an accuracy of the continuum is at least {_SMALLEST:g}, got {error:g}; "
            "with a grid of your own (refine, coarsen) it is that of the solver"
        )
    wave = topography_of(indenter).rough.shortest_wavelength
    if math.isnan(wave):
        wave = _UNKNOWN_WAVE * spacing
    points = points_per_wave(error)
    if wall.plastic:
        points = max(points, _FEWEST_PLASTIC)
    coarsest = min(wave / points / spacing, _COARSEST[wall.family])
    for ratio in _ratios(coarsest):
        change = GridChange(ratio.denominator, ratio.numerator)
        with suppress(ValueError):  # unless it divides the window and the period
            if shape is not None:
                change.shape(shape)
            change.surface(indenter, spacing)
            return change
    return GridChange(math.ceil(1.0 / coarsest - _ROUNDING))


def points_per_wave(error: float) -> float:
    """Return the points on the shortest wave for an error of the continuum's area."""
    error = min(error, _LARGEST)
    linear = max(1.0, _LINEAR / error)
    doublings = math.log(_LARGEST / (error * linear), _PER_DOUBLING)
    return _FEWEST * 2.0**doublings * linear


def _ratios(largest: float) -> Iterator[Fraction]:
    """Yield fractions of small denominators up to a number, the largest ones first.

    Those below half of it are left out: finer grids cost four times as much.
    """
    found = {
        Fraction(number, denominator)
        for denominator in range(1, _DENOMINATOR + 1)
        for number in range(1, math.floor(largest * denominator + _ROUNDING) + 1)
    }
    yield from sorted((each for each in found if each >= largest / 2), reverse=True)
