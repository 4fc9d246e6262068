r"""Self-affine parameters of a measured surface.

The Hurst exponent follows from the power spectrum, :math:`C \sim q^{-2-2H}`. The ends
of the self-affine range belong to a surface with the same rms height h, slope h' and
curvature h''. With the moments :math:`M_m` of the spectrum, see
`ase_roughcontact.theory.self_affine.spectral_moment`,

.. math:: \frac{M_0 M_4}{M_2^2} = \frac{h^2 h''^2}{h'^4}, \qquad
          \lambda_s = 2\pi \frac{h'}{h''} \left(\frac{M_4}{M_2}\right)^{1/2}.

The spectrum is fitted inside this range: both are determined alternately.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.theory.self_affine import spectral_moment
from ase_roughcontact.topography.spectrum import Statistics

# The range of the fit is the self-affine range, shortened at both ends by this factor:
# pixels blur the shortest waves, and detrending changes the longest ones.
_RANGE_MARGIN = 1.5
# Number of determinations, the first of them with a Hurst exponent of 0.5.
_ITERATIONS = 12
# Number of intervals of the wave number, of equal ratio, with one weight each.
_INTERVALS = 12
# Density relative to the largest one below which it is a rounding error.
_MIN_RELATIVE_DENSITY = 1e-12
# Smallest Hurst exponent.
_MIN_HURST = 0.05
# Largest Hurst exponent.
_MAX_HURST = 0.95
# Smallest ratio of the ends of the self-affine range.
_MIN_RANGE = 1.01
# Largest ratio of the ends of the self-affine range.
_MAX_RANGE = 1e8


@dataclass(frozen=True)
class SelfAffineFit(Statistics):
    """Parameters of a self-affine surface with the statistics of a measured one.

    Parameters
    ----------
    hurst : float
        Hurst exponent H.
    short_wavelength, long_wavelength : float
        Ends of the self-affine range (length).
    """

    hurst: float
    short_wavelength: float
    long_wavelength: float

    @classmethod
    def of(
        cls,
        statistics: Statistics,
        wave_number: FloatArray,
        density: FloatArray,
        longest: float,
    ) -> SelfAffineFit:
        """Return the parameters for statistics and a power spectrum.

        Wave numbers and densities have the shape (k,); `longest` is the size of the
        map.

        Raises
        ------
        ValueError
            If the surface is flat.
        """
        height, slope = statistics.rms_height, statistics.rms_slope
        curvature = statistics.rms_curvature
        if not slope > 0.0 or not curvature > 0.0:
            raise ValueError("a flat map has no self-affine parameters")
        hurst, ends = 0.5, (0.0, longest)
        for _ in range(_ITERATIONS):
            ends = _ends(height, slope, curvature, hurst, longest)
            hurst = 0.5 * (hurst + _hurst(wave_number, density, *ends, hurst))
        short, long = ends
        return cls(height, slope, curvature, hurst, short, long)

    @classmethod
    def with_hurst(
        cls, statistics: Statistics, hurst: float, longest: float
    ) -> SelfAffineFit:
        """Return the parameters for statistics and a given Hurst exponent.

        The upper end of the range is at most `longest` (length).
        """
        height, slope = statistics.rms_height, statistics.rms_slope
        curvature = statistics.rms_curvature
        short, long = _ends(height, slope, curvature, hurst, longest)
        return cls(height, slope, curvature, hurst, short, long)


def _ends(
    height: float, slope: float, curvature: float, hurst: float, longest: float
) -> tuple[float, float]:
    """Return the ends of the self-affine range of a surface."""
    wanted = math.log(height**2 * curvature**2 / slope**4)

    def moments(log_ratio: float) -> list[float]:
        long = math.exp(log_ratio)
        return [spectral_moment(m, hurst, 1.0, long) for m in (0, 2, 4)]

    def excess(log_ratio: float) -> float:
        m0, m2, m4 = moments(log_ratio)
        return math.log(m0 * m4 / m2**2) - wanted

    least, largest = math.log(_MIN_RANGE), math.log(_MAX_RANGE)
    if excess(least) >= 0.0:
        log_ratio = least
    elif excess(largest) <= 0.0:
        log_ratio = largest
    else:
        log_ratio = brentq(excess, least, largest)
    _, m2, m4 = moments(log_ratio)
    short = 2 * math.pi * slope / curvature * math.sqrt(m4 / m2)
    return short, max(min(short * math.exp(log_ratio), longest), _MIN_RANGE * short)


def _hurst(
    wave_number: FloatArray,
    density: FloatArray,
    short: float,
    long: float,
    default: float,
) -> float:
    """Return the Hurst exponent of a spectrum, from its slope on logarithmic axes."""
    first, last = (
        2 * math.pi * _RANGE_MARGIN / long,
        2 * math.pi / (_RANGE_MARGIN * short),
    )
    used = (wave_number >= first) & (wave_number <= last)
    used &= density > _MIN_RELATIVE_DENSITY * density.max()
    x, y = np.log(wave_number[used]), np.log(density[used])
    if x.size < 2 or x.max() - x.min() < math.log(2.0):
        return default
    edges = np.linspace(x.min(), x.max(), _INTERVALS)
    interval = np.digitize(x, edges)
    count = np.bincount(interval)
    filled = count > 0
    x, y = (np.bincount(interval, v)[filled] / count[filled] for v in (x, y))
    return float(np.clip(-0.5 * np.polyfit(x, y, 1)[0] - 1.0, _MIN_HURST, _MAX_HURST))
