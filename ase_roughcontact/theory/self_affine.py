"""Self-affine roughness: parameters, moments of the spectrum, rms curvature.

The spectrum is C(q) ~ q^(-2-2H) between the wavelengths lambda_s and lambda_L, and
constant from lambda_L to the longest wavelength lambda_max, if there is such a
roll-off. With an anisotropy g these are wavelengths across a direction; along it they
are g times longer. The rms slope is h' = ``<|grad h|^2>^(1/2)``, the rms curvature
h'' = ``<(lap h)^2>^(1/2)``. All functions raise `ValueError` for a parameter of the
roughness that is missing, not finite or out of range, or wavelengths that are not in
increasing order.

References
----------
T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001 (2017).
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from scipy.special import boxcox

from ase_roughcontact._util.validation import finite, positive, shown

# Directions of an angular mean.
_ANGLES = 2048


class Roughness(Protocol):
    """Parameters of a self-affine roughness, such as `ase_roughcontact.SelfAffine`.

    An attribute `longest_wavelength`, if there is one that is not None, is the end of
    the roll-off; `anisotropy` the ratio of wavelengths along a direction and across.
    """

    @property
    def rms_slope(self) -> float:
        """Rms slope h', dimensionless."""

    @property
    def hurst(self) -> float:
        """Hurst exponent H."""

    @property
    def short_wavelength(self) -> float:
        """Lower end lambda_s of the self-affine range (length)."""

    @property
    def long_wavelength(self) -> float:
        """Upper end lambda_L of the self-affine range (length)."""


def numbers_of(roughness: Roughness) -> tuple[float, float, float]:
    """Return rms slope, Hurst exponent and shortest wavelength, after checks."""
    try:
        slope, hurst = roughness.rms_slope, roughness.hurst
        short = roughness.short_wavelength
    except AttributeError as error:
        raise ValueError(
            "roughness must have rms_slope, hurst, short_wavelength and "
            "long_wavelength, as SelfAffine and HeightMap do, got "
            f"{shown(roughness)}: give the roughness of a RoughSphere"
        ) from error
    positive(rms_slope=slope, short_wavelength=short)
    finite(hurst=hurst)
    if not 0 < hurst < 1:
        raise ValueError(f"hurst must lie between 0 and 1, got {hurst!r}")
    return slope, hurst, short


def band_of(roughness: Roughness) -> tuple[float, float, float | None]:
    """Return lambda_s, lambda_L and lambda_max, which may be None."""
    longest = getattr(roughness, "longest_wavelength", None)
    return roughness.short_wavelength, roughness.long_wavelength, longest


def angular_mean(power: float, anisotropy: float) -> float:
    r"""Return by how much an anisotropy g reduces a moment of the spectrum.

    Waves that are stretched along a direction by g have

    .. math:: A_m = \frac{1}{2\pi} \int_0^{2\pi}
              (\cos^2\phi/g^2 + \sin^2\phi)^{m/2} d\phi

    times the mean of :math:`q^m`: :math:`A_2 = (1 + g^{-2})/2`.
    """
    if anisotropy == 1.0:
        return 1.0
    # the midpoint rule of a periodic function; the corner of m = 1 needs many points
    angle = np.pi / _ANGLES * (np.arange(_ANGLES) + 0.5)
    square = (np.cos(angle) / anisotropy) ** 2 + np.sin(angle) ** 2
    return float(np.mean(square ** (power / 2)))


def wavelength_ratios(
    short_wavelength: float, long_wavelength: float, longest_wavelength: float | None
) -> tuple[float, float]:
    """Return lambda_s/lambda_L and lambda_L/lambda_max, one without a roll-off.

    lambda_L may be infinite, lambda_max None.
    """
    if not long_wavelength > short_wavelength:
        raise ValueError(
            "long_wavelength must exceed short_wavelength "
            f"{short_wavelength!r}, got {long_wavelength!r}"
        )
    if longest_wavelength is None:
        return short_wavelength / long_wavelength, 1.0
    if not longest_wavelength >= long_wavelength:
        raise ValueError(
            "longest_wavelength must be at least long_wavelength "
            f"{long_wavelength!r}, got {longest_wavelength!r}"
        )
    return short_wavelength / long_wavelength, long_wavelength / longest_wavelength


