r"""Green's function of a square lattice, interpolated from waves along its surface.

The inverse modulus of plane waves of pressure is interpolated by Chebyshev polynomials
of :math:`s = q_x a_0` and :math:`v = q_y/q_x` on the eighth part
:math:`0 \le q_y \le q_x \le \pi/a_0` of the Brillouin zone. Where x and y differ, as on
the (100) surface of diamond, it is the sum of two functions that are unchanged when x
and y are exchanged, the second one times :math:`\cos 2\theta`. For long waves it is

.. math:: \frac{1}{E^*(q)} = \sum_{k,n} m_{kn} (|q| a_0)^k \cos n\theta, \qquad
          n = 0, 2, 4, \ldots,

so that far from an atom the displacement by unit pressure on it is

.. math:: G(r) = \frac{a_0}{\pi} \sum_{k,n} m_{kn} \gamma_{kn}
          \left(\frac{a_0}{r}\right)^{k+1} \cos n\phi, \qquad
          \gamma_{kn} = (-1)^{n/2}\, 2^k
          \frac{\Gamma[(n + k + 1)/2]}{\Gamma[(n - k + 1)/2]} .

Near the atom the displacement is the inverse Fourier transform over the Brillouin zone.
The first two terms, which are singular at long waves, are multiplied by
:math:`\exp(-\sigma^2 q^2)` and transformed in closed form, the rest by an FFT.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebfit, chebpts1, chebval, chebvander
from scipy.fft import dct, dst
from scipy.special import gamma, ive, rgamma

from ase_roughcontact.elasticity.harmonics import (
    Component,
    cos2,
    harmonic_sum,
    harmonics,
    sin2,
)

#: Numbers of Chebyshev nodes along the wave number and the direction.
NODES = 28, 20
# Number of wave vectors that are interpolated at once.
_WAVES_AT_ONCE = 1 << 14
# Number of harmonics in the expansion of long waves, by the power of the wave number.
_HARMONICS = (33, 21, 17, 13)
# Number of directions from which these harmonics are determined.
_DIRECTIONS = 160
# Distance, in spacings, up to which the Green's function is tabulated.
_TABULATED_SPACINGS = 48
# Number of points along each side of the grid in the Brillouin zone for this table.
_GRID = 1024
# Width sigma of the Gaussian that multiplies the singular terms, in spacings.
_GAUSSIAN_WIDTH = 1.7


def node_vectors() -> np.ndarray:
    """Return the wave vectors of the nodes, shape (n, 2), in units of 1/a0."""
    s = (chebpts1(NODES[0])[:, None] + 1.0) * np.pi / 2.0
    v = (chebpts1(NODES[1]) + 1.0) / 2.0
    return np.stack([np.broadcast_to(s, NODES), s * v], -1).reshape(-1, 2)


def interpolation_table(values: np.ndarray) -> np.ndarray:
    """Return Chebyshev coefficients, shape `NODES`, from the values at the nodes."""
    table = values.reshape(NODES)
    for axis, nodes in enumerate(NODES):
        columns = np.moveaxis(table, axis, 0)
        fit = chebfit(chebpts1(nodes), columns, nodes - 1)
        table = np.moveaxis(fit, 0, axis)
    return table


def interpolate(table: np.ndarray, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
    """Return interpolated values at wave vectors of the Brillouin zone.

    Parameters
    ----------
    table : ndarray, shape (28, 20) or (2, 28, 20)
        Coefficients, see `interpolation_table`, of a function that is unchanged when
        x and y are exchanged, or of the two such functions of any other one.
    qx, qy : ndarray
        Components of the wave vectors in units of 1/a0, between -pi and pi, broadcast
        together; not both zero.

    Returns
    -------
    ndarray, shape of the broadcast
        Values of the function.
    """
    if table.ndim > 2:
        same, other = (interpolate(part, qx, qy) for part in table)
        return same + cos2(qx, qy) * other
    qx, qy = np.broadcast_arrays(abs(np.asarray(qx)), abs(np.asarray(qy)))
    large, small = np.maximum(qx, qy).ravel(), np.minimum(qx, qy).ravel()
    values = np.empty(large.size)
    for start in range(0, large.size, _WAVES_AT_ONCE):
        chunk = slice(start, start + _WAVES_AT_ONCE)
        along = chebvander(2.0 / np.pi * large[chunk] - 1.0, table.shape[0] - 1)
        across = chebvander(2.0 * small[chunk] / large[chunk] - 1.0, table.shape[1] - 1)
        values[chunk] = np.einsum("ij,ij->i", along @ table, across)
    return values.reshape(qx.shape)


class LatticeComponent(Component):
    """Component of the Green's function of a square lattice.

    Parameters
    ----------
    table : ndarray, shape (28, 20) or (2, 28, 20)
        Coefficients, see `interpolate`, of the component for plane waves, times
        ``|q|/2`` and divided by a factor that depends on the direction.
    name : {"zz", "xx", "yy", "xy", "zx", "zy"}
        Name of the component. The factor is ``sin(2 theta)`` for xy, ``cos(theta)`` for
        zx, ``sin(theta)`` for zy, with x and y exchanged in the table, and 1 otherwise.
    """

    _tabulated = _TABULATED_SPACINGS

    def __init__(self, table: np.ndarray, name: str) -> None:
        self.odd_x, self.odd_y = name in ("xy", "zx"), name in ("xy", "zy")
        self._cross = self.odd_x != self.odd_y
        exchange = np.reshape([1.0, -1.0], (2, 1, 1))
        self._table = exchange * table if name == "zy" else table

    def waves(self, qx: np.ndarray, qy: np.ndarray) -> np.ndarray:
        """Return the component at wave vectors in units of 1/a0; see `Component`."""
        return interpolate(self._table, qx, qy) * self._factor(qx, qy)

    @cached_property
    def series(self) -> list[np.ndarray]:
        """Harmonics ``m_kn`` of long waves for each power k, see `harmonic_sum`."""
        angles = np.pi / _DIRECTIONS * np.arange(_DIRECTIONS)
        x, y = np.cos(angles), np.sin(angles)
        large, small = np.maximum(abs(x), abs(y)), np.minimum(abs(x), abs(y))
        series = []
        for power, number in enumerate(_HARMONICS):
            values = np.zeros(_DIRECTIONS)
            for power_of_cos2, part in enumerate(self._table.reshape(-1, *NODES)):
                derivative = chebder(part, power, scl=2.0 / np.pi)
                along = (-1.0) ** np.arange(len(derivative)) @ derivative  # at s = 0
                term = chebval(2.0 * small / large - 1.0, along / math.factorial(power))
                values += cos2(x, y) ** power_of_cos2 * large**power * term
            values *= self._factor(x, y)
            series.append(harmonics(values, self._cross)[:number])
        return series

    def _factor(self, x: np.ndarray, y: np.ndarray) -> np.ndarray | float:
        """Return the factor of the direction."""
        if self._cross:
            return (x if self.odd_x else y) / np.hypot(x, y)
        return sin2(x, y) if self.odd_x else 1.0

    def _distant(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        inverse = 1.0 / np.maximum(np.hypot(x, y), 1.0)
        kernel = np.zeros(inverse.shape)
        for power, coefficients in reversed([*enumerate(self.series)]):
            order = 2.0 * np.arange(coefficients.size) + self._cross
            factor = 2.0**power * gamma((order + power + 1) / 2)
            factor *= self._signs(order.size) * rgamma((order - power + 1) / 2)
            kernel += harmonic_sum(x, y, factor * coefficients, self._cross)
            kernel *= inverse
        return kernel / np.pi

    def _near(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return self._quadrant[x, y]

    @cached_property
    def _quadrant(self) -> np.ndarray:
        q = 2.0 * np.pi / _GRID * np.arange(_GRID // 2 + 1)
        qx, qy = np.meshgrid(q, q, indexing="ij")
        qx[0, 0] = 1.0  # any wave number: the result is set below
        number, (first, second) = np.hypot(qx, qy), self.series[:2]
        singular = harmonic_sum(qx, qy, first, self._cross) / number
        singular += harmonic_sum(qx, qy, second, self._cross)
        singular *= np.exp(-((_GAUSSIAN_WIDTH * number) ** 2))
        rest = self.waves(qx, qy) / number - singular
        rest[0, 0] = 0.0
        for axis, odd in enumerate((self.odd_x, self.odd_y)):
            rest = _series(rest, odd, axis)
        size = _TABULATED_SPACINGS
        kernel = rest[:size, :size] * (2.0 / _GRID**2)
        if self.odd_x or self.odd_y:
            kernel = -kernel

        i, half = np.arange(size, dtype=float), 0.5 * self._cross
        r = np.maximum(np.hypot(i[:, None], i), 1e-9)  # the limit at the origin
        angle, x = np.arctan2(i, i[:, None]), r * r / (8.0 * _GAUSSIAN_WIDTH**2)
        for n, m in enumerate(first * self._signs(first.size)):
            turned = (m * np.exp(2j * (n + half) * angle)).real
            kernel += turned * ive(n + half, x) / (2.0 * _GAUSSIAN_WIDTH * np.pi**0.5)
        for n, m in enumerate(second * self._signs(second.size)):
            bessel = ive(n + half - 0.5, x) - ive(n + half + 0.5, x)
            turned = (m * np.exp(2j * (n + half) * angle)).real
            kernel += turned * bessel * r / (8.0 * _GAUSSIAN_WIDTH**3 * np.pi**0.5)
        if not (self.odd_x or self.odd_y):
            # periodic images are far away and add about the same to all values
            kernel += (self._distant(i[-1:], i) - kernel[-1]).mean()
        return kernel

    def _signs(self, size: int) -> np.ndarray:
        """Return the signs of the harmonics of the Green's function."""
        return (-1.0) ** (np.arange(size) + self._cross)


def _series(values: np.ndarray, odd: bool, axis: int) -> np.ndarray:
    """Return sums of sines for odd values, or sums of cosines, along an axis."""
    if not odd:
        return dct(values, 1, axis=axis)
    inner = values.take(range(1, values.shape[axis] - 1), axis)
    return np.insert(dst(inner, 1, axis=axis), 0, 0.0, axis=axis)
