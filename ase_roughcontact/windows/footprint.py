"""Footprint of the indenter: which atoms are below a level of it.

Lengths are in any one unit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np

from ase_roughcontact.elasticity.fft import fast_length
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.topography import BoundedSurface, Surface

# Side of the tiles that a surface is searched in, and of the first look at its middle.
_TILE = 512
_MIDDLE = 64
# Windows have one of few sizes, each about so many times the one before: small ones,
# and large ones, where what is not needed costs most.
_RUNG, _LARGE_RUNG = 1.12, 1.04
_SMALLEST, _LARGE = 8, 256
# Advice on a domain adds room.
_ROOM = 1.3
# Whole numbers of spacings up to this.
_ROUNDING = 1e-9


class Footprint:
    """Outline of an indenter seen along x and y, which tells what is below a level.

    It keeps the lowest height in every row and every column of atoms. From these
    follows the bounding box of the atoms below any level.

    Parameters
    ----------
    indenter : Surface
        One that tells its `reach`, such as `RoughSphere`.
    spacing : float
        Distance of neighbours (length).
    origin : (float, float)
        Position of any atom relative to the axis (length).

    Raises
    ------
    ValueError
        If the indenter does not rise out of reach.
    """

    def __init__(
        self,
        indenter: Surface,
        spacing: float,
        origin: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        if not isinstance(indenter, BoundedSurface):
            raise ValueError(
                "automatic windows need an indenter with a method reach, such as "
                f"RoughSphere or another BoundedSurface, got {indenter!r}: define it, "
                "or choose a fixed window"
            )
        self.indenter, self.spacing = indenter, spacing
        self.offset = (rest_of(origin[0], spacing), rest_of(origin[1], spacing))
        self._half = -1
        self._first = 0
        self._rows = self._columns = np.zeros(0)

    @cached_property
    def lowest(self) -> float:
        """Lowest height of any atom."""
        self._search(_MIDDLE)
        self._search(self._reach(float(self._rows.min())))
        return float(self._rows.min())

    @cached_property
    def domain(self) -> Box | None:
        """Atoms at which the surface is known, and does not repeat; None for all."""
        indenter = self.indenter
        if indenter.extent == math.inf:
            return None
        steps = indenter.extent / self.spacing + _ROUNDING
        if indenter.repeats:
            half = (math.floor(2 * steps) - 1) // 2
        else:
            half = math.floor(steps - max(map(abs, self.offset)) / self.spacing)
        return Box((-half, -half), (2 * half + 1, 2 * half + 1))

    def below(self, level: float) -> Box:
        """Smallest box of all atoms lower than a level, and of the lowest.

        Parameters
        ----------
        level : float
            Height (length).

        Returns
        -------
        Box
            Also beyond the domain if the surface repeats, else up to its edge.
        """
        level = max(level, np.nextafter(self.lowest, np.inf))
        self._search(self._reach(level))
        rows, columns = (
            np.flatnonzero(low < level) + self._first
            for low in (self._rows, self._columns)
        )
        return Box.between(
            (int(rows[0]), int(columns[0])), (int(rows[-1]) + 1, int(columns[-1]) + 1)
        )

    def known(self, box: Box) -> Box:
        """Part of a box that is in the domain."""
        return box if self.domain is None else box.intersection(self.domain)

    def check(self, level: float) -> None:
        """Raise `ValueError` unless all atoms below a level are in the domain."""
        if self.domain is None or self.domain.contains(box := self._possible(level)):
            return
        atoms = max(*map(abs, box.start), *map(abs, box.stop))
        known = self.indenter.extent / self.spacing
        advice = "choose a smaller load or depth, or a larger map"
        if self.indenter.repeats:
            side = math.ceil(_ROOM * 2 * atoms)  # the next level may be lower still
            advice = (
                f"give the roughness a domain of {side} spacings or more "
                f"(domain={side * self.spacing:.12g} of SelfAffine)"
            )
        raise ValueError(
            f"atoms up to {atoms} spacings from the indenter's axis can touch, but its "
            f"surface is known only up to {known:g} spacings: {advice}"
        )

    def roomy(self, box: Box) -> Box:
        """Box of one of few sizes around another, within the domain."""
        start, shape = [], []
        for axis in (0, 1):
            n, first = _rung(box.shape[axis]), box.start[axis]
            low = first - (n - box.shape[axis]) // 2
            if self.domain is not None:
                n = max(min(n, self.domain.shape[axis]), box.shape[axis])
                low = max(min(low, self.domain.stop[axis] - n), self.domain.start[axis])
            start.append(low)
            shape.append(n)
        return Box((start[0], start[1]), (shape[0], shape[1]))

    def heights(self, window: Box) -> np.ndarray:
        """Heights of the atoms in a window, shape of the window."""
        x, y = (
            start * self.spacing + offset
            for start, offset in zip(window.start, self.offset, strict=True)
        )
        return self.indenter.heights(window.shape, self.spacing, (x, y))

    def _possible(self, level: float) -> Box:
        """Box of all atoms that may be below a level."""
        if self.indenter.repeats:
            return self.below(level)
        half = self._reach(level)
        return Box((-half, -half), (2 * half + 1, 2 * half + 1))

    def _reach(self, level: float) -> int:
        reach = self.indenter.reach(level, self.spacing, self.offset)
        return math.ceil(reach / self.spacing)

    def _search(self, half: int) -> None:
        """Find the lowest heights of rows and columns up to a distance."""
        if half <= self._half:
            return
        self._half = half = max(half, round(1.25 * self._half))
        around = Box((-half, -half), (2 * half + 1, 2 * half + 1))
        around = self.known(around) if not self.indenter.repeats else around
        (self._first, _), (stop, _) = around.start, around.stop
        self._rows, self._columns = np.full((2, stop - self._first), np.inf)
        for tile in self._tiles(around):
            nearest = [
                max(a, 1 - b, 0) for a, b in zip(tile.start, tile.stop, strict=True)
            ]
            if math.hypot(*nearest) > half + 1:
                continue
            heights = self.heights(tile)
            rows, columns = tile.slices_in(around)
            for low, part, axis in ((self._rows, rows, 1), (self._columns, columns, 0)):
                np.minimum(low[part], heights.min(axis=axis), out=low[part])

    def _tiles(self, box: Box) -> Iterator[Box]:
        """Parts of a box that are not too large to be worked on."""
        side = _TILE if self.domain is None else min(_TILE, *self.domain.shape)
        (i, j), (k, m) = box.start, box.stop
        for first in range(i, k, side):
            for second in range(j, m, side):
                yield Box((first, second), (side, side)).intersection(box)


def rest_of(place: float, spacing: float) -> float:
    """Part of a place that is not a whole number of spacings; zero, not rounding."""
    rest = place - spacing * round(place / spacing)
    return 0.0 if abs(rest) < _ROUNDING * spacing else rest


def _rung(least: int) -> int:
    """Length of a window from a ladder on which the padded grid is a fast one."""
    rung = _RUNG if least < _LARGE else _LARGE_RUNG
    steps = math.ceil(math.log(max(least, _SMALLEST), rung) - _ROUNDING)
    return (fast_length(2 * math.ceil(rung**steps) - 1) + 1) // 2
