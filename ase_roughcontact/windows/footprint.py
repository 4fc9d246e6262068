"""Footprint of an indenter: bounding boxes of the atoms where it is below a level.

Lengths are in any one unit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property

import numpy as np

from ase_roughcontact._util.rounding import RATIO_ROUNDING
from ase_roughcontact.elasticity.fft import fast_length
from ase_roughcontact.elasticity.lattice import Box, lattice_offset
from ase_roughcontact.topography import Surface
from ase_roughcontact.topography.topography import Topography, topography_of
from ase_roughcontact.windows.memory import available_memory, memory_of

# Side of the tiles in which a surface is searched, in atoms.
_TILE_SIDE = 512
# Half the side of the square about the axis that is searched first, in atoms.
_FIRST_HALF_SIDE = 64
# Smallest growth of the side of the square when a larger one is searched.
_SEARCH_GROWTH = 1.25
# Smallest side of a window, in atoms.
_MIN_SIDE = 8
# Side of a window, in atoms, above which superfluous atoms cost most.
_LARGE_SIDE = 256
# Ratio of the sides of windows, which form a geometric sequence so that few FFT grids
# are needed.
_SIDE_RATIO = 1.12
# Ratio of the sides of large windows.
_LARGE_SIDE_RATIO = 1.04
# Factor by which a recommended domain is larger than the required one.
_DOMAIN_MARGIN = 1.3


class BeyondSurfaceError(ValueError):
    """An atom can touch where the indenter is not defined.

    Parameters
    ----------
    indenter : Topography
    spacing : float
        Spacing of the atoms (length).
    radius : float
        Distance from the axis up to which atoms can touch (length).

    Attributes
    ----------
    problem, advice : str
        Description of the error, and advice.
    domain : int
        Side of the domain that is advised, in spacings; zero without advice.
    """

    def __init__(self, indenter: Topography, spacing: float, radius: float) -> None:
        self.radius = radius
        atoms = math.ceil(radius / spacing)
        reached = f"{radius / 10:.4g} nm"
        self.problem = (
            "atoms can touch beyond the indenter's surface, which is defined up to "
            f"{indenter.extent / 10:.4g} nm from its axis"
        )
        self.advice = "choose a smaller load or depth"
        self.domain, side = 0, math.ceil(_DOMAIN_MARGIN * 2 * atoms)
        needed = memory_of((0, 0), points=side**2)
        domain = f"a domain of {side} grid spacings, {side * spacing / 10:.4g} nm"
        if not indenter.repeats:
            inside = radius <= indenter.rough.middle_extent
            self.advice += (
                f", or a place {reached} from the edges (margin)"
                if inside
                else ", or a larger map"
            )
        elif needed < available_memory():
            self.domain = side
            self.advice = f"give the roughness {domain}, or more"
        else:
            self.advice += (
                f": a roughness with {domain}, would need "
                f"{needed / 1e9:.3g} GB of memory"
            )
        super().__init__(
            f"{self.problem}, at distances of up to {reached}: {self.advice}"
        )


class Footprint:
    """Bounding boxes of the level sets of an indenter on the lattice of atoms.

    The lowest heights of all rows and columns of atoms are kept; the bounding box of
    the atoms below any level follows from them.

    Parameters
    ----------
    indenter : Surface
        A surface with a method `reach`, such as `RoughSphere`.
    spacing : float
        Distance of neighbours (length).
    origin : (float, float)
        Position of any atom relative to the axis (length).

    Raises
    ------
    ValueError
        If its lowest height or a box is asked for, and it has no method `reach`.
    """

    def __init__(
        self,
        indenter: Surface,
        spacing: float,
        origin: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        self.indenter, self.spacing = topography_of(indenter), spacing
        x, y = origin
        self.offset = lattice_offset(x, spacing), lattice_offset(y, spacing)
        self._searched, self._searched_level = -1, -math.inf
        self._square = Box((0, 0), (0, 0))
        self._rows = self._columns = np.zeros(0)
        self._boxes: dict[float, Box] = {}  # by level

    @cached_property
    def lowest(self) -> float:
        """Lowest height of any atom."""
        self._search(_FIRST_HALF_SIDE)
        self._search(self._reach(float(self._rows.min())))
        return float(self._rows.min())

    @cached_property
    def domain(self) -> Box | None:
        """Box of the atoms where the surface is defined without repetition, if any.

        None if it is defined everywhere.
        """
        indenter = self.indenter
        if indenter.extent == math.inf:
            return None
        steps = indenter.extent / self.spacing + RATIO_ROUNDING
        if indenter.repeats:
            half = (math.floor(2 * steps) - 1) // 2
        else:
            half = math.floor(steps - max(map(abs, self.offset)) / self.spacing)
        return centred_box(half)

    def box_below(self, level: float) -> Box:
        """Return the bounding box of the lowest atom and all that are below a level.

        Parameters
        ----------
        level : float
            Height (length).

        Returns
        -------
        Box
            It extends beyond the domain if the surface repeats, else up to its edge.
        """
        level = max(level, np.nextafter(self.lowest, np.inf))
        if level not in self._boxes:
            if level > self._searched_level:
                self._search(self._reach(level))
                self._searched_level = level
            first_row, end_row = _ends(self._rows < level)
            first_column, end_column = _ends(self._columns < level)
            first, _ = self._square.start
            self._boxes[level] = Box(
                (first + first_row, first + first_column),
                (end_row - first_row, end_column - first_column),
            )
        return self._boxes[level]

    def clip(self, box: Box) -> Box:
        """Return the part of a box that is in the domain."""
        return box if self.domain is None else box.intersection(self.domain)

    def overlap(self, level: float) -> Box:
        """Return the part of `box_below` that is in the domain."""
        return self.clip(self.box_below(level))

    def check(self, level: float) -> None:
        """Raise `ValueError` unless all atoms below a level are in the domain."""
        if self.indenter.repeats:
            box = self.box_below(level)
        else:
            box = centred_box(self._reach(level))
        if self.domain is None or self.domain.contains(box):
            return
        atoms = max(*map(abs, box.start), *map(abs, box.stop))
        raise BeyondSurfaceError(self.indenter, self.spacing, atoms * self.spacing)

    def standard_size(self, box: Box) -> Box:
        """Return a box around another, of a standard size if the domain allows it."""
        start, shape = [], []
        for axis in (0, 1):
            n, first = _standard_side(box.shape[axis]), box.start[axis]
            low = first - (n - box.shape[axis]) // 2
            if self.domain is not None:
                n = max(min(n, self.domain.shape[axis]), box.shape[axis])
                low = max(min(low, self.domain.stop[axis] - n), self.domain.start[axis])
            start.append(low)
            shape.append(n)
        return Box((start[0], start[1]), (shape[0], shape[1]))

    def heights(self, window: Box) -> np.ndarray:
        """Return the heights at the atoms of a window, shape of the window."""
        x, y = (
            start * self.spacing + offset
            for start, offset in zip(window.start, self.offset, strict=True)
        )
        return self.indenter.heights(window.shape, self.spacing, (x, y))

    def _reach(self, level: float) -> int:
        reach = self.indenter.reach(level, self.spacing, self.offset)
        return math.ceil(reach / self.spacing)

    def _search(self, distance: int) -> None:
        """Find the lowest heights of rows and columns up to a distance.

        Tiles that an earlier search has covered are left out.
        """
        if distance <= self._searched:
            return
        distance = max(distance, round(_SEARCH_GROWTH * self._searched))
        searched_before, self._searched = self._searched, distance
        square = centred_box(distance)
        if not self.indenter.repeats:
            square = self.clip(square)
        rows, columns = np.full((2, square.shape[0]), np.inf)
        inside, _ = self._square.slices_in(square)
        rows[inside], columns[inside] = self._rows, self._columns
        self._square, self._rows, self._columns = square, rows, columns
        for tile in self.tiles(square):
            (i, j), (k, m) = tile.start, tile.stop
            nearest = math.hypot(max(i, 1 - k, 0), max(j, 1 - m, 0))
            farthest = math.hypot(max(-i, k - 1), max(-j, m - 1))
            if nearest > distance + 1 or farthest <= searched_before:
                continue
            heights = self.heights(tile)
            along, across = tile.slices_in(square)
            rows[along] = np.minimum(rows[along], heights.min(axis=1))
            columns[across] = np.minimum(columns[across], heights.min(axis=0))

    def tiles(self, box: Box) -> Iterator[Box]:
        """Split a box into tiles of limited size."""
        side = _TILE_SIDE
        if self.domain is not None:
            side = min(side, *self.domain.shape)
        (i, j), (k, m) = box.start, box.stop
        for first in range(i, k, side):
            for second in range(j, m, side):
                yield Box((first, second), (side, side)).intersection(box)


def centred_box(half_side: int) -> Box:
    """Return the square of the atoms up to a distance from the axis along x and y."""
    return Box((-half_side, -half_side), (2 * half_side + 1,) * 2)


def _ends(mask: np.ndarray) -> tuple[int, int]:
    """Return the first true index of a mask, and the index after the last one."""
    return int(mask.argmax()), mask.size - int(mask[::-1].argmax())


def _standard_side(least: int) -> int:
    """Return the next side of the sequence, with a padded grid of fast transforms."""
    ratio = _SIDE_RATIO if least < _LARGE_SIDE else _LARGE_SIDE_RATIO
    steps = math.ceil(math.log(max(least, _MIN_SIDE), ratio) - RATIO_ROUNDING)
    return (fast_length(2 * math.ceil(ratio**steps) - 1) + 1) // 2
