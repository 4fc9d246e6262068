"""Accuracy of a path: the force tolerance and the grid that a relative error requires.

The error is that of the answer to the question asked: for the model of atoms that of
the solver, for the continuum also that of the grid, see `grid_for`. It does not cover
the wall and its cutoff.
"""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass

from ase_roughcontact._util.validation import positive, unknown
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.topography import Surface
from ase_roughcontact.topography.facts import IndenterFacts
from ase_roughcontact.windows.regrid import GridChange

# Largest ratio of the relative error in the normal force to the relative tolerance of
# the forces on atoms. No ratio is safe at an instability.
_ERROR_PER_TOLERANCE = 4.0
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
    return Accuracy(error, part * error / _ERROR_PER_TOLERANCE)


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
    if error < _SMALLEST:
        raise ValueError(
            f"an accuracy of the continuum is at least {_SMALLEST:g}, got {error:g}; "
            "with a grid of your own (refine, coarsen) it is that of the solver"
        )
    smallest = min(_POINTS)
    sufficient = [points for level, points in _POINTS.items() if level <= error]
    points = min(sufficient, default=_POINTS[smallest] * smallest / error)
    wave = IndenterFacts(indenter).short_wavelength
    if math.isnan(wave):
        wave = _UNKNOWN_WAVE * spacing
    coarsest = min(wave / points / spacing, _COARSEST[wall.family])
    power = math.floor(math.log2(coarsest) + _ROUNDING)
    for coarser in range(power, -1, -1):
        change = GridChange(1, 2**coarser)
        with suppress(ValueError):  # unless it divides the window and the period
            change.shape(shape or 2 * (max(_COARSEST.values()),))
            change.surface(indenter, spacing)
            return change
    return GridChange(2 ** max(-power, 0))
