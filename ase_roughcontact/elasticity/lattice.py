"""Boxes of lattice indices: which surface atoms belong to a window."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Box:
    """Rectangle of atoms.

    Attributes
    ----------
    start : (int, int)
        First atom along x and y, in spacings from the indenter's axis.
    shape : (int, int)
        Number of atoms.
    """

    start: tuple[int, int]
    shape: tuple[int, int]

    @property
    def stop(self) -> tuple[int, int]:
        """First atom beyond."""
        (i, j), (n, m) = self.start, self.shape
        return i + n, j + m

    @property
    def size(self) -> int:
        """Number of atoms."""
        return math.prod(self.shape)

    @property
    def slices(self) -> tuple[slice, slice]:
        """Where it is in an array whose first atom is at ``(0, 0)``."""
        first, second = map(slice, self.start, self.stop)
        return first, second

    @classmethod
    def between(cls, start: tuple[int, int], stop: tuple[int, int]) -> Box:
        """Box from first atoms to those beyond the last."""
        return cls(start, (stop[0] - start[0], stop[1] - start[1]))

    @classmethod
    def bounding(cls, mask: np.ndarray, start: tuple[int, int]) -> Box | None:
        """Smallest box of the true entries of a mask that begins at `start`."""
        if not mask.any():
            return None
        rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
        return cls(
            (start[0] + int(rows[0]), start[1] + int(columns[0])),
            (int(rows[-1] - rows[0]) + 1, int(columns[-1] - columns[0]) + 1),
        )

    def contains(self, other: Box) -> bool:
        """Whether all atoms of another box are in this one."""
        return self.union(other) == self

    def union(self, other: Box | None) -> Box:
        """Smallest box that holds two."""
        if other is None:
            return self
        (i, j), (k, m) = (
            np.minimum(self.start, other.start),
            np.maximum(self.stop, other.stop),
        )
        return Box.between((int(i), int(j)), (int(k), int(m)))

    def intersection(self, other: Box) -> Box:
        """Atoms that are in both, which must overlap."""
        (i, j), (k, m) = (
            np.maximum(self.start, other.start),
            np.minimum(self.stop, other.stop),
        )
        return Box.between((int(i), int(j)), (int(k), int(m)))

    def index(self, part: Box) -> tuple[slice, slice]:
        """Where a part is in an array of this box."""
        first, second = (
            slice(a - b, a - b + n)
            for a, b, n in zip(part.start, self.start, part.shape, strict=True)
        )
        return first, second
