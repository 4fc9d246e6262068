"""What the other packages need to know of an indenter: its heights."""

from __future__ import annotations

import math
from typing import Any, Protocol, runtime_checkable

from ase_roughcontact._util.validation import FloatArray, Point, Shape


class Surface(Protocol):
    """Lower side of an indenter.

    Any object with the method `heights` can be an indenter, or the roughness of a
    `RoughSphere`. A path that is written to files also needs `todict`, which subclasses
    inherit.
    """

    def heights(
        self, shape: Shape, spacing: float, origin: Point = (0.0, 0.0)
    ) -> FloatArray:
        """Sample the lower side of the indenter on a grid.

        Parameters
        ----------
        shape : tuple of int
            Grid points (n, m) along x and y.
        spacing : float
            Distance between grid points (length).
        origin : tuple of float
            Position (x, y) of grid point (0, 0) relative to the indenter's axis
            (length).

        Returns
        -------
        ndarray, shape (n, m)
            Heights, positive upward, away from the substrate (length).
        """
        ...

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters of the surface, for files.

        They are strings and numbers, the same for the same surface: a trajectory stores
        them, and a path is resumed only with the same surface. By default the name of
        the class and the attributes of the object.
        """
        return {"name": type(self).__name__, **vars(self)}


@runtime_checkable
class BoundedSurface(Surface, Protocol):
    """Surface that rises with the distance from its axis, like a sphere.

    Automatic windows need to know beyond which distance the indenter cannot touch. A
    subclass defines `heights` and `reach`.
    """

    def reach(self, level: float, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return the distance from the axis beyond which no atom is below a level.

        Parameters
        ----------
        level : float
            Height (length).
        spacing : float
            Distance between atoms (length).
        origin : tuple of float
            Position (x, y) of one of them relative to the axis (length).

        Returns
        -------
        float
            Length; an upper bound is enough.
        """
        ...

    @property
    def extent(self) -> float:
        """Distance from the axis, along x and y, up to which heights are known.

        By default infinity; of a periodic surface half of the period (length).
        """
        return math.inf

    @property
    def repeats(self) -> bool:
        """Whether the surface is periodic beyond the extent; by default not."""
        return False
