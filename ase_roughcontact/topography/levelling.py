"""Levelling of scans: tilt, bow and offsets of lines, and points that are missing."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import spsolve

from ase_roughcontact._util.validation import FloatArray, lookup

# Numbers of points that are not missing, and beyond the edges of a scan.
_KNOWN, _BEYOND = -1, -2


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
        raise ValueError("all points of the scan are missing")
    if not missing.any():
        return heights
    i, j = missing.nonzero()
    size = len(i)
    number = np.full(heights.shape, _KNOWN)
    number[i, j] = np.arange(size)
    beyond: Any = {"mode": "wrap"} if periodic else {"constant_values": _BEYOND}
    number, padded = np.pad(number, 1, **beyond), np.pad(heights, 1, **beyond)
    around = np.array([i, i + 2, i + 1, i + 1]), np.array([j + 1, j + 1, j, j + 2])
    neighbour = number[around]
    right = np.where(neighbour == _KNOWN, padded[around], 0.0).sum(axis=0)
    linked = neighbour >= 0
    row = linked.nonzero()[1]
    links = coo_matrix((np.ones(row.size), (row, neighbour[linked])), (size, size))
    count = diags((neighbour != _BEYOND).sum(axis=0, dtype=float))
    heights = heights.copy()
    heights[i, j] = spsolve((count - links).tocsc(), right)
    return heights


def levelled(heights: FloatArray, detrend: str) -> FloatArray:
    """Return heights without tilt, curvature or offsets of lines.

    See `HeightMap.from_topography`. Missing points are not taken into account.
    """
    degrees = {"mean": 0, "plane": 1, "curvature": 2}
    trends: dict[str, Any] = {"lines": _lines, "medians": _medians}
    trends["none"] = np.zeros_like
    trends |= {k: partial(polynomial, degree=n) for k, n in degrees.items()}
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
    known, x = (np.ma.array(each, mask=np.isnan(heights)) for each in (heights, places))
    distance, middle = x - x.mean(axis=0), known.mean(axis=0)
    slope = (distance * (known - middle)).sum(axis=0) / (distance**2).sum(axis=0)
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
