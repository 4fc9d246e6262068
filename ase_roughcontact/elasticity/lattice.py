"""Rectangles of lattice indices, which describe windows and parts of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

# Rounding error of a position, in spacings.
_POSITION_ERROR = 1e-9


@dataclass(frozen=True)
class Box:
    """A rectangle of lattice indices.

    Attributes
    ----------
    start : (int, int)
        Index of the first atom along x and y.
    shape : (int, int)
        Number of atoms along x and y.
    """

    start: tuple[int, int]
    shape: tuple[int, int]

    @property
    def stop(self) -> tuple[int, int]:
        """Index after the last atom along x and y."""
        (i, j), (n, m) = self.start, self.shape
        return i + n, j + m

    @property
    def size(self) -> int:
        """Number of atoms."""
        return math.prod(self.shape)

    @property
    def slices(self) -> tuple[slice, slice]:
        """Slices of an array that begins at the lattice index (0, 0)."""
        return self.slices_in(Box((0, 0), self.stop))

    def slices_in(self, outer: Box) -> tuple[slice, slice]:
        """Return the slices of an array on an outer box that this box covers."""
        row = self.start[0] - outer.start[0]
        column = self.start[1] - outer.start[1]
        n, m = self.shape
        return slice(row, row + n), slice(column, column + m)

    @classmethod
    def between(cls, start: tuple[int, int], stop: tuple[int, int]) -> Box:
        """Return the box from `start` up to, but not including, `stop`."""
        return cls(start, (stop[0] - start[0], stop[1] - start[1]))

    @classmethod
    def bounding(cls, mask: np.ndarray, start: tuple[int, int] = (0, 0)) -> Box | None:
        """Return the bounding box of the true entries of a mask; None without any.

        `start` is the lattice index of its first entry.
        """
        rows = np.flatnonzero(mask.any(axis=1))
        columns = np.flatnonzero(mask.any(axis=0))
        if not rows.size:
            return None
        return cls(
            (start[0] + int(rows[0]), start[1] + int(columns[0])),
            (int(rows[-1] - rows[0]) + 1, int(columns[-1] - columns[0]) + 1),
        )

    def contains(self, other: Box) -> bool:
        """Return whether another box lies within this one."""
        return self.union(other) == self

    def union(self, other: Box | None) -> Box:
        """Return the smallest box that contains this box and another one."""
        if other is None:
            return self
        (i, j), (k, m) = self.start, self.stop
        (other_i, other_j), (other_k, other_m) = other.start, other.stop
        return Box.between(
            (min(i, other_i), min(j, other_j)), (max(k, other_k), max(m, other_m))
        )

    def intersection(self, other: Box) -> Box:
        """Return the indices in both boxes; a side is negative if they are apart."""
        i, j = np.maximum(self.start, other.start)
        k, m = np.minimum(self.stop, other.stop)
        return Box.between((int(i), int(j)), (int(k), int(m)))


def lattice_index(position: float, spacing: float) -> int:
    """Return the index of the lattice point nearest to a position.

    Half-way between two points the upper one is taken, so that positions a whole number
    of spacings apart have indices this number apart.
    """
    return math.floor(position / spacing + 0.5 + _POSITION_ERROR)


def lattice_offset(position: float, spacing: float) -> float:
    """Return a position relative to the nearest lattice point, without rounding."""
    offset = position - spacing * lattice_index(position, spacing)
    return 0.0 if abs(offset) < _POSITION_ERROR * spacing else offset


def carried(values: np.ndarray, old: Box, new: Box, outside: float = 0.0) -> np.ndarray:
    """Return the values of an old window on a new one, others outside of the old one.

    The values have any dtype, and may have more axes after the two of the window.
    """
    shape = (*new.shape, *values.shape[2:])
    result = np.full(shape, outside, values.dtype)
    common = old.intersection(new)
    if min(common.shape) > 0:
        result[common.slices_in(new)] = values[common.slices_in(old)]
    return result
