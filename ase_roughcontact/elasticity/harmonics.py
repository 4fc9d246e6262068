r"""Components of Green's functions as functions of the direction.

A function with the same value in opposite directions is the real part of
:math:`\sum_n c_n e^{2 i n \phi}`. If it is even in x, the coefficients are real, and
the function is :math:`\sum_n c_n T_n(\cos 2 \phi)` with Chebyshev polynomials
:math:`T_n`. The inverse moduli of a half space and its Green's functions along the
surface are such functions. Components that couple lateral and normal motion have odd
orders :math:`2 n + 1`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import lru_cache

import numpy as np
from numpy.polynomial.chebyshev import chebval
from numpy.polynomial.legendre import leggauss
from numpy.polynomial.polynomial import polyval
from scipy.fft import rfft

# Smallest harmonic that is kept, relative to the largest one.
_MIN_HARMONIC = 1e-13
# Distance, in cells, below which integrals over cells are tabulated. With the distance
# rounding errors of the tables grow, and errors of the series beyond it fall.
_TABULATED_CELLS = 160
# Distance, in cells, below which integrals along edges need more points.
_NEAR_CELLS = 8
# Points of an integral along the edge of a cell near the origin.
_NEAR_POINTS = 64
# Points of an integral along the edge of any other cell.
_FAR_POINTS = 10


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

    With odd orders the sum is ``sum c_n exp[(2 n + 1) i phi]``.
    """
    total = _harmonic_sums(x, y, [c], odd)[0]
    if np.ndim(total):
        return total
    return np.full(np.broadcast_shapes(np.shape(x), np.shape(y)), total)


def _harmonic_sums(
    x: np.ndarray, y: np.ndarray, sums: list[np.ndarray], odd: bool
) -> list[np.ndarray]:
    """Return several `harmonic_sum`; a number for a sum without harmonics."""
    if odd or any(np.imag(c).any() for c in sums):
        z, tiny = np.add(x, np.multiply(1j, y)), np.finfo(float).tiny
        z /= np.maximum(abs(z), tiny)
        square, factor = z * z, z if odd else 1.0
        return [(polyval(square, c) * factor).real for c in sums]
    sums = [np.real(c) for c in sums]
    if max(c.size for c in sums) == 1:
        return [c[0] for c in sums]
    cosine = cos2(x, y)
    if not any(c[1::2].any() for c in sums):
        cosine, sums = 2.0 * cosine**2 - 1.0, [c[::2] for c in sums]
    return [c[0] if c.size == 1 else chebval(cosine, c) for c in sums]


