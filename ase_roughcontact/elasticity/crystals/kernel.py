r"""Green's function of a square lattice from that of waves along its surface.

The inverse modulus of plane waves of pressure is interpolated by Chebyshev polynomials
of :math:`s = q_x a_0` and :math:`v = q_y/q_x` on the eighth part
:math:`0 \le q_y \le q_x \le \pi/a_0` of the Brillouin zone. Where x and y differ, as on
the (100) surface of diamond, it is the sum of a part that is unchanged when they are
exchanged and of :math:`\cos 2\theta` times another one. For long waves it is

.. math:: \frac{1}{E^*(q)} = \sum_{k,n} m_{kn} (|q| a_0)^k \cos n\theta, \qquad
          n = 0, 2, 4, \ldots,

so that far from an atom the displacement by unit pressure on it is

.. math:: G(r) = \frac{a_0}{\pi} \sum_{k,n} m_{kn} \gamma_{kn}
          \left(\frac{a_0}{r}\right)^{k+1} \cos n\phi, \qquad
          \gamma_{kn} = (-1)^{n/2}\, 2^k
          \frac{\Gamma[(n + k + 1)/2]}{\Gamma[(n - k + 1)/2]} .

Near the atom it is the inverse Fourier transform over the Brillouin zone. The first two
terms, which are singular at long waves, are multiplied by
:math:`\exp(-\sigma^2 q^2)` and transformed in closed form, the rest by an FFT.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.polynomial.chebyshev import (
    chebder,
    chebfit,
    chebmulx,
    chebpts1,
    chebval,
    chebvander,
)
from scipy.fft import dct, dctn, dst, dstn
from scipy.special import gamma, ive, rgamma

from ase_roughcontact.elasticity.crystals.angular import (
    angular_series,
    cos2,
    harmonic_sum,
    sin2,
)

#: Chebyshev nodes along the wave number and the direction.
NODES = 28, 20
# Wave vectors that are interpolated at once.
_CHUNK = 1 << 14
# Number of harmonics in the expansion of long waves, by the power of the wave number.
_HARMONICS = 12, 6, 5, 4
#: The same for lateral components.
LATERAL_HARMONICS = 16, 10, 8, 6
# Side of the grid in the Brillouin zone for the table of the Green's function, and the
# width, in spacings, of the part that is subtracted.
_GRID, _WIDTH = 1024, 1.7


def node_vectors() -> np.ndarray:
    """Return the wave vectors of the interpolation, shape (n, 2), in units of 1/a0."""
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
        Coefficients, see `interpolation_table`, of the function if it is unchanged when
        x and y are exchanged, or of its two parts.
    qx, qy : ndarray
        In units of 1/a0, between -pi and pi, broadcast together; not both zero.

    Returns
    -------
    ndarray, shape of the broadcast
    """
    if table.ndim > 2:
        same, other = (interpolate(part, qx, qy) for part in table)
        return same + cos2(qx, qy) * other
    qx, qy = np.broadcast_arrays(abs(np.asarray(qx)), abs(np.asarray(qy)))
    large, small = np.maximum(qx, qy).ravel(), np.minimum(qx, qy).ravel()
    values = np.empty(large.size)
    for start in range(0, large.size, _CHUNK):
        chunk = slice(start, start + _CHUNK)
        along = chebvander(2.0 / np.pi * large[chunk] - 1.0, table.shape[0] - 1)
        across = chebvander(2.0 * small[chunk] / large[chunk] - 1.0, table.shape[1] - 1)
        values[chunk] = np.einsum("ij,ij->i", along @ table, across)
    return values.reshape(qx.shape)


def long_wave_series(
    table: np.ndarray,
    numbers: tuple[int, ...] = _HARMONICS,
    odd: bool = False,
    coupled: bool = False,
) -> list[np.ndarray]:
    """Return the coefficients ``m_kn``, n = 0, 2, 4, ..., for each power k.

    The numbers of harmonics for each power are those of functions with the symmetry of
    a square. Of a function that is odd in x and in y, the table is that of its ratio to
    ``sin(2 theta)``, and the coefficients are imaginary, see `harmonic_sum`; of one
    that is odd in x alone, as those that couple normal and lateral motion, that of its
    ratio to ``cos(theta)``, and the coefficients are those of n = 1, 3, 5, ...
    """
    series = []
    for power, harmonics in enumerate(numbers):
        total = np.zeros(2 * harmonics + 2)
        for number, part in enumerate(table.reshape(-1, *NODES)):
            derivative = chebder(part, power, scl=2.0 / np.pi) / math.factorial(power)
            derivative = (-1.0) ** np.arange(len(derivative)) @ derivative  # at s = 0
            fourth = angular_series(_along(derivative, power), harmonics)
            even = np.zeros(2 * fourth.size)
            even[::2] = fourth
            product = chebmulx(even) if number else even  # by cos(2 theta)
            total[: product.size] += product
        total = total[: np.flatnonzero(total).max(initial=0) + 1]
        if coupled:  # cos(theta) cos(n theta) = [cos(n - 1) theta + cos(n + 1) theta]/2
            total = 0.5 * np.append(total[0] + total[:1], total[1:]) + 0.5 * np.append(
                total[1:], 0.0
            )
        series.append(_times_sine(total) if odd else total)
    return series


