r"""Functions of the direction with the symmetry of a square lattice.

A function that is even in x and in y and unchanged when they are exchanged is a cosine
series of the angle,

.. math:: f(\phi) = \sum_k c_k \cos 4 k \phi = \sum_k c_k T_k(t), \qquad
          t = \cos 4 \phi = 1 - \frac{8 x^2 y^2}{(x^2 + y^2)^2},

with Chebyshev polynomials :math:`T_k`. The inverse moduli of an anisotropic half space
are such functions, and so are its Green's functions along the surface. Lateral
components have fewer symmetries, and are the real part of :math:`\sum_n c_n
e^{2 i n \phi}`; those that couple lateral and normal motion have odd orders
:math:`2 n + 1`.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np
from numpy.polynomial.chebyshev import chebfit, chebpts1, chebval
from numpy.polynomial.legendre import leggauss
from numpy.polynomial.polynomial import polyval
from scipy.fft import rfft

# Harmonics of a function of the direction, and the size below which they are left out.
_HARMONICS, _NEGLIGIBLE = 40, 1e-13
# Distance, in cells, up to which the integral over a cell is taken along its edges.
_EDGES_UP_TO = 32
_POINTS, _WEIGHTS = leggauss(40)


def angular_series(
    function: Callable[[np.ndarray], np.ndarray], harmonics: int = _HARMONICS
) -> np.ndarray:
    """Return the coefficients ``c_k`` of a function ``sum c_k cos(4 k phi)``.

    The function takes angles between 0 and pi/4, shape (n,). The first coefficient is
    its mean; small ones at the end are left out.
    """
    values = function(np.arccos(chebpts1(_HARMONICS)) / 4)
    coefficients = chebfit(chebpts1(_HARMONICS), values, _HARMONICS - 1)
    kept = np.flatnonzero(abs(coefficients) > _NEGLIGIBLE * abs(coefficients).max())
    return coefficients[: min(kept.max(initial=0) + 1, harmonics)]


def cos4(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return ``cos(4 phi)`` of vectors (x, y), one of the origin."""
    x2, y2 = np.square(x), np.square(y)
    total = x2 + y2
    return 1.0 - 8.0 * x2 * y2 / np.where(total > 0.0, total, 1.0) ** 2


