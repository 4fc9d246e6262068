"""Lists of points x, y, z on a regular grid."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ase_roughcontact._util.validation import FloatArray

# Largest distance of a point from the regular grid, in steps of the grid.
_PLACE_TOLERANCE = 0.05
# Largest share of the lines of a grid along which no point was measured.
_MAX_ABSENT_SHARE = 0.5


def grid_of_points(points: FloatArray) -> tuple[FloatArray, tuple[float, float]]:
    """Return heights on a grid, shape (n, m), and the distances of its points.

    Parameters
    ----------
    points : ndarray, shape (3, number of points)
        Places x and y, and heights z, in any order. Points may be absent, and so may
        lines of the grid; heights are NaN there.

    Raises
    ------
    ValueError
        If the places are not on a regular grid, or a place is listed with two heights.
    """
    (i, x), (j, y) = (_numbers(points[axis], "xy"[axis]) for axis in (0, 1))
    shape = i.max() + 1, j.max() + 1
    order = np.lexsort((j, i))
    i, j, z = i[order], j[order], points[2][order]
    twice = (np.diff(i) == 0) & (np.diff(j) == 0)
    differ = abs(np.diff(z))[twice]
    if (differ > 0.0).any():
        raise ValueError(
            f"{differ.size} points are listed twice, with heights that differ by up to "
            f"{np.nanmax(differ):.3g}: keep one scan (trace or retrace) in the file"
        )
    heights = np.full(shape, np.nan)
    heights[i, j] = z
    return heights, (x, y)


def _numbers(values: FloatArray, name: str) -> tuple[NDArray[Any], float]:
    """Return numbers of grid lines, from 0, of places along an axis, and their step."""
    distinct, indices = np.unique(values, return_inverse=True)
    gaps = np.diff(distinct)
    if not gaps.size:
        raise ValueError(f"all points have the same {name}: {values[0]:g}")
    # the widest gap is one step, or several if grid lines are absent
    for steps in range(1, len(distinct) + 1):
        places = np.append(0, np.rint(gaps * (steps / gaps.max())).cumsum())
        occupied = len(np.unique(places))
        if occupied < _MAX_ABSENT_SHARE * (places[-1] + 1):
            break
        step = (distinct[-1] - distinct[0]) / places[-1]
        if abs((distinct - distinct[0]) / step - places).max() <= _PLACE_TOLERANCE:
            return places.astype(int)[indices], float(step)
    raise ValueError(
        f"the points (x, y, z) are not on a regular grid along {name}: interpolate "
        "them, for example with scipy.interpolate.griddata, and give the array"
    )