def _times_sine(cosines: np.ndarray) -> np.ndarray:
    """Return ``sin(2 theta) sum c_n cos(2 n theta)`` for `harmonic_sum`."""
    sines = np.zeros(cosines.size + 1)
    sines[1:] = 0.5 * cosines
    sines[1:-2] -= 0.5 * cosines[2:]
    sines[1] += 0.5 * cosines[0]
    return -1j * sines


def _along(coefficients: np.ndarray, power: int) -> Callable[[np.ndarray], np.ndarray]:
    """Return the term of a power of |q| as a function of the angle."""
    return lambda angle: (
        np.cos(angle) ** power * chebval(2.0 * np.tan(angle) - 1.0, coefficients)
    )


def distant_kernel(
    i: np.ndarray, j: np.ndarray, series: list[np.ndarray], coupled: bool = False
) -> np.ndarray:
    """Return the Green's function far from the origin, in units of a0.

    Lattice vectors (i, j) are broadcast together; see `long_wave_series`.
    """
    inverse = 1.0 / np.sqrt(np.maximum(np.square(i, dtype=float) + np.square(j), 1.0))
    kernel = np.zeros(inverse.shape)
    for power, coefficients in reversed([*enumerate(series)]):
        order = 2.0 * np.arange(coefficients.size) + coupled
        factor = 2.0**power * gamma((order + power + 1) / 2)
        factor *= _signs(order.size, coupled)
        factor *= rgamma((order - power + 1) / 2)
        kernel += harmonic_sum(i, j, factor * coefficients, coupled)
        kernel *= inverse
    return kernel / np.pi


def near_kernel(
    size: int, table: np.ndarray, series: list[np.ndarray], coupled: bool = False
) -> np.ndarray:
    """Return the Green's function near the origin, shape (size, size), in units of a0.

    The size is at most 512; see `interpolation_table` and `long_wave_series`, whose
    series are complex for an odd function.
    """
    q = 2.0 * np.pi / _GRID * np.arange(_GRID // 2 + 1)
    qx, qy = np.meshgrid(q, q, indexing="ij")
    qx[0, 0] = 1.0  # any: set below
    number, odd = np.hypot(qx, qy), np.iscomplexobj(series[0])
    singular = harmonic_sum(qx, qy, series[0], coupled) / number
    singular += harmonic_sum(qx, qy, series[1], coupled)
    singular *= np.exp(-((_WIDTH * number) ** 2))
    values = interpolate(table, qx, qy)
    if odd or coupled:
        values *= sin2(qx, qy) if odd else qx / number
    rest = values / number - singular
    rest[0, 0] = 0.0
    kernel = np.zeros((size, size))
    if odd:
        kernel[1:, 1:] = -dstn(rest[1:-1, 1:-1], 1)[: size - 1, : size - 1]
    elif coupled:
        kernel[1:] = -dst(dct(rest, 1)[1:-1], 1, axis=0)[: size - 1, :size]
    else:
        kernel = dctn(rest, 1)[:size, :size]
    kernel *= 2.0 / _GRID**2

    i, half = np.arange(size, dtype=float), 0.5 * coupled
    r = np.maximum(np.hypot(i[:, None], i), 1e-9)  # the limit at the origin
    angle, x = np.arctan2(i, i[:, None]), r * r / (8.0 * _WIDTH**2)
    for n, m in enumerate(series[0] * _signs(series[0].size, coupled)):
        turned = (m * np.exp(2j * (n + half) * angle)).real
        kernel += turned * ive(n + half, x) / (2.0 * _WIDTH * np.pi**0.5)
    for n, m in enumerate(series[1] * _signs(series[1].size, coupled)):
        bessel = ive(n + half - 0.5, x) - ive(n + half + 0.5, x)
        turned = (m * np.exp(2j * (n + half) * angle)).real
        kernel += turned * bessel * r / (8.0 * _WIDTH**3 * np.pi**0.5)
    # the images of the transform are far away and shift all values by the same amount
    shift = 0.0
    if not (odd or coupled):
        shift = (distant_kernel(i[-1:], i, series) - kernel[-1]).mean()
    return kernel + shift


def _signs(size: int, coupled: bool) -> np.ndarray:
    """Return the signs of the harmonics of a Green's function."""
    return (-1.0) ** (np.arange(size) + coupled)
