"""Base classes of indenters: their heights and a name."""

from __future__ import annotations

import hashlib
import json
import math
from typing import Any, Protocol, runtime_checkable

import numpy as np

from ase_roughcontact._util.identity import digest
from ase_roughcontact._util.validation import (
    FloatArray,
    Point,
    Shape,
    check_heights,
    unmasked,
)


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
            Distance, or an upper bound of it (length).
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


def sampled_heights(
    indenter: Surface, shape: Shape, spacing: float, origin: Point
) -> np.ndarray:
    """Return the heights of an indenter; see `Surface.heights`.

    Raises
    ------
    ValueError
        If they are not a matrix of finite real numbers.
    """
    heights = unmasked(indenter.heights(shape, spacing, origin))
    check_heights(heights)
    return heights


def surface_id(surface: Surface | None) -> str | None:
    """Return a name that is the same for the same surface only.

    It is the name of the class and a digest of ``surface.todict()``; None if the
    surface does not have this method, or returns something that JSON cannot represent.
    """
    try:
        text = json.dumps(surface.todict(), default=_plain)  # type: ignore[union-attr]
    except (AttributeError, TypeError, ValueError):
        return None
    # 10 and 10.0 are the same radius
    numbers = json.dumps(json.loads(text, parse_int=float), sort_keys=True)
    return f"{type(surface).__name__}-{digest(numbers.encode())}"


def _plain(value: Any) -> Any:
    """Return a value that JSON can represent in place of one of NumPy's types."""
    if isinstance(value, np.ndarray):
        return [value.shape, hashlib.sha256(value.tobytes()).hexdigest()]
    if isinstance(value, np.generic):
        return value.item()
    raise TypeError(f"{type(value).__name__} is not supported")
