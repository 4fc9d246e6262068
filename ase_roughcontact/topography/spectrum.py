r"""Statistics of heights on a grid: root mean squares and the power spectrum.

Of heights :math:`h(r) = \sum_q c_q e^{i q \cdot r}` the coefficients give, by
Parseval's theorem, :math:`\langle |\nabla^m h|^2 \rangle = \sum_q q^{2m} |c_q|^2`.
Any unit of length.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from ase_roughcontact._util.validation import (
    FloatArray,
    height_array,
    integer,
    positive,
)


@dataclass(frozen=True)
class Statistics:
    r"""Root mean squares of a surface, taken from its mean height.

    Parameters
    ----------
    rms_height : float
        :math:`\langle h^2 \rangle^{1/2}`, a length.
    rms_slope : float
        :math:`\langle |\nabla h|^2 \rangle^{1/2}`, dimensionless.
    rms_curvature : float
        :math:`\langle (\nabla^2 h)^2 \rangle^{1/2}`, an inverse length.
    """

    rms_height: float
    rms_slope: float
    rms_curvature: float

    @classmethod
    def of_waves(cls, square: NDArray[Any], power: NDArray[Any]) -> Statistics:
        """Sum over plane waves.

        Parameters
        ----------
        square : ndarray
            Square wave number of each wave, inverse area.
        power : ndarray, shape of `square`
            Mean square height of each wave, area.

        Returns
        -------
        Statistics
            Exact root mean squares of their sum.
        """
        sums = (np.vdot(square**m, power) for m in range(3))
        return cls(*(math.sqrt(total) for total in sums))


def statistics(heights: ArrayLike, spacing: float, periodic: bool = True) -> Statistics:
    r"""Measure the statistics of heights on a grid.

    Only the mean height is removed: a tilt or a sphere counts as roughness.

    Parameters
    ----------
    heights : array_like, shape (n, m)
        Heights, length.
    spacing : float
        Distance between grid points, length.
    periodic : bool
        Whether the grid repeats itself: derivatives are then exact, in Fourier space.
        Otherwise central differences at the interior points reduce the slope of a wave
        of wave number q along an axis by :math:`\sin(qa)/qa` and its curvature by
        :math:`(\sin(qa/2)/(qa/2))^2`, with spacing a.

    Returns
    -------
    Statistics
        Root mean square height, slope and curvature.

    Raises
    ------
    ValueError
        If the heights are no finite map, or smaller than 3 x 3 and not periodic.
    """
    h = height_array(heights)
    positive(spacing=spacing)
    if periodic:
        square, _, power = _waves(h, spacing)
        return Statistics.of_waves(square, power)
    if min(h.shape) < 3:
        raise ValueError(
            f"heights that are not periodic need 3 x 3 points, got shape {h.shape}"
        )
    east, west = h[2:, 1:-1], h[:-2, 1:-1]
    north, south = h[1:-1, 2:], h[1:-1, :-2]
    square_slope = ((east - west) ** 2 + (north - south) ** 2) / (2 * spacing) ** 2
    laplacian = (east + west + north + south - 4 * h[1:-1, 1:-1]) / spacing**2
    return Statistics(
        float(h.std()),
        math.sqrt(square_slope.mean()),
        math.sqrt((laplacian**2).mean()),
    )


def power_spectrum(
    heights: ArrayLike, spacing: float, bins: int | None = None
) -> tuple[FloatArray, FloatArray]:
    r"""Measure the radially averaged power spectrum of periodic heights.

    With the area A of the map, :math:`C = A |c|^2`, such that over all wave vectors but
    zero

    .. math:: \frac{1}{A} \sum_q C(q) = \langle h^2 \rangle - \langle h \rangle^2 .

    Parameters
    ----------
    heights : array_like, shape (n, m)
        Heights, length.
    spacing : float
        Distance between grid points, length.
    bins : int, optional
        Number of rings of equal width, out to the corners of the grid's wave vectors.
        Default: as wide as the wave vectors are apart.

    Returns
    -------
    q : ndarray, shape (k,)
        Mean wave number of each ring that is not empty, inverse length.
    C : ndarray, shape (k,)
        Mean power spectral density there, a length to the fourth power.

    Raises
    ------
    ValueError
        If the heights are no finite map, or `bins` is not positive.

    References
    ----------
    T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001
    (2017), on the two-dimensional spectrum.
    """
    h = height_array(heights)
    positive(spacing=spacing)
    square, number, power = _waves(h, spacing)
    number[0, 0] = 0
    q = np.sqrt(square)
    if bins is None:
        ring = np.rint(q * (min(h.shape) * spacing / (2 * np.pi))).astype(int)
    else:
        bins = integer("bins", bins, least=1)
        ring = np.minimum((q * (bins / (q.max() or 1.0))).astype(int), bins - 1)
    total, sum_q, sum_power = (
        np.bincount(ring.ravel(), weights=weights.ravel())
        for weights in (number, number * q, power)
    )
    filled = total > 0
    area = h.size * spacing**2
    return sum_q[filled] / total[filled], area * sum_power[filled] / total[filled]


def _waves(
    h: FloatArray, spacing: float
) -> tuple[NDArray[Any], FloatArray, FloatArray]:
    """Square wave number, count (with mirror image) and mean square height of waves.

    One half plane stands for both, as the heights are real.
    """
    n, m = h.shape
    qx = 2 * np.pi * fft.fftfreq(n, spacing)
    qy = 2 * np.pi * fft.rfftfreq(m, spacing)
    square = qx[:, None] ** 2 + qy[None, :] ** 2
    number = np.ones(square.shape)
    number[:, 1 : (m + 1) // 2] = 2
    power = number * np.abs(fft.rfft2(h - h.mean(), norm="forward")) ** 2
    return square, number, power
