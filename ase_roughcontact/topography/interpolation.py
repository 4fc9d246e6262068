"""Interpolation of a height map by cubic splines, not-a-knot or periodic."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import fft, sparse
from scipy.interpolate import BSpline, make_interp_spline

from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact._util.validation import FloatArray

# Degree of the splines.
_DEGREE = 3


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
    if np.abs(indices - whole).max() <= LENGTH_ROUNDING:
        return values.take(whole.astype(int) % n, axis)
    inside = indices % n if periodic else indices.clip(0, n - 1)
    return _spline(values, axis, periodic)(inside)


def mean_squares(
    values: FloatArray, spacing: tuple[float, float], periodic: bool
) -> tuple[float, float]:
    r"""Return the exact mean squares of slope and curvature of the spline of a map.

    With the coefficients c of the B-splines and, along x and y, the means
    :math:`M_{ab} = \langle B^{(a)} B^{(b)} \rangle` of products of their derivatives,
    :math:`\langle \partial_x^a \partial_y^k h \; \partial_x^b \partial_y^l h \rangle =
    \sum c \circ (M_{ab}\, c\, M_{kl}^T)`.
    """
    x, y = spacing
    along_x = _derivatives(_spline(values, 0, periodic))
    along_y = _derivatives(_spline(values, 1, periodic))
    c = spline_coefficients(values - values.mean(), periodic)

    def mean(a: int, b: int, k: int, m: int) -> float:
        left, right = along_x[a].T @ along_x[b], along_y[k].T @ along_y[m]
        product = float(np.sum(c * (right @ (left @ c).T).T))
        return product / (x ** (a + b) * y ** (k + m))

    slope = mean(1, 1, 0, 0) + mean(0, 0, 1, 1)
    curvature = mean(2, 2, 0, 0) + 2.0 * mean(2, 0, 0, 2) + mean(0, 0, 2, 2)
    return max(slope, 0.0), max(curvature, 0.0)  # rounding


def _derivatives(spline: BSpline) -> list[Any]:
    """Return matrices from coefficients to a spline and its two derivatives.

    They are values at Gaussian points, times the root of their weights, by the index.
    """
    points, weights = np.polynomial.legendre.leggauss(_DEGREE + 1)
    ends = np.unique(spline.t[_DEGREE : len(spline.t) - _DEGREE])
    width = np.diff(ends)[:, None]
    places = (ends[:-1, None] + 0.5 * width * (points + 1.0)).ravel()
    root = sparse.diags(np.sqrt(0.5 * width * weights / np.ptp(ends)).ravel())
    t, size = spline.t, len(spline.t) - _DEGREE - 1
    matrices, change = [], sparse.identity(size)
    for degree in range(_DEGREE, 0, -1):
        matrices.append(root @ BSpline.design_matrix(places, t, degree) @ change)
        scale = degree / (t[degree + 1 : -1] - t[1 : -degree - 1])
        steps = sparse.diags([-scale, scale], [0, 1], (len(scale), len(scale) + 1))
        change, t = steps @ change, t[1:-1]
    return matrices


def _spline(values: FloatArray, axis: int, periodic: bool) -> BSpline:
    """Return the cubic spline along an axis, as a function of the index."""
    if values.shape[axis] < 4:
        raise ValueError(
            "interpolation needs a map of at least 4 x 4 points, got "
            f"{values.shape[axis]} along a side"
        )
    if periodic:
        return _periodic_spline(values, axis)
    return make_interp_spline(
        np.arange(values.shape[axis]), values, _DEGREE, axis=axis, bc_type="not-a-knot"
    )


def _periodic_spline(values: FloatArray, axis: int) -> BSpline:
    """Return the periodic cubic spline along an axis, as a function of the index.

    Its coefficients c solve (c[i - 1] + 4 c[i] + c[i + 1])/6 = values[i], which is a
    division of Fourier transforms.
    """
    n = values.shape[axis]
    weights = (2.0 + np.cos(2.0 * np.pi * np.fft.rfftfreq(n))) / 3.0
    spectrum = np.moveaxis(fft.rfft(values, axis=axis), axis, -1) / weights
    coefficients = np.moveaxis(fft.irfft(spectrum, n), -1, axis)
    around = coefficients.take(np.arange(-1, n + _DEGREE - 1), axis, mode="wrap")
    knots = np.arange(-_DEGREE, n + _DEGREE + 1.0)
    return BSpline(knots, around, _DEGREE, extrapolate="periodic", axis=axis)
