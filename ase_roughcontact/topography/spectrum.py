r"""Statistics of heights on a grid: root mean squares, power spectrum, and edges.

By Parseval's theorem, heights :math:`h(r) = \sum_q c_q e^{i q \cdot r}` have
:math:`\langle |\nabla^m h|^2 \rangle = \sum_q q^{2m} |c_q|^2`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from ase_roughcontact._util.validation import FloatArray, Point, height_array, positive
from ase_roughcontact.topography.interpolation import mean_squares

# Least rms difference of opposite edges that is a step, relative to neighbouring lines.
_MIN_EDGE_STEP = 2.0


@dataclass(frozen=True)
class Statistics:
    r"""Root mean square height, slope and curvature of a surface.

    Parameters
    ----------
    rms_height : float
        :math:`\langle h^2 \rangle^{1/2}`, with h measured from the mean (length).
    rms_slope : float
        :math:`\langle |\nabla h|^2 \rangle^{1/2}`, dimensionless.
    rms_curvature : float
        :math:`\langle (\nabla^2 h)^2 \rangle^{1/2}` (inverse length).
    """

    rms_height: float
    rms_slope: float
    rms_curvature: float

    @classmethod
    def of_waves(cls, square: NDArray[Any], power: NDArray[Any]) -> Statistics:
        """Return the exact statistics of a sum of plane waves.

        `square` are their square wave numbers (inverse area), `power` their mean square
        heights (area).
        """
        return cls(
            math.sqrt(power.sum()),
            math.sqrt((square * power).sum()),
            math.sqrt((square**2 * power).sum()),
        )


def smooth_component(heights: FloatArray) -> FloatArray:
    """Return a smooth surface without which heights are periodic.

    Its Laplacian is zero but at the edges, where it is the Laplacian of the steps
    between opposite edges.

    Parameters
    ----------
    heights : ndarray, shape (n, m)
        Heights on a grid (length).

    Returns
    -------
    ndarray, shape (n, m)
        Smooth surface of mean zero (length).

    References
    ----------
    L. Moisan, J. Math. Imaging Vis. 39, 161 (2011), eqs. (8) to (11).
    """
    heights = height_array(heights)
    steps = np.zeros_like(heights)
    for edges, rows in ((steps, heights), (steps.T, heights.T)):
        edges[0] += rows[-1] - rows[0]
        edges[-1] -= rows[-1] - rows[0]
    x, y = (2.0 * np.cos(2.0 * np.pi * fft.fftfreq(n)) - 2.0 for n in heights.shape)
    laplacian = x[:, None] + y
    laplacian[0, 0] = 1.0  # the steps have no mean
    return fft.ifft2(fft.fft2(steps) / laplacian).real


def statistics(
    heights: ArrayLike, spacing: float | tuple[float, float], periodic: bool = True
) -> Statistics:
    r"""Return the rms height, slope and curvature of heights on a grid.

    Only the mean height is subtracted: tilt and shape contribute.

    Parameters
    ----------
    heights : array_like, shape (n, m)
        Heights (length).
    spacing : float or (float, float)
        Distance between grid points, or one each along x and y (length).
    periodic : bool
        Whether the heights are periodic, and derivatives are taken in Fourier space.
        Otherwise differences of neighbours are used, as by SurfaceTopography.

    Returns
    -------
    Statistics

    Raises
    ------
    ValueError
        If the heights are not a finite two-dimensional array, or not periodic and fewer
        than 3 x 3.

    Notes
    -----
    Differences reduce the slope of a wave of wave number q along an axis by
    :math:`\sin(qa/2)/(qa/2)`, and its curvature by the square of it, with the spacing
    a.
    """
    h, steps = height_array(heights), axis_spacings(spacing)
    if periodic:
        square, _, power = _waves(h, steps)
        return Statistics.of_waves(square, power)
    if min(h.shape) < 3:
        raise ValueError(
            "heights that are not periodic must have at least 3 x 3 points, got shape "
            f"{h.shape}"
        )
    x, y = steps
    along_x, along_y = np.diff(h, axis=0) / x, np.diff(h, axis=1) / y
    square_slope = along_x[:, :-1] ** 2 + along_y[:-1] ** 2
    laplacian = np.diff(along_x, axis=0)[:, 1:-1] / x + np.diff(along_y)[1:-1] / y
    return Statistics(
        float(h.std()), math.sqrt(square_slope.mean()), math.sqrt((laplacian**2).mean())
    )


def pressed_statistics(
    heights: FloatArray, spacing: Point, periodic: bool
) -> Statistics:
    """Return the rms height, slope and curvature of a map as it is pressed.

    Slope and curvature are exact for the spline; the height is the rms height of the
    points. The seam of a periodic map is left out if its edges do not fit each other.
    """
    seamless = periodic and not has_edge_step(heights)
    slope, curvature = mean_squares(heights, spacing, seamless)
    return Statistics(float(heights.std()), math.sqrt(slope), math.sqrt(curvature))


def has_edge_step(heights: FloatArray) -> bool:
    """Return whether opposite edges of heights do not fit each other."""
    across, beside = edge_step(heights)
    return across > _MIN_EDGE_STEP * beside


def edge_step(heights: FloatArray) -> tuple[float, float]:
    """Return the rms difference of opposite edges, and of neighbouring lines (length).

    Along the axis along which the first is the larger multiple of the second.
    """
    found = []
    for axis in (0, 1):
        steps = np.diff(heights, axis=axis, append=heights.take([0], axis))
        square = np.moveaxis(steps**2, axis, 0).mean(axis=1)
        found.append((math.sqrt(square[-1]), math.sqrt(square[:-1].mean())))
    return max(found, key=lambda pair: pair[0] / pair[1] if pair[1] else 0.0)


def power_spectrum(
    heights: ArrayLike, spacing: float | tuple[float, float], periodic: bool = True
) -> tuple[FloatArray, FloatArray]:
    r"""Return the radially averaged power spectrum of heights.

    On a map of area A it is :math:`C = A |c|^2`, such that the sum over all wave
    vectors except zero is

    .. math:: \frac{1}{A} \sum_q C(q) = \langle h^2 \rangle - \langle h \rangle^2 .

    Parameters
    ----------
    heights : array_like, shape (n, m)
        Heights (length).
    spacing : float or (float, float)
        Distance between grid points, or one each along x and y (length).
    periodic : bool
        Whether the heights are periodic. Otherwise they are multiplied by a Hann window
        in both directions, of mean square one, and the sum above holds on average.

    Returns
    -------
    q : ndarray, shape (k,)
        Mean wave number of each ring that is not empty (inverse length). Rings are as
        wide as the distance between wave vectors.
    C : ndarray, shape (k,)
        Mean power spectral density of each ring (length to the fourth power).

    Raises
    ------
    ValueError
        If the heights are not a finite two-dimensional array.

    References
    ----------
    T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001
    (2017).
    """
    h, steps = height_array(heights), axis_spacings(spacing)
    if not periodic:
        window = np.outer(np.hanning(h.shape[0]), np.hanning(h.shape[1]))
        h = (h - h.mean()) * window / math.sqrt(np.mean(window**2))
    square, number, power = _waves(h, steps)
    number[0, 0] = 0
    q = np.sqrt(square)
    ring = np.rint(q * (min(np.multiply(h.shape, steps)) / (2 * np.pi))).astype(int)
    rings = ring.ravel()
    total = np.bincount(rings, weights=number.ravel())
    sum_q = np.bincount(rings, weights=(number * q).ravel())
    sum_power = np.bincount(rings, weights=power.ravel())
    filled = total > 0
    area = h.size * steps[0] * steps[1]
    return sum_q[filled] / total[filled], area * sum_power[filled] / total[filled]


def axis_spacings(spacing: Any) -> tuple[float, float]:
    """Return the distances between points along x and y; one may be given for both."""
    x, y = spacing if np.ndim(spacing) == 1 and len(spacing) == 2 else (spacing,) * 2
    positive(spacing=x)
    positive(spacing=y)
    return float(x), float(y)


def _waves(
    h: FloatArray, spacing: tuple[float, float]
) -> tuple[NDArray[Any], FloatArray, FloatArray]:
    """Return square wave number, multiplicity and mean square height of each wave.

    The heights are real: waves of one half plane also represent the other half plane.
    """
    n, m = h.shape
    qx = 2 * np.pi * fft.fftfreq(n, spacing[0])
    qy = 2 * np.pi * fft.rfftfreq(m, spacing[1])
    square = qx[:, None] ** 2 + qy[None, :] ** 2
    number = np.ones(square.shape)
    number[:, 1 : (m + 1) // 2] = 2
    power = number * np.abs(fft.rfft2(h - h.mean(), norm="forward")) ** 2
    return square, number, power
