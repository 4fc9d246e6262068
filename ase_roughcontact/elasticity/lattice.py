"""Places of atoms on the lattice: a box of them, or a few anywhere."""

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
    def around(cls, mask: np.ndarray, start: tuple[int, int]) -> Box | None:
        """Smallest box of the true entries of a mask that begins at `start`."""
        if not mask.any():
            return None
        rows, columns = (np.flatnonzero(mask.any(axis=axis)) for axis in (1, 0))
        return cls(
            (start[0] + int(rows[0]), start[1] + int(columns[0])),
            (int(rows[-1] - rows[0]) + 1, int(columns[-1] - columns[0]) + 1),
        )

    def around_those(self, mask: np.ndarray) -> Box | None:
        """Smallest box of the atoms that a mask on this one tells."""
        return Box.around(mask, self.start)

    def holds(self, other: Box) -> bool:
        """Whether all atoms of another box are in this one."""
        return self.join(other) == self

    def join(self, other: Box | None) -> Box:
        """Smallest box that holds two."""
        if other is None:
            return self
        (i, j), (k, m) = (
            np.minimum(self.start, other.start),
            np.maximum(self.stop, other.stop),
        )
        return Box.between((int(i), int(j)), (int(k), int(m)))

    def meet(self, other: Box) -> Box:
        """Atoms that are in both, which must overlap."""
        (i, j), (k, m) = (
            np.maximum(self.start, other.start),
            np.minimum(self.stop, other.stop),
        )
        return Box.between((int(i), int(j)), (int(k), int(m)))

    def places(self, values: np.ndarray) -> np.ndarray:
        """Atoms, shape (k, 2), at which an array of the box is not zero."""
        return np.argwhere(values) + self.start

    def find(self, places: np.ndarray) -> tuple[np.ndarray, tuple]:
        """Tell which places are in the box, and their indices in an array of it."""
        index = places - self.start
        inside: np.ndarray = np.all((index >= 0) & (index < self.shape), axis=1)
        return inside, tuple(index[inside].T)

    def index(self, part: Box) -> tuple[slice, slice]:
        """Where a part is in an array of this box."""
        first, second = (
            slice(a - b, a - b + n)
            for a, b, n in zip(part.start, self.start, part.shape, strict=True)
        )
        return first, second


@dataclass(frozen=True, eq=False)
class Sites:
    """Atoms anywhere.

    Attributes
    ----------
    all : ndarray of int, shape (k, 2)
        Along x and y, in spacings from the indenter's axis.
    """

    all: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """Shape of an array of the sites, a column."""
        return len(self.all), 1

    @property
    def size(self) -> int:
        """Number of atoms."""
        return len(self.all)

    @property
    def box(self) -> Box:
        """Smallest box that holds them."""
        (i, j), (k, m) = self.all.min(axis=0), self.all.max(axis=0) + 1
        return Box.between((int(i), int(j)), (int(k), int(m)))

    def places(self, values: np.ndarray) -> np.ndarray:
        """Atoms, shape (k, 2), at which a column is not zero."""
        return self.all[np.flatnonzero(values)]

    def around_those(self, mask: np.ndarray) -> Box | None:
        """Smallest box of the atoms that a mask on these tells."""
        return Sites(self.places(mask)).box if mask.any() else None

    def find(self, places: np.ndarray) -> tuple[np.ndarray, tuple]:
        """Tell which places are among the sites, and their indices in a column."""
        index = {tuple(site): n for n, site in enumerate(self.all.tolist())}
        found = np.array(
            [index.get(tuple(at), -1) for at in places.tolist()], dtype=int
        )
        inside = found >= 0
        return inside, (found[inside], np.zeros(inside.sum(), dtype=int))
