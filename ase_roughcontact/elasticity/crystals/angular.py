r"""Functions of the direction, and their integrals over a cell.

A function with the same value in opposite directions is the real part of
:math:`\sum_n c_n e^{2 i n \phi}`; if it is even in x, the coefficients are real, and it
is :math:`\sum_n c_n T_n(\cos 2 \phi)` with Chebyshev polynomials :math:`T_n`. The
inverse moduli of an anisotropic half space are such functions, and so are its Green's
functions along the surface. Components that couple lateral and normal motion have odd
orders :math:`2 n + 1`.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.polynomial.chebyshev import chebval
from numpy.polynomial.legendre import leggauss
from numpy.polynomial.polynomial import polyval
from scipy.fft import rfft

# Relative size below which harmonics are left out.
_NEGLIGIBLE = 1e-13
# Distance, in cells, up to which the integral over a cell is taken along its edges.
_EDGES_UP_TO = 32
_POINTS, _WEIGHTS = leggauss(40)


def cos2(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return ``cos(2 phi)`` of vectors (x, y), zero for the origin."""
    x2, y2 = np.square(x, dtype=float), np.square(y, dtype=float)
    return (x2 - y2) / np.maximum(x2 + y2, np.finfo(float).tiny)


def sin2(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return ``sin(2 phi)`` of vectors (x, y), zero for the origin."""
    total = np.square(x, dtype=float) + np.square(y, dtype=float)
    return 2.0 * np.multiply(x, y) / np.maximum(total, np.finfo(float).tiny)


def harmonic_sum(
    x: np.ndarray, y: np.ndarray, c: np.ndarray, odd: bool = False
) -> np.ndarray:
    """Return the real part of ``sum c_n exp(2 i n phi)`` of vectors (x, y).

    With odd orders it is that of ``sum c_n exp[(2 n + 1) i phi]``.
    """
    if not (odd or np.imag(c).any()):
        cosine, c = cos2(x, y), np.real(c)
        if c[1::2].any():
            return chebval(cosine, c)
        return chebval(2.0 * cosine**2 - 1.0, c[::2])
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
    for part in (c.real, c.imag):
        part[abs(part) <= _NEGLIGIBLE * abs(c).max()] = 0.0
    kept = np.flatnonzero(c.reshape(-1, c.shape[-1]).any(axis=0))
    return c[..., : kept.max(initial=0) + 1]


def continuum_kernel(
    i: np.ndarray, j: np.ndarray, spacing: float, c: np.ndarray, odd: bool = False
) -> np.ndarray:
    r"""Return the displacement of a continuum by unit traction on one cell.

    The Green's function is :math:`f(\phi)/(\pi r)`, with f the `harmonic_sum` of the
    coefficients after a turn by a right angle.

    Up to 32 cells from the origin, the divergence theorem turns the integral into one
    along the edges of the cell, as :math:`\nabla \cdot (\mathbf r f/r) = f/r`; farther
    away its Taylor series about the centre of the cell is summed up to the fourth
    order,

    .. math:: \left[1 + \frac{\nabla^2}{24} + \frac{\nabla^4}{1920}
              + \frac{\partial_x^2 \partial_y^2}{1440}\right] \frac{f}{r} .

    The relative error is below 1e-10 for the first harmonic and 1e-9 for the second.

    Parameters
    ----------
    i, j, spacing
        See `ElasticSolid.cell_compliance`.
    c : ndarray, shape (n,)
        `harmonics` of the compliance of waves, times ``|q|/2`` (1/pressure).
    odd : bool
        Whether they have odd orders.
    """
    x, y = np.broadcast_arrays(np.asarray(i, float), np.asarray(j, float))
    turned = c * (-1.0) ** (np.arange(c.size) + odd)
    kernel = np.asarray(_cell_series(x, y, turned, odd))
    near = np.maximum(abs(x), abs(y)) <= _EDGES_UP_TO
    kernel[near] = _edge_integral(x[near], y[near], turned, odd)
    if odd:  # but for rounding
        kernel[(x == 0.0) & (y == 0.0)] = 0.0
    return spacing / np.pi * kernel


def _edge_integral(
    x: np.ndarray, y: np.ndarray, c: np.ndarray, odd: bool
) -> np.ndarray:
    """Integrate ``f/r`` over the unit cells at (x, y), shape (n,), along the edges."""
    total, center = np.zeros(x.shape), np.stack([x, y])[..., None]
    for axis, side in product((0, 1), (0.5, -0.5)):
        edge = center + 0.5 * _POINTS
        edge[axis] = center[axis] + side
        values = harmonic_sum(edge[0], edge[1], c, odd) / np.hypot(*edge)
        total += side * edge[axis, :, 0] * (values @ _WEIGHTS)
    return total


def _cell_series(x: np.ndarray, y: np.ndarray, c: np.ndarray, odd: bool) -> np.ndarray:
    """Integrate ``f/r`` over the unit cells at (x, y) by the Taylor series."""
    order = 2.0 * np.arange(c.size) + odd
    second = (1.0 - order**2) / 24.0 * c
    # (d_x d_y)^2 = -(D_+^4 + D_-^4 - 2 laplacian^2)/16 with D_+- = d_x +- i d_y, which
    # raise and lower the order of r^m exp(i n phi)
    laplacian2 = (1.0 - order**2) * (9.0 - order**2) * c
    lowered = (order - 1) * (order - 3) * (order - 5) * (order - 7) * c
    mixed = np.zeros(c.size + 2, dtype=c.dtype)
    mixed[2:] += (order + 1) * (order + 3) * (order + 5) * (order + 7) * c
    mixed[: max(c.size - 2, 0)] += lowered[2:]
    for k, value in enumerate(lowered[:2]):  # of a negative order
        mixed[2 - odd - k] += value.conjugate()
    mixed[: c.size] -= 2.0 * laplacian2
    fourth = -mixed / (16.0 * 1440.0)
    fourth[: c.size] += laplacian2 / 1920.0

    inverse = 1.0 / np.maximum(x * x + y * y, 1.0)
    series = harmonic_sum(x, y, c, odd) + inverse * (
        harmonic_sum(x, y, second, odd) + inverse * harmonic_sum(x, y, fourth, odd)
    )
    return np.sqrt(inverse) * series
