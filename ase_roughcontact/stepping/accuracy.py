"""What grid points are, and the force tolerance and grid that an error requires.

For the model of atoms the error is left by the solver, for the continuum also by the
grid, see `grid_for`. It does not cover the wall and its cutoff.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, TypeAlias

from ase_roughcontact._util.rounding import RATIO_ROUNDING
from ase_roughcontact._util.validation import lookup, positive
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.topography import Surface
from ase_roughcontact.topography.topography import topography_of
from ase_roughcontact.windows.regrid import GridChange

# Largest ratio of the relative error in the normal force to the relative tolerance of
# the forces on atoms. No ratio is safe at an instability.
_ERROR_PER_TOLERANCE = 4.0
# Largest relative error of the area of the continuum, at contact radii above 32 times
# the shortest wave; see examples/benchmarks/answer_errors.py.
_MAX_ERROR = 0.05
# Smallest relative error that a grid is chosen for.
_MIN_ERROR = 5e-4
# Relative error below which the error is proportional to the spacing.
_LINEAR_ERROR = 2e-3
# Ratio of the errors before and after the number of points is doubled, for larger
# errors.
_DOUBLING_RATIO = 5.0
# Number of points on the shortest wave for the largest error.
_MIN_WAVE_POINTS = 4.0
# Smallest number of points on the shortest wave where spots of the contact flow, which
# are a few points wide: with 4 points errors of areas of flats were up to 1.6 times as
# large as without a hardness, with 6 points they were smaller.
_MIN_PLASTIC_WAVE_POINTS = 6.0
# Length of the shortest wave of a surface without known wavelengths, in spacings.
_DEFAULT_WAVE = 4.0
# Largest denominator of the ratio of a spacing to the spacing of the atoms.
_MAX_DENOMINATOR = 8
# Largest coarsening by kind of wall. The range of a soft wall is about a spacing of the
# atoms, and the edge of an adhesive contact must be resolved.
_MAX_COARSENING = {"hard": 8, "soft": 2, "attractive": 1}

#: Accuracy by name, or a relative error; see `GridModel`.
Accuracy: TypeAlias = Literal["fast", "normal", "high"] | float
#: Relative errors of the area of the continuum by name, at contact radii above 32 times
#: the shortest wavelength.
LEVELS = {"fast": 0.05, "normal": 0.01, "high": 0.002}
#: Relative error of force and area for the model of atoms, where nothing but the
#: tolerance is numerical.
ATOMS_ERROR = 1e-4
# Part of the error of the continuum that the solver may contribute.
_SOLVER_PART = 0.1
# Column of the contact area that answers the question, by the model of the grid.
_AREA_COLUMNS = {"atoms": "contact_area", "continuum": "continuum_area"}


@dataclass(frozen=True)
class GridModel:
    """Model that a grid samples, the error asked for, and the spacing.

    Attributes
    ----------
    model : {"atoms", "continuum"}
        Whether each point is an atom, or points sample the continuum.
    accuracy : {"fast", "normal", "high"} or float
        A number is a relative error, from 1e-12 to below 1. For the model of atoms all
        names mean the same.
    given : GridChange, optional
        Grid of the continuum. By default it is chosen for the accuracy.

    Raises
    ------
    ValueError
        If the model or the name is unknown, the error is out of range, or a grid is
        given for the model of atoms.
    """

    model: str = "atoms"
    accuracy: str | float = "normal"
    given: GridChange | None = None

    def __post_init__(self) -> None:
        """Check the model, the grid and the accuracy."""
        lookup(self.model, _AREA_COLUMNS, "model")
        if self.given and not self.is_continuum:
            raise ValueError(
                f'grid, refine and coarsen need model = "continuum", got "{self.model}"'
            )
        if isinstance(self.accuracy, str):
            lookup(self.accuracy, LEVELS, "accuracy")
            return
        positive(accuracy=self.accuracy)
        if not 1e-12 <= self.accuracy < 1.0:
            raise ValueError(
                "accuracy must be a relative error from 1e-12 to 1, got "
                f"{self.accuracy:g}"
            )

    @classmethod
    def of(cls, grid: str, accuracy: str | float) -> GridModel:
        """Return the model of a text: "atoms", "continuum", or a spacing of it.

        Parameters
        ----------
        grid : str
            The spacing is relative to the distance of the atoms, such as ``"a0/2"``.
        accuracy : str or float
            See `GridModel`.

        Raises
        ------
        ValueError
            If the text is neither, or the accuracy is not valid.
        """
        if grid in _AREA_COLUMNS:
            return cls(grid, accuracy)
        given = GridChange.of(text=grid)
        if given is None:
            raise ValueError(
                "grid must be 'atoms', 'continuum' or a spacing like 'a0/2' or '2 a0', "
                f"got {grid!r}"
            )
        return cls("continuum", accuracy, given)

    @property
    def is_continuum(self) -> bool:
        """Whether the continuum is asked for, and not the model of atoms."""
        return self.model == "continuum"

    @property
    def area_column(self) -> str:
        """Column of the contact area that is asked for."""
        return _AREA_COLUMNS[self.model]

    @property
    def error(self) -> float:
        """Largest relative error of normal force and contact area.

        The error of the force is relative to the sum of the magnitudes of the forces in
        contact, and the error of the area is beyond one atom. States at an instability
        are excepted, and for the continuum contacts of few grid points.
        """
        if not isinstance(self.accuracy, str):
            return float(self.accuracy)
        return LEVELS[self.accuracy] if self.is_continuum else ATOMS_ERROR

    @property
    def tolerance(self) -> float:
        """Largest force left on any atom, relative to the mean force in contact."""
        part = _SOLVER_PART if self.is_continuum else 1.0
        return tolerance_for(part * self.error)

    def grid(
        self,
        indenter: Surface,
        wall: Interaction,
        spacing: float,
        shape: tuple[int, int] | None = None,
    ) -> GridChange:
        """Return the grid relative to the grid of the atoms; see `grid_for`.

        Parameters
        ----------
        indenter, wall, spacing, shape
            See `grid_for`.
        """
        if self.given is not None:
            return self.given
        if not self.is_continuum:
            return GridChange()
        return grid_for(self.error, indenter, wall, spacing, shape)


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
        Number of atoms along x and y of a fixed window.

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
    if error < _MIN_ERROR:
        raise ValueError(
            f"accuracy must be at least {_MIN_ERROR:g} for the continuum, got "
            f"{error:g}: choose a larger error, or a grid by refine or coarsen"
        )
    wave = topography_of(indenter).rough.shortest_wavelength
    if math.isnan(wave):
        wave = _DEFAULT_WAVE * spacing
    points = points_per_wave(error)
    if wall.plastic:
        points = max(points, _MIN_PLASTIC_WAVE_POINTS)
    coarsest = min(wave / points / spacing, _MAX_COARSENING[wall.family])
    for ratio in _ratios(coarsest):
        change = GridChange(ratio.denominator, ratio.numerator)
        with suppress(ValueError):  # unless it divides the window and the period
            if shape is not None:
                change.shape(shape)
            change.surface(indenter, spacing)
            return change
    return GridChange(math.ceil(1.0 / coarsest - RATIO_ROUNDING))


def points_per_wave(error: float) -> float:
    """Return the points on the shortest wave for an error of the continuum's area."""
    error = min(error, _MAX_ERROR)
    linear = max(1.0, _LINEAR_ERROR / error)
    doublings = math.log(_MAX_ERROR / (error * linear), _DOUBLING_RATIO)
    return _MIN_WAVE_POINTS * 2.0**doublings * linear


def _ratios(largest: float) -> Iterator[Fraction]:
    """Yield fractions of small denominators up to a number, the largest ones first.

    Fractions below half of it are left out: finer grids cost four times as much.
    """
    ratios = set()
    for denominator in range(1, _MAX_DENOMINATOR + 1):
        largest_numerator = math.floor(largest * denominator + RATIO_ROUNDING)
        for numerator in range(1, largest_numerator + 1):
            ratio = Fraction(numerator, denominator)
            if ratio >= largest / 2:
                ratios.add(ratio)
    yield from sorted(ratios, reverse=True)
