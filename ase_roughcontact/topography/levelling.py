"""Levelling of scans: tilt, bow and offsets of lines, and points that are missing."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import spsolve

from ase_roughcontact._util.validation import FloatArray, lookup

# Number of a point that is not missing.
_NOT_MISSING = -1
# Number of a point beyond the edges of a scan.
_BEYOND_EDGE = -2


def filled(heights: FloatArray, periodic: bool) -> FloatArray:
    """Return heights with missing points, which are NaN, interpolated.

    The heights there solve Laplace's equation, with the known heights around them as
    boundary values, which leaves no artificial peaks: each is the mean of its
    neighbours.

    Raises
    ------
    ValueError
        If all points are missing.
    """
    missing = np.isnan(heights)
    if missing.all():
        raise ValueError("all points of the scan are missing: give another channel")
    if not missing.any():
        return heights
    i, j = missing.nonzero()
    size = len(i)
    number = np.full(heights.shape, _NOT_MISSING)
    number[i, j] = np.arange(size)
    beyond: Any = {"mode": "wrap"} if periodic else {"constant_values": _BEYOND_EDGE}
    number, padded = np.pad(number, 1, **beyond), np.pad(heights, 1, **beyond)
    around = np.array([i, i + 2, i + 1, i + 1]), np.array([j + 1, j + 1, j, j + 2])
    neighbour = number[around]
    right = np.where(neighbour == _NOT_MISSING, padded[around], 0.0).sum(axis=0)
    linked = neighbour >= 0
    row = linked.nonzero()[1]
    links = coo_matrix((np.ones(row.size), (row, neighbour[linked])), (size, size))
    count = diags((neighbour != _BEYOND_EDGE).sum(axis=0, dtype=float))
    heights = heights.copy()
    heights[i, j] = spsolve((count - links).tocsc(), right)
    return heights


def levelled(heights: FloatArray, detrend: str) -> FloatArray:
    """Return heights without tilt, curvature or offsets of lines.

    See `HeightMap.from_topography`. Missing points are not taken into account.
    """
    trends: dict[str, Any] = {
        "lines": _lines,
        "medians": _medians,
        "none": np.zeros_like,
        "mean": partial(polynomial, degree=0),
        "plane": partial(polynomial, degree=1),
        "curvature": partial(polynomial, degree=2),
    }
    return heights - lookup(detrend, trends, "way to detrend")(heights)


def polynomial(heights: FloatArray, degree: int) -> FloatArray:
    """Return the polynomial in x and y that fits the known heights, at all points."""
    x, y = (np.linspace(-1.0, 1.0, n) for n in heights.shape)
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    terms = np.array([x[:, None] ** i * y**j for i, j in powers])
    known = ~np.isnan(heights)
    fit, *_ = np.linalg.lstsq(terms[:, known].T, heights[known], rcond=None)
    return np.tensordot(fit, terms, 1)


def _lines(heights: FloatArray) -> FloatArray:
    """Return the straight lines that fit the scan lines (along x) best."""
    places = np.linspace(-1.0, 1.0, len(heights))[:, None] + np.zeros_like(heights)
    missing = np.isnan(heights)
    x: Any = np.ma.array(places, mask=missing)
    z: Any = np.ma.array(heights, mask=missing)
    distance, middle = x - x.mean(axis=0), z.mean(axis=0)
    slope = (distance * (z - middle)).sum(axis=0) / (distance**2).sum(axis=0)
    lines = middle + np.ma.filled(slope, 0.0) * (places - x.mean(axis=0))
    return np.ma.filled(lines, 0.0)


def _medians(heights: FloatArray) -> FloatArray:
    """Return offsets of lines by the medians of steps between lines, and a plane.

    A step is the median, along x, of the differences of two neighbouring lines. It
    hardly depends on features that are on less than half of a line.
    """
    steps = median_steps(heights)
    offsets = np.append(0.0, np.nan_to_num(steps).cumsum())
    return polynomial(heights - offsets, 1) + offsets


def median_steps(heights: FloatArray) -> FloatArray:
    """Return the medians along x of the steps between lines; NaN if not known."""
    steps: Any = np.ma.masked_invalid(np.diff(heights, axis=1))
    return np.ma.filled(np.ma.median(steps, axis=0), np.nan)
