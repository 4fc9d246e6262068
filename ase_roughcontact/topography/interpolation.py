"""Interpolation of a height map by cubic splines, not-a-knot or periodic."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_interp_spline

from ase_roughcontact._util.validation import FloatArray

#: Distance, in steps of a map, within which a grid point counts as a point of the map.
ROUNDING = 1e-9


def spline_coefficients(values: FloatArray, periodic: bool) -> FloatArray:
    """Return the coefficients of the B-splines of a map, shape of the map or more."""
    for axis in (0, 1):
        # a spline keeps them with its axis in front
        values = np.moveaxis(_spline(values, axis, periodic).c, 0, axis)
    return values


def interpolated(
    values: FloatArray, indices: NDArray[Any], axis: int, periodic: bool
) -> FloatArray:
    """Return values at fractional indices of one axis; exact at whole ones."""
    n = values.shape[axis]
    whole = np.rint(indices)
    if np.abs(indices - whole).max() <= ROUNDING:
        return values.take(whole.astype(int) % n, axis)
    inside = indices % n if periodic else indices.clip(0, n - 1)
    return _spline(values, axis, periodic)(inside)


def _spline(values: FloatArray, axis: int, periodic: bool) -> BSpline:
    """Return the cubic spline along an axis, as a function of the index."""
    if values.shape[axis] < 4:
        raise ValueError(
            "interpolation needs a map of at least 4 x 4 points, got "
            f"{values.shape[axis]} along a side"
        )
    if periodic:
        values = np.concatenate([values, values.take([0], axis)], axis)
    ends = "periodic" if periodic else "not-a-knot"
    return make_interp_spline(
        np.arange(values.shape[axis]), values, 3, axis=axis, bc_type=ends
    )