def harmonics(values: np.ndarray, odd: bool = False) -> np.ndarray:
    """Return the coefficients ``c_n`` of functions of the direction, shape (..., n).

    The values are given at n equal steps of the angle from zero to pi. From pi on they
    repeat; values of functions with odd orders, see `harmonic_sum`, change their sign.
    """
    if odd:
        c = rfft(np.concatenate([values, -values], axis=-1))[..., 1::2]
        c = c[..., : values.shape[-1] // 2] / values.shape[-1]
    else:
        c = rfft(values)[..., : values.shape[-1] // 2] * (2.0 / values.shape[-1])
        c[..., 0] /= 2.0
    for part in (c.real, c.imag):
        part[abs(part) <= _MIN_HARMONIC * abs(c).max()] = 0.0
    kept = np.flatnonzero(c.reshape(-1, c.shape[-1]).any(axis=0))
    return c[..., : kept.max(initial=0) + 1]


class Component(ABC):
    """Component of the Green's function of a surface, in units of the spacing.

    Attributes
    ----------
    odd_x, odd_y : bool
        Whether the component changes its sign with x and with y.
    """

    odd_x: bool
    odd_y: bool
    #: Distance, in cells, below which displacements are tabulated.
    _tabulated: int

    @abstractmethod
    def waves(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return the component for plane waves, times ``|q|/2`` (1/pressure)."""

    def cells(self, i: np.ndarray, j: np.ndarray) -> np.ndarray:
        """Return the displacement by unit traction on a cell (1/pressure).

        The lattice vectors (i, j) from the cell are arrays of int, broadcast together.
        """
        i, j = np.asarray(i, dtype=int), np.asarray(j, dtype=int)
        x, y = abs(i), abs(j)
        if max(np.max(x), np.max(y)) < self._tabulated:
            kernel = self._near(x, y)
        else:
            kernel = np.asarray(self._distant(x.astype(float), y.astype(float)))
            near = (x < self._tabulated) & (y < self._tabulated)
            x, y = np.broadcast_arrays(x, y)
            kernel[near] = self._near(x[near], y[near])
        if self.odd_x:
            kernel = kernel * np.sign(i)
        return kernel * np.sign(j) if self.odd_y else kernel

    @abstractmethod
    def _near(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the displacements near the cell, in a quadrant."""

    @abstractmethod
    def _distant(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the displacements far from the cell, in a quadrant."""


class Harmonics(Component):
    r"""Component of a continuum, with the Green's function :math:`f(\phi)/(\pi r)`.

    The function f is the `harmonic_sum` of the coefficients after a turn by a right
    angle. Below a distance of 160 cells the divergence
    theorem turns the integral over a cell into an integral along its edges, as
    :math:`\nabla \cdot (\mathbf r f/r) = f/r`. At larger distances the Taylor series
    about the centre of the cell is summed up to the fourth order,

    .. math:: \left[1 + \frac{\nabla^2}{24} + \frac{\nabla^4}{1920}
              + \frac{\partial_x^2 \partial_y^2}{1440}\right] \frac{f}{r} .

    The relative error is below 1e-12 with the first harmonics. Without harmonics
    `love_kernel` is simpler and more accurate.

    Parameters
    ----------
    c : array_like, shape (n,)
        Coefficients, see `harmonics`, of the compliance of plane waves times ``|q|/2``
        (1/pressure): real, or imaginary if the component is odd in y.
    odd : bool
        Whether the harmonics have odd orders.
    """

    def __init__(self, c: np.ndarray | list, odd: bool = False) -> None:
        self.c, self.odd = np.asarray(c), odd
        self.odd_y = bool(np.imag(self.c).any())
        self.odd_x = odd != self.odd_y
        self._tabulated = _TABULATED_CELLS
        self._turned = self.c * (-1.0) ** (np.arange(self.c.size) + odd) / np.pi

    def __reduce__(self) -> tuple:
        """Pickle the coefficients only."""
        return Harmonics, (self.c, self.odd)

    def waves(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return the component; the length of the wave vectors does not matter."""
        return harmonic_sum(qx, qy, self.c, self.odd)

    def _near(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        # tables of single harmonics are shared by all solids
        kernel = np.zeros(np.broadcast_shapes(x.shape, y.shape))
        factors = -self._turned.imag if self.odd_y else self._turned.real
        for n in np.flatnonzero(factors):
            integrals = _cell_integrals(2 * int(n) + self.odd)[int(self.odd_y)]
            kernel += factors[n] * integrals[x, y]
        return kernel

    def _distant(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        c, odd = self._turned, self.odd
        order = 2.0 * np.arange(c.size) + odd
        # (d_x d_y)^2 = -(D_+^4 + D_-^4 - 2 laplacian^2)/16 with D_+- = d_x +- i d_y,
        # which raise and lower the order of r^m exp(i n phi)
        laplacian2 = (1.0 - order**2) * (9.0 - order**2) * c
        lowered = (order - 1) * (order - 3) * (order - 5) * (order - 7) * c
        mixed = np.zeros(c.size + 2, dtype=c.dtype)
        mixed[2:] += (order + 1) * (order + 3) * (order + 5) * (order + 7) * c
        mixed[: max(c.size - 2, 0)] += lowered[2:]
        for k, value in enumerate(lowered[:2]):  # of a negative order
            mixed[2 - odd - k] += value.conjugate()
        fourths = -mixed / (16.0 * 1440.0)
        fourths[: c.size] += laplacian2 * (1.0 / 1920.0 + 2.0 / (16.0 * 1440.0))
        seconds = (1.0 - order**2) / 24.0 * c

        inverse = 1.0 / np.maximum(x * x + y * y, 1.0)
        first, second, fourth = _harmonic_sums(x, y, [c, seconds, fourths], odd)
        return np.sqrt(inverse) * (first + inverse * (second + inverse * fourth))


@lru_cache
def _cell_integrals(order: int) -> np.ndarray:
    """Return the integrals of ``exp(i n phi)/r`` over unit cells of a quadrant.

    Real and imaginary parts are along the first axis.
    """
    near, size = _NEAR_CELLS, _TABULATED_CELLS
    integrals = _edge_integrals(order, size, _FAR_POINTS)
    integrals[:near, :near] = _edge_integrals(order, near, _NEAR_POINTS)
    return np.stack([integrals.real, integrals.imag])


def _edge_integrals(order: int, size: int, number: int) -> np.ndarray:
    """Return the integrals over size x size cells, by points along each edge."""
    points, weights = leggauss(number)
    x = np.arange(size + 1) - 0.5  # positions of the edges along y
    edges = x[:, None, None] + 1j * (np.arange(size)[:, None] + 0.5 * points)
    r = abs(edges)
    values = np.exp(1j * order * np.angle(edges)) / r if order else 1.0 / r
    along_y = x[:, None] * (values @ (0.5 * weights))
    # integrals along x follow from an exchange of x and y
    along_x = (1j**order if order else 1.0) * along_y.conj().T
    return np.diff(along_y, axis=0) + np.diff(along_x, axis=1)
