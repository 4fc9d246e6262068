"""Grid of squares for a periodic map with pixels that may be no squares."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ase_roughcontact._util.rounding import RATIO_ROUNDING
from ase_roughcontact._util.validation import Point, Shape

# Strain that is small enough.
_MAX_STRAIN = 1e-3
# Largest number of points along x over the least number.
_MAX_POINT_RATIO = 1.25


@dataclass(frozen=True)
class SquareGrid:
    """Grid of squares on the period of a map.

    Attributes
    ----------
    shape : (int, int)
        Number of points along x and y.
    spacing : float
        Distance of the points (length).
    strain : float
        Relative change of lengths along y that makes the period a whole number of
        spacings.
    """

    shape: Shape
    spacing: float
    strain: float = 0.0

    @classmethod
    def of(cls, shape: Shape, spacing: Point) -> SquareGrid:
        """Return the grid of a periodic map with points at distances along x and y.

        It has the points of the map if its pixels are squares. Else the spacing is the
        smaller distance, or slightly less, where this makes the strain smaller.
        """
        (n, m), (x, y) = shape, spacing
        if math.isclose(x, y, rel_tol=RATIO_ROUNDING):
            return cls(shape, x)
        width, length = n * x, m * y
        least = math.ceil(width / min(x, y) * (1.0 - RATIO_ROUNDING))
        grids = []
        for points in range(least, math.ceil(_MAX_POINT_RATIO * least) + 1):
            step = width / points
            lines = max(round(length / step), 1)
            grids.append(cls((points, lines), step, lines * step / length - 1.0))
            if abs(grids[-1].strain) <= _MAX_STRAIN:
                return grids[-1]
        return min(grids, key=lambda grid: abs(grid.strain))
