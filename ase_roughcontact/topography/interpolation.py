"""Interpolation of a height map by cubic splines, not-a-knot or periodic."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, make_interp_spline

from ase_roughcontact._util.validation import FloatArray

#: Distance, in steps of a map, within which a grid point counts as a point of the map.
ROUNDING = 1e-9


def spline_coefficients(values: FloatArray, periodic: bool) -> FloatArray:
    """Return the coefficients of the B-splines of a map, shape of the map or more."""
    for axis in (0, 1):
        _check_points(values.shape[axis])
        if periodic:
            values = np.concatenate([values, values.take([0], axis)], axis)
        ends = "periodic" if periodic else "not-a-knot"
        points = np.arange(values.shape[axis])
        values = make_interp_spline(points, values, 3, axis=axis, bc_type=ends).c
    return values


def interpolated(
    values: FloatArray, indices: NDArray[Any], axis: int, periodic: bool
) -> FloatArray:
    """Return values at fractional indices of one axis; exact at whole ones."""
    n = values.shape[axis]
    whole = np.rint(indices)
    if np.abs(indices - whole).max() <= ROUNDING:
        return values.take(whole.astype(int) % n, axis)
    _check_points(n)
    if periodic:
        values = np.concatenate([values, values.take([0], axis)], axis)
        spline = CubicSpline(np.arange(n + 1), values, axis, bc_type="periodic")
        return spline(indices % n)
    return CubicSpline(np.arange(n), values, axis)(indices.clip(0, n - 1))


def _check_points(n: int) -> None:
    if n < 4:
        raise ValueError(
            f"interpolation needs a map of at least 4 x 4 points, got {n} along a side"
        )
