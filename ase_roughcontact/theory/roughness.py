"""Self-affine roughness: its height, its curvature, and where it touches first.

The spectrum is C(q) ~ q^(-2-2H) between the wavelengths lambda_s and lambda_L, and
constant from there to the longest wavelength lambda_max (roll-off), by default none;
rms slope h' = ``<|grad h|^2>^(1/2)``, rms curvature h'' = <(lap h)^2>^(1/2). All
functions broadcast over arrays.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import boxcox

from ase_roughcontact._util.validation import FloatArray, finite_array, positive_array

#: By how much the repulsive 9-3 wall as stiff as the bulk, lambda_s = 4 a0, multiplies
#: rho: L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016).
ASPERITY_FACTOR_REPULSIVE = 3.0


def hurst_exponent(hurst: ArrayLike) -> FloatArray:
    """Return Hurst exponents as an array, checked.

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


def spectral_moment(
    power: float,
    hurst: ArrayLike,
    short_wavelength: ArrayLike,
    long_wavelength: ArrayLike = np.inf,
    longest_wavelength: ArrayLike | None = None,
) -> FloatArray:
    r"""Moment of a self-affine spectrum, in units of its upper end.

    With wave numbers x in units of :math:`2\pi/\lambda_s`, the roll-off from
    :math:`\rho = \lambda_s/\lambda_L` on, and
    :math:`r = \lambda_L/\lambda_{\max}`,

    .. math:: M_m = \int x^{m+1} \max(x, \rho)^{-2-2H} dx
                  = \frac{1 - \rho^{m-2H}}{m - 2H}
                    + \rho^{m-2H} \frac{1 - r^{m+2}}{m + 2}.

    Parameters
    ----------
    power : float
        m: 0 of the square height, 2 of the square slope, 4 of the square curvature.
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
    (2017), on such spectra.
    """
    rho, r = wavelength_ratios(short_wavelength, long_wavelength, longest_wavelength)
    excess = power - 2 * hurst_exponent(hurst)
    # boxcox is (rho^excess - 1)/excess, and the logarithm where excess is zero.
    flat = rho**excess * (1 - r ** (power + 2)) / (power + 2)
    moment: FloatArray = flat - boxcox(rho, excess)
    return moment


def wavelength_ratios(
    short_wavelength: ArrayLike,
    long_wavelength: ArrayLike,
    longest_wavelength: ArrayLike | None,
) -> tuple[FloatArray, FloatArray]:
    """Ratios lambda_s/lambda_L and lambda_L/lambda_max, checked.

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


def rms_height(
    wavelength: ArrayLike,
    rms_slope: ArrayLike,
    hurst: ArrayLike,
    short_wavelength: ArrayLike,
    longest_wavelength: ArrayLike | None = None,
) -> FloatArray:
    """Rms height of the roughness up to a wavelength lambda >> lambda_s.

    h_rms = h' [(1-H)/H]^(1/2) lambda^H lambda_s^(1-H)/(2 pi), and with a roll-off from
    lambda to lambda_max larger by [1 + H - H (lambda/lambda_max)^2]^(1/2).

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
    Integrals of q C(q) and q^3 C(q); on spectra see T. D. B. Jacobs, T. Junge,
    L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001 (2017).
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
    """Ratio of rms slope to rms curvature, [(2-H)/(1-H)]^(1/2) lambda_s/(2 pi).

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
    Integrals of q^3 C(q) and q^5 C(q); on spectra see T. D. B. Jacobs, T. Junge,
    L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001 (2017).
    """
    hurst = hurst_exponent(hurst)
    short = positive_array("short_wavelength", short_wavelength)
    return np.sqrt((2 - hurst) / (1 - hurst)) * short / (2 * np.pi)


def first_contact_radius(
    radius: ArrayLike,
    rms_slope: ArrayLike,
    hurst: ArrayLike,
    short_wavelength: ArrayLike,
) -> FloatArray:
    """Radius around the axis in which the first contact is expected, as printed.

    a'/lambda_s = {2 R h'/lambda_s [(1-H)/H]^(1/2)}^(1/(2-H)), for a' < lambda_L.

    Parameters
    ----------
    radius : array_like
        R of the sphere, length.
    rms_slope : array_like
        h', dimensionless.
    hurst : array_like
        H, between 0 and 1.
    short_wavelength : array_like
        lambda_s, length.

    Returns
    -------
    ndarray
        a', length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or out of range.

    Notes
    -----
    The printed brace lacks a factor 1/(2 pi) that a'^2 = 2 R h_rms(a') implies with
    `rms_height`: it makes a' larger by (2 pi)^(1/(2-H)), 4.6 for H = 0.8.
    `first_contact_radius_from_height` has the factor.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eq. (3).
    """
    radius = positive_array("radius", radius)
    slope = positive_array("rms_slope", rms_slope)
    hurst = hurst_exponent(hurst)
    short = positive_array("short_wavelength", short_wavelength)
    brace = 2 * radius * slope / short * np.sqrt((1 - hurst) / hurst)
    return short * brace ** (1 / (2 - hurst))


def first_contact_radius_from_height(
    radius: ArrayLike,
    rms_slope: ArrayLike,
    hurst: ArrayLike,
    short_wavelength: ArrayLike,
) -> FloatArray:
    """Radius at which the sphere rises by the rms height, a'^2 = 2 R h_rms(a').

    a'/lambda_s = {R h'/(pi lambda_s) [(1-H)/H]^(1/2)}^(1/(2-H)), for a' < lambda_L.

    Parameters
    ----------
    radius : array_like
        R of the sphere, length.
    rms_slope : array_like
        h', dimensionless.
    hurst : array_like
        H, between 0 and 1.
    short_wavelength : array_like
        lambda_s, length.

    Returns
    -------
    ndarray
        a', length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or out of range.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), before eq. (3),
    solved with `rms_height`.
    """
    printed = first_contact_radius(radius, rms_slope, hurst, short_wavelength)
    return printed / (2 * np.pi) ** (1 / (2 - np.asarray(hurst, dtype=float)))


def asperity_radius(
    rms_slope: ArrayLike, hurst: ArrayLike, short_wavelength: ArrayLike
) -> FloatArray:
    """Radius of the first asperity, rho = lambda_s/(2 pi h') [2(2-H)/(1-H)]^(1/2).

    Parameters
    ----------
    rms_slope : array_like
        h', dimensionless.
    hurst : array_like
        H, between 0 and 1.
    short_wavelength : array_like
        lambda_s, length.

    Returns
    -------
    ndarray
        rho, length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or out of range.

    Notes
    -----
    As printed, where it is equated with 2/h''. By `slope_to_curvature_ratio`, 2/h''
    is larger by sqrt(2); `asperity_radius_from_curvature` gives that.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eq. (6), right.
    """
    slope = positive_array("rms_slope", rms_slope)
    return np.sqrt(2) * slope_to_curvature_ratio(hurst, short_wavelength) / slope


def asperity_radius_from_curvature(rms_curvature: ArrayLike) -> FloatArray:
    """Radius of the first asperity, rho = 2/h''.

    Parameters
    ----------
    rms_curvature : array_like
        h'', inverse length.

    Returns
    -------
    ndarray
        rho, length; shape of the argument.

    Raises
    ------
    ValueError
        If the argument is not finite and positive.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eq. (6), left.
    """
    return 2 / positive_array("rms_curvature", rms_curvature)
