"""Finer and coarser grids under the same indenter, for the continuum's answer."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace

from ase_roughcontact._util.rounding import RATIO_ROUNDING
from ase_roughcontact._util.validation import integer
from ase_roughcontact.contact import Problem
from ase_roughcontact.contact.problem import lattice_offsets
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.topography import RandomWaves, Surface
from ase_roughcontact.topography.topography import topography_of

# Number of spacings on the shortest wave of a surface on a coarser grid. Two are
# needed; smoother surfaces lose more slope than the grid gains.
_WAVE_SPACINGS = 2
# Pattern of a spacing relative to the spacing of the atoms.
_RATIO_TEXT = re.compile(r"\s*((?P<coarsen>\d+)\s*)?a0\s*(/\s*(?P<refine>\d+))?\s*")


@dataclass(frozen=True)
class GridChange:
    """A grid relative to the atoms': ``spacing = coarsen / refine`` of theirs.

    Attributes
    ----------
    refine, coarsen : int
        Without a common factor.
    """

    refine: int = 1
    coarsen: int = 1

    def __post_init__(self) -> None:
        """Check the numbers."""
        integer("refine", self.refine, 1)
        integer("coarsen", self.coarsen, 1)
        if math.gcd(self.refine, self.coarsen) > 1:
            raise ValueError(
                "refine and coarsen must have no common factor, got "
                f"{self.refine} and {self.coarsen}"
            )

    @classmethod
    def of(
        cls,
        refine: int | None = None,
        coarsen: int | None = None,
        text: str | float | None = None,
    ) -> GridChange | None:
        """Return a grid given by ratios or a text, such as ``"a0/2"`` or ``"3 a0/4"``.

        Returns
        -------
        GridChange or None
            None if nothing is given, or a text that is not relative to a0.

        Raises
        ------
        ValueError
            If a text and a ratio are given, or a ratio is not a whole number.
        """
        found = _RATIO_TEXT.fullmatch(text) if isinstance(text, str) else None
        if refine is None and coarsen is None and not found:
            return None
        if found and (refine, coarsen) != (None, None):
            raise ValueError(f"give grid = {text!r}, or refine and coarsen, not both")
        if found:
            return cls(int(found["refine"] or 1), int(found["coarsen"] or 1))
        return cls(1 if refine is None else refine, 1 if coarsen is None else coarsen)

    def __bool__(self) -> bool:
        return self.refine != self.coarsen

    @property
    def label(self) -> str:
        """The spacing in units of the atoms' spacing, ``"a0/2"`` or ``"2 a0"``."""
        factor = f"{self.coarsen} " if self.coarsen > 1 else ""
        return f"{factor}a0" + (f"/{self.refine}" if self.refine > 1 else "")

    def spacing(self, spacing: float) -> float:
        """Return the spacing of the grid from the spacing of the atoms."""
        return spacing * self.coarsen / self.refine

    def shape(self, shape: tuple[int, int]) -> tuple[int, int]:
        """Return the shape of the grid on a window of atoms."""
        if any(n % self.coarsen for n in shape):
            raise ValueError(
                f"coarsen = {self.coarsen} must divide the shape of the window, got "
                f"{shape}"
            )
        n, m = (n * self.refine // self.coarsen for n in shape)
        return n, m

    def enclosing_shape(self, shape: tuple[int, int]) -> tuple[int, int]:
        """Return the smallest shape of a window of atoms that `coarsen` divides."""
        n, m = (math.ceil(k / self.coarsen) * self.coarsen for k in shape)
        return n, m

    def surface(self, indenter: Surface, spacing: float) -> Surface:
        """Return an indenter without the waves that the grid can't resolve.

        Parameters
        ----------
        indenter : Surface
            The indenter.
        spacing : float
            Spacing of the atoms (length).

        Returns
        -------
        Surface
            The smoothed indenter; the same indenter if the grid is finer.

        Raises
        ------
        ValueError
            If the roughness has another period, or the grid is coarser, and the
            indenter has no method `band_limited`, or a roughness without longer waves.
        """
        for part in topography_of(indenter).rough.parts:
            self._check_waves(part, spacing)
        if self.coarsen <= self.refine:
            return indenter
        shortest = _WAVE_SPACINGS * self.spacing(spacing)
        return topography_of(indenter).band_limited(shortest)

    def _check_waves(self, rough: Surface | None, spacing: float) -> None:
        """Raise `ValueError` if the grid has no waves, or not the period."""
        if not isinstance(rough, RandomWaves) or self.coarsen == 1:
            return
        ratio = self.spacing(1.0)
        shortest, longest = rough.band
        for_longest = _coarsening(longest / spacing)
        if ratio > for_longest:
            for_all = _coarsening(shortest / spacing)
            raise ValueError(
                f"coarsen = {self.coarsen} leaves out all waves of the roughness, of "
                f"up to {longest / spacing:.4g} a0: choose at most {for_longest}, "
                f"or {for_all} to keep all waves"
            )
        side = rough.side / spacing
        if abs(side / ratio - round(side / ratio)) > RATIO_ROUNDING:
            fitting = math.ceil(side / self.coarsen) * self.coarsen
            raise ValueError(
                f"coarsen = {self.coarsen} must divide the domain of the roughness, "
                f"got {side:.9g} a0: choose a domain of {fitting} a0, "
                f"{fitting * spacing:.9g} Å"
            )


def _coarsening(wavelength: float) -> int:
    """Return the largest ratio of spacings that resolves a wavelength in spacings."""
    return math.floor(wavelength / _WAVE_SPACINGS + RATIO_ROUNDING)


def on_grid(problem: Problem, window: Box, change: GridChange) -> tuple[Problem, Box]:
    """Return a problem and a window on a finer or coarser grid.

    The window, the wall and the solid stay; the indenter is smoothed if the grid can't
    resolve its waves, see `lost_slope`.

    Parameters
    ----------
    problem : Problem
    window : Box
    change : GridChange
        Spacing of the new grid relative to the old one.

    Returns
    -------
    Problem, Box

    Raises
    ------
    ValueError
        If a coarser grid does not fit the window or the period of the indenter, or the
        indenter can't be smoothed.
    """
    if not change:
        return problem, window
    shape, origin = change.shape(window.shape), problem.origin(window)
    spacing = change.spacing(problem.spacing)
    indenter = change.surface(problem.indenter, problem.spacing)
    offset = lattice_offsets(origin, spacing)
    new = replace(problem, indenter=indenter, spacing=spacing, offset=offset)
    return new, new.window(shape, origin)


def lost_slope(indenter: Surface, smooth: Surface) -> float:
    """Return the part of the rms slope by which one indenter is smoother.

    NaN if the slopes are not known.
    """
    if indenter is smooth:
        return 0.0
    before, after = (topography_of(each).rough for each in (indenter, smooth))
    if before == after:
        return 0.0
    return 1.0 - after.statistics().rms_slope / before.statistics().rms_slope


def lost_text(change: GridChange, lost: float) -> str:
    """Return a text on the waves that a coarser grid can't resolve."""
    part = "a part" if math.isnan(lost) else f"{100 * lost:.2g} %"
    unknown = ", which is not known" if math.isnan(lost) else ""
    return (
        f"a grid {change.coarsen} times as coarse can't resolve waves shorter than "
        f"{_WAVE_SPACINGS} of its spacings: they are left out, and with them {part} of "
        f"the rms slope{unknown}"
    )
