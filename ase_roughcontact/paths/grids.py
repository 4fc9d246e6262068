"""Grids for the continuum: which spacing a wanted error of the contact area needs."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ase_roughcontact.interactions import Interaction
from ase_roughcontact.topography import Surface
from ase_roughcontact.topography.facts import IndenterFacts
from ase_roughcontact.windows.regrid import GridChange

# Errors of the area and the points on the shortest wave for which they were measured,
# at contact radii above 32 times that wave: see examples/benchmarks/answer_errors.py.
_POINTS = {0.05: 4, 0.01: 8, 0.002: 16}
# Smallest error that is attempted, with twice the points for half the error.
_SMALLEST = 5e-4
# Errors below which the area under a hard wall that attracts, or with a hardness, is
# extrapolated from two grids.
_EXTRAPOLATED = 0.05
# Spacings on the shortest wave of a surface whose wavelengths are not known.
_UNKNOWN_WAVE = 4.0
# Largest coarsening under hard, soft and attractive walls. The range of a soft wall is
# about a spacing of the atoms, and the edge of an adhesive contact must be resolved.
_HARD, _SOFT, _ATTRACTIVE = 8, 2, 1
# Tolerance within which a number is whole.
_ROUNDING = 1e-6


@dataclass(frozen=True)
class Grids:
    """Grid of a path, and whether the area is extrapolated from a coarser one, too.

    Attributes
    ----------
    change : GridChange
        Relative to the lattice of the atoms.
    extrapolated : bool
        Whether the area is the limit of this grid and of one of twice the spacing.
    """

    change: GridChange
    extrapolated: bool = False

    @property
    def coarser(self) -> GridChange:
        """The grid of twice the spacing."""
        refine, coarsen = self.change.refine, self.change.coarsen
        if refine % 2:
            return GridChange(refine, 2 * coarsen)
        return GridChange(refine // 2, coarsen)


def grids_for(
    error: float,
    indenter: Surface,
    wall: Interaction,
    spacing: float,
    shape: tuple[int, int] | None = None,
) -> Grids:
    """Return the grids with which the area of the continuum has a wanted error.

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
    Grids
        Finer ones by a power of two, or coarser ones if they divide the window and the
        period of the indenter.

    Raises
    ------
    ValueError
        If the error is smaller than 5e-4.
    """
    facts = IndenterFacts(indenter)
    wave = facts.short_wavelength
    if math.isnan(wave):
        wave = _UNKNOWN_WAVE * spacing
    finest = wave / _points(error) / spacing
    extrapolated = wall.hard and not wall.elastic_edge and error < _EXTRAPOLATED
    largest = _ATTRACTIVE if wall.attractive else _HARD if wall.hard else _SOFT
    power = math.floor(math.log2(min(finest, largest)) + _ROUNDING)
    while power >= 0:
        grids = Grids(GridChange(1, 2**power), extrapolated)
        coarsest = grids.coarser if extrapolated else grids.change
        if _fits(coarsest, facts, spacing, shape):
            return grids
        power -= 1
    return Grids(GridChange(2**-power), extrapolated)


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
    facts: IndenterFacts,
    spacing: float,
    shape: tuple[int, int] | None,
) -> bool:
    """Return whether a coarser grid divides the window and the period of roughness."""
    if change.coarsen == 1:
        return True
    divided = all(n % change.coarsen == 0 for n in shape or (_HARD, _HARD))
    if facts.roughness is None or not divided:
        return divided
    periods = facts.side / change.spacing(spacing)
    return abs(periods - round(periods)) < _ROUNDING if periods > 0.0 else False
