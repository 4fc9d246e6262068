"""Self-affine roughness: moments of the spectrum, rms height and curvature.

The spectrum is C(q) ~ q^(-2-2H) between the wavelengths lambda_s and lambda_L, and
constant from lambda_L to the longest wavelength lambda_max, if there is such a
roll-off. The rms slope is h' = ``<|grad h|^2>^(1/2)``, the rms curvature
h'' = ``<(lap h)^2>^(1/2)``. All functions broadcast over arrays.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import boxcox

from ase_roughcontact._util.validation import FloatArray, finite_array, positive_array


def hurst_exponent(hurst: ArrayLike) -> FloatArray:
    """Return Hurst exponents as an array, or raise an error.

    Parameters
    ----------
    hurst : array_like
        H, dimensionless.

    Returns
    -------
    ndarray
        H, shape of the argument.

    Raises
    ------
    ValueError
        Unless 0 < H < 1.
    """
    array = finite_array("hurst", hurst)
    if not np.all((array > 0) & (array < 1)):
        raise ValueError(f"hurst must lie between 0 and 1, got {hurst!r}")
    return array


def wavelength_ratios(
    short_wavelength: ArrayLike,
    long_wavelength: ArrayLike,
    longest_wavelength: ArrayLike | None,
) -> tuple[FloatArray, FloatArray]:
    """Return lambda_s/lambda_L and lambda_L/lambda_max, or raise an error.

    Parameters
    ----------
    short_wavelength, long_wavelength : array_like
        Ends lambda_s and lambda_L of the self-affine range, lengths; lambda_L may be
        infinite.
    longest_wavelength : array_like, optional
        lambda_max of the roll-off, length; `long_wavelength` if there is none.

    Returns
    -------
    ratio, roll_off : ndarray
        The second one is 1 without a roll-off.

    Raises
    ------
    ValueError
        If a wavelength is not positive, lambda_L <= lambda_s, or lambda_max < lambda_L.
    """
    short = positive_array("short_wavelength", short_wavelength)
    long = np.asarray(long_wavelength, dtype=float)
    if not np.all(long > short):
        raise ValueError(
            "long_wavelength must exceed short_wavelength "
            f"{short_wavelength!r}, got {long_wavelength!r}"
        )
    if longest_wavelength is None:
        return short / long, np.ones(())
    longest = positive_array("longest_wavelength", longest_wavelength)
    if not np.all(longest >= long):
        raise ValueError(
            "longest_wavelength must be at least long_wavelength "
            f"{long_wavelength!r}, got {longest_wavelength!r}"
        )
    return short / long, long / longest


def spectral_moment(
    power: float,
    hurst: ArrayLike,
    short_wavelength: ArrayLike,
    long_wavelength: ArrayLike = np.inf,
    longest_wavelength: ArrayLike | None = None,
) -> FloatArray:
    r"""Return a moment of the self-affine spectrum, dimensionless.

    With wave numbers x in units of :math:`2\pi/\lambda_s`,
    :math:`\rho = \lambda_s/\lambda_L` and :math:`r = \lambda_L/\lambda_{\max}`,

    .. math:: M_m = \int x^{m+1} \max(x, \rho)^{-2-2H} dx
                  = \frac{1 - \rho^{m-2H}}{m - 2H}
                    + \rho^{m-2H} \frac{1 - r^{m+2}}{m + 2}.

    Parameters
    ----------
    power : float
        m: 0 for the mean square height, 2 for the slope, 4 for the curvature.
    hurst : array_like
        H, between 0 and 1.
    short_wavelength, long_wavelength : array_like
        Ends lambda_s and lambda_L of the self-affine range, lengths; lambda_L may be
        infinite for m >= 2.
    longest_wavelength : array_like, optional
        lambda_max of the roll-off, length. Default: no roll-off.

    Returns
    -------
    ndarray
        Dimensionless; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or out of range, lambda_L <= lambda_s, or
        lambda_max < lambda_L.

    References
    ----------
    T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001
    (2017).
    """
    rho, r = wavelength_ratios(short_wavelength, long_wavelength, longest_wavelength)
    excess = power - 2 * hurst_exponent(hurst)
    roll_off = rho**excess * (1 - r ** (power + 2)) / (power + 2)
    # boxcox(rho, excess) is (rho^excess - 1)/excess, and ln(rho) at excess = 0
    moment: FloatArray = roll_off - boxcox(rho, excess)
    return moment


def rms_height(
    wavelength: ArrayLike,
    rms_slope: ArrayLike,
    hurst: ArrayLike,
    short_wavelength: ArrayLike,
    longest_wavelength: ArrayLike | None = None,
) -> FloatArray:
    """Return the rms height of the waves up to a wavelength lambda >> lambda_s.

    h_rms = h' [(1-H)/H]^(1/2) lambda^H lambda_s^(1-H)/(2 pi), multiplied by
    [1 + H - H (lambda/lambda_max)^2]^(1/2) if there is a roll-off from lambda to
    lambda_max.

    Parameters
    ----------
    wavelength : array_like
        lambda, length.
    rms_slope : array_like
        h', dimensionless.
    hurst : array_like
        H, between 0 and 1.
    short_wavelength : array_like
        lambda_s, length.
    longest_wavelength : array_like, optional
        lambda_max >= lambda, length. Default: no roll-off.

    Returns
    -------
    ndarray
        h_rms, length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or out of range.

    References
    ----------
    T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001
    (2017): ratio of the integrals of q C(q) and q^3 C(q).
    """
    slope = positive_array("rms_slope", rms_slope)
    hurst = hurst_exponent(hurst)
    short = positive_array("short_wavelength", short_wavelength)
    scale = positive_array("wavelength", wavelength) ** hurst * short ** (1 - hurst)
    _, roll_off = wavelength_ratios(short_wavelength, wavelength, longest_wavelength)
    square = (1 - hurst) / hurst * (1 + hurst * (1 - roll_off**2))
    return slope * np.sqrt(square) * scale / (2 * np.pi)


def slope_to_curvature_ratio(
    hurst: ArrayLike, short_wavelength: ArrayLike
) -> FloatArray:
    """Return rms slope over rms curvature, [(2-H)/(1-H)]^(1/2) lambda_s/(2 pi).

    It holds for lambda_L >> lambda_s.

    Parameters
    ----------
    hurst : array_like
        H, between 0 and 1.
    short_wavelength : array_like
        lambda_s, length.

    Returns
    -------
    ndarray
        h'/h'', length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or out of range.

    References
    ----------
    T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001
    (2017): ratio of the integrals of q^3 C(q) and q^5 C(q).
    """
    hurst = hurst_exponent(hurst)
    short = positive_array("short_wavelength", short_wavelength)
    return np.sqrt((2 - hurst) / (1 - hurst)) * short / (2 * np.pi)