def cos2(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return ``cos(2 phi)`` of vectors (x, y), zero for the origin."""
    x2, y2 = np.square(x, dtype=float), np.square(y, dtype=float)
    return (x2 - y2) / np.maximum(x2 + y2, np.finfo(float).tiny)


def harmonic_sum(
    x: np.ndarray, y: np.ndarray, c: np.ndarray, odd: bool = False
) -> np.ndarray:
    """Return the real part of ``sum c_n exp(2 i n phi)`` of vectors (x, y).

    With odd orders it is that of ``sum c_n exp[(2 n + 1) i phi]``.
    """
    if not (odd or np.iscomplexobj(c)):
        return chebval(cos2(x, y), c)
    z, tiny = np.add(x, np.multiply(1j, y)), np.finfo(float).tiny
    total = polyval(z**2 / np.maximum(abs(z**2), tiny), c)
    return (total * z / np.maximum(abs(z), tiny) if odd else total).real


def harmonics(values: np.ndarray, odd: bool = False) -> np.ndarray:
    """Return the coefficients ``c_n`` of functions of the direction, shape (..., n).

    The values are those at n equal steps of the angle from zero to pi, and of functions
    with odd orders, see `harmonic_sum`, the opposite ones from there on.
    """
    if odd:
        c = rfft(np.concatenate([values, -values], axis=-1))[..., 1::2]
        c = c[..., : values.shape[-1] // 2] / values.shape[-1]
    else:
        c = rfft(values)[..., : values.shape[-1] // 2] * (2.0 / values.shape[-1])
        c[..., 0] /= 2.0
    size = abs(c).reshape(-1, c.shape[-1]).max(axis=0)
    kept = np.flatnonzero(size > _NEGLIGIBLE * size.max())
    return c[..., : kept.max(initial=0) + 1]


def sin2(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return ``sin(2 phi)`` of vectors (x, y), zero for the origin."""
    total = np.square(x, dtype=float) + np.square(y, dtype=float)
    return 2.0 * np.multiply(x, y) / np.maximum(total, np.finfo(float).tiny)


def angular_cell_kernel(
    i: np.ndarray, j: np.ndarray, coefficients: np.ndarray, odd: bool = False
) -> np.ndarray:
    r"""Integrate ``f(phi)/r`` over unit cells at (i, j).

    The coefficients are the `angular_series` of f, or if complex its `harmonics`.

    Up to 32 cells from the origin, the divergence theorem turns the integral into one
    along the edges of the cell, as :math:`\nabla \cdot (\mathbf r f/r) = f/r`; farther
    away its Taylor series about the centre of the cell is summed up to the fourth
    order,

    .. math:: \left[1 + \frac{\nabla^2}{24} + \frac{\nabla^4}{1920}
              + \frac{\partial_x^2 \partial_y^2}{1440}\right] \frac{f}{r} .

    The relative error is below 1e-10 for the first harmonic and 1e-9 for the second.
    """
    x, y = np.broadcast_arrays(np.asarray(i, float), np.asarray(j, float))
    kernel = np.asarray(_cell_series(x, y, coefficients, odd))
    near = np.maximum(abs(x), abs(y)) <= _EDGES_UP_TO
    kernel[near] = _edge_integral(x[near], y[near], coefficients, odd)
    return kernel


def _edge_integral(
    x: np.ndarray, y: np.ndarray, c: np.ndarray, odd: bool
) -> np.ndarray:
    """Integrate ``f/r`` over the unit cells at (x, y), shape (n,), along the edges."""
    total, center = np.zeros(x.shape), np.stack([x, y])[..., None]
    for axis, side in product((0, 1), (0.5, -0.5)):
        edge = center + 0.5 * _POINTS
        edge[axis] = center[axis] + side
        values = _directional(edge[0], edge[1], c, odd) / np.hypot(*edge)
        total += side * edge[axis, :, 0] * (values @ _WEIGHTS)
    return total


def _directional(x: np.ndarray, y: np.ndarray, c: np.ndarray, odd: bool) -> np.ndarray:
    """Return f along vectors (x, y); see `angular_cell_kernel`."""
    if np.iscomplexobj(c):
        return harmonic_sum(x, y, c, odd)
    return chebval(cos4(x, y), c)


def _cell_series(x: np.ndarray, y: np.ndarray, c: np.ndarray, odd: bool) -> np.ndarray:
    """Integrate ``f/r`` over the unit cells at (x, y) by the Taylor series."""
    shift = 2 if np.iscomplexobj(c) else 1  # by an order of four
    order = 4.0 / shift * np.arange(c.size) + odd
    second = (1.0 - order**2) / 24.0 * c
    # (d_x d_y)^2 = -(D_+^4 + D_-^4 - 2 laplacian^2)/16 with D_+- = d_x +- i d_y, which
    # raise and lower the order of r^m exp(i n phi)
    laplacian2 = (1.0 - order**2) * (9.0 - order**2)
    raised = (order + 1) * (order + 3) * (order + 5) * (order + 7) * c
    lowered = (order - 1) * (order - 3) * (order - 5) * (order - 7) * c
    mixed = np.zeros(c.size + shift, dtype=c.dtype)
    mixed[shift:] += raised
    mixed[: max(c.size - shift, 0)] += lowered[shift:]
    for k, value in enumerate(lowered[:shift]):  # of a negative order
        mixed[shift - odd - k] += value.conjugate()
    mixed[: c.size] -= 2.0 * laplacian2 * c
    fourth = -mixed / (16.0 * 1440.0)
    fourth[: c.size] += laplacian2 * c / 1920.0

    inverse = 1.0 / np.maximum(x * x + y * y, 1.0)
    series = _directional(x, y, c, odd) + inverse * (
        _directional(x, y, second, odd) + inverse * _directional(x, y, fourth, odd)
    )
    return np.sqrt(inverse) * series