def spectral_moment(
    power: float,
    hurst: float,
    short_wavelength: float,
    long_wavelength: float = math.inf,
    longest_wavelength: float | None = None,
) -> float:
    r"""Return a moment of the self-affine spectrum.

    With wave numbers x in units of :math:`2\pi/\lambda_s`,
    :math:`\rho = \lambda_s/\lambda_L` and :math:`r = \lambda_L/\lambda_{\max}`,

    .. math:: M_m = \int x^{m+1} \max(x, \rho)^{-2-2H} dx
                  = \frac{1 - \rho^{m-2H}}{m - 2H}
                    + \rho^{m-2H} \frac{1 - r^{m+2}}{m + 2}.

    Parameters
    ----------
    power : float
        Power m: 0 for the mean square height, 2 for the slope, 4 for the curvature.
    hurst : float
        Hurst exponent H, between 0 and 1.
    short_wavelength, long_wavelength : float
        Ends lambda_s and lambda_L of the self-affine range (length); lambda_L may be
        infinite for m >= 2.
    longest_wavelength : float, optional
        End lambda_max of the roll-off (length). Default: no roll-off.

    Returns
    -------
    float
        Moment M_m (dimensionless).
    """
    rho, r = wavelength_ratios(short_wavelength, long_wavelength, longest_wavelength)
    excess = power - 2 * hurst
    roll_off = rho**excess * (1 - r ** (power + 2)) / (power + 2)
    # boxcox(rho, excess) is (rho^excess - 1)/excess, and ln(rho) at excess = 0
    return float(roll_off - boxcox(rho, excess))


def moment_ratio(power: float, other: float, roughness: Roughness) -> float:
    """Return the ratio of two moments of the spectrum, A_m M_m/(A_n M_n).

    See `spectral_moment` and `angular_mean`. One wavelength, lambda_L = lambda_s, is
    allowed: the ratio of M_m and M_n is one then.
    """
    _, hurst, short = numbers_of(roughness)
    positive(long_wavelength=roughness.long_wavelength)
    anisotropy = getattr(roughness, "anisotropy", 1.0)
    ratio = angular_mean(power, anisotropy) / angular_mean(other, anisotropy)
    if roughness.long_wavelength == short:
        return ratio
    band = band_of(roughness)
    moments = [spectral_moment(each, hurst, *band) for each in (power, other)]
    return ratio * moments[0] / moments[1]


def slope_to_curvature_ratio(roughness: Roughness) -> float:
    r"""Return rms slope over rms curvature, :math:`(\lambda_s/2\pi) (M_2/M_4)^{1/2}`.

    For :math:`\lambda_L \gg \lambda_s` it is :math:`[(2-H)/(1-H)]^{1/2}
    \lambda_s/2\pi`.

    Parameters
    ----------
    roughness : Roughness
        Roughness, such as `ase_roughcontact.SelfAffine`.

    Returns
    -------
    float
        Ratio h'/h'' (length).
    """
    _, _, short = numbers_of(roughness)
    return short / (2 * math.pi) * math.sqrt(moment_ratio(2, 4, roughness))


def rms_curvature(roughness: Roughness) -> float:
    """Return the rms curvature, h' over `slope_to_curvature_ratio` (1/length)."""
    return roughness.rms_slope / slope_to_curvature_ratio(roughness)


def rms_height(roughness: Roughness) -> float:
    r"""Return the rms height, :math:`h' (\lambda_s/2\pi) (M_0/M_2)^{1/2}`.

    The height is averaged over realisations (length).
    """
    length = roughness.short_wavelength / (2 * math.pi)
    return roughness.rms_slope * length * math.sqrt(moment_ratio(0, 2, roughness))
