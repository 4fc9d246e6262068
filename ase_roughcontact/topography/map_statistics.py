"""Statistics of a height map as it is pressed, and of its edges."""

from __future__ import annotations

import math

import numpy as np

from ase_roughcontact._util.validation import FloatArray, Point
from ase_roughcontact.topography.interpolation import mean_squares
from ase_roughcontact.topography.spectrum import Statistics

# Rms difference of opposite edges over that of neighbours from which it is a step.
_STEP = 2.0


def pressed_statistics(
    heights: FloatArray, spacing: Point, periodic: bool
) -> Statistics:
    """Return the rms height, slope and curvature of a map as it is pressed.

    They are exact for the spline, but for the height, which is that of the points,
    and without the seam of a periodic map whose edges do not fit each other.
    """
    seamless = periodic and not has_edge_step(heights)
    squares = mean_squares(heights, spacing, seamless)
    return Statistics(float(heights.std()), *map(math.sqrt, squares))


def has_edge_step(heights: FloatArray) -> bool:
    """Return whether opposite edges of heights do not fit each other."""
    across, beside = edge_step(heights)
    return across > _STEP * beside


def edge_step(heights: FloatArray) -> tuple[float, float]:
    """Return the rms difference of opposite edges, and of neighbouring lines (length).

    Along the axis along which the first is the larger multiple of the second.
    """
    found = []
    for axis in (0, 1):
        steps = np.diff(heights, axis=axis, append=heights.take([0], axis))
        square = np.moveaxis(steps**2, axis, 0).mean(axis=1)
        found.append((math.sqrt(square[-1]), math.sqrt(square[:-1].mean())))
    return max(found, key=lambda pair: pair[0] / pair[1] if pair[1] else 0.0)
