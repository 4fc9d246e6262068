"""Contact of nominally flat rough surfaces: kappa, contact fraction and adhesion.

The mean pressure in the contacts is p_rough = h' E*/kappa, with the rms slope
h' = ``<|grad h|^2>^(1/2)`` and E* = E/(1 - nu^2). All functions broadcast over arrays,
accept any consistent system of units, and raise `ValueError` for an argument that is
not finite or out of range.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf, hyp2f1

from ase_roughcontact._util.validation import (
    FloatArray,
    nonnegative_array,
    positive,
    positive_array,
)
from ase_roughcontact.theory.self_affine import (
    Roughness,
    band_of,
    moment_ratio,
    numbers_of,
    slope_to_curvature_ratio,
    spectral_moment,
    wavelength_ratios,
)

#: Constant kappa of hard walls in the continuum limit: S. Hyun et al., Phys. Rev. E 70,
#: 026117 (2004); N. Prodanov, W. B. Dapp, M. H. Müser, Tribol. Lett. 53, 433 (2014).
KAPPA_HARD = 2.0

#: Constant kappa of Persson's theory: B. N. J. Persson, J. Chem. Phys. 115, 3840
#: (2001).
KAPPA_PERSSON = float(np.sqrt(8.0 / np.pi))

#: Constant kappa of the repulsive 9-3 wall as stiff as the bulk, lambda_s = 4 a0: L.
#: Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016).
KAPPA_REPULSIVE = 2.9


def mean_contact_pressure(
    rms_slope: ArrayLike, contact_modulus: ArrayLike, kappa: ArrayLike = KAPPA_HARD
) -> FloatArray:
    """Return the mean pressure in the contacts, p_rough = h' E*/kappa.

    Parameters
    ----------
    rms_slope : array_like
        Rms slope h' (dimensionless).
    contact_modulus : array_like
        Contact modulus E* (force per area).
    kappa : array_like
        Constant kappa (dimensionless).

    Returns
    -------
    ndarray
        Mean pressure p_rough (force per area).

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), before eq. (2).
    """
    slope = positive_array("rms_slope", rms_slope)
    modulus = positive_array("contact_modulus", contact_modulus)
    return slope * modulus / positive_array("kappa", kappa)


def contact_fraction(pressure: ArrayLike, rough_pressure: ArrayLike) -> FloatArray:
    """Return the fraction of the area in contact, f(p) = erf(sqrt(pi) p/(2 p_rough)).

    Parameters
    ----------
    pressure : array_like
        Nominal pressure p = N/A0 >= 0 (force per area).
    rough_pressure : array_like
        Mean pressure p_rough, see `mean_contact_pressure` (force per area).

    Returns
    -------
    ndarray
        Contact fraction f, between 0 and 1.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eq. (2).
    """
    pressure = nonnegative_array("pressure", pressure)
    scale = positive_array("rough_pressure", rough_pressure)
    fraction: FloatArray = erf(np.sqrt(np.pi) / 2 * pressure / scale)
    return fraction


def compliant_kappa(
    wall_stiffness: ArrayLike,
    contact_modulus: ArrayLike,
    roughness: Roughness,
    kappa_hard: ArrayLike = KAPPA_HARD,
) -> FloatArray:
    """Return an estimate of kappa for a repulsive wall of finite stiffness.

    kappa = kappa_hard [<q^2 C>/<q^2 C/(1 + E* q/2k)^2>]^(1/2), with the spectrum
    C ~ q^(-2-2H) between lambda_s and lambda_L, constant from there to lambda_max.

    Parameters
    ----------
    wall_stiffness : array_like
        Stiffness k = V''(r0) (force per volume).
    contact_modulus : array_like
        Contact modulus E* (force per area).
    roughness : Roughness
        Roughness, such as `ase_roughcontact.SelfAffine`; lambda_L may be infinite.
    kappa_hard : array_like
        Constant kappa of the hard wall (dimensionless).

    Returns
    -------
    ndarray
        Constant kappa >= kappa_hard (dimensionless).

    Notes
    -----
    In series with the wall the stiffness of the half space, E* q/2, becomes
    1/(2/(E* q) + 1/k), which lowers the rms pressure at full contact. With b = E*/2k,
    mu = 2 - 2H in the self-affine range and mu = 4 in the roll-off, the averages follow
    from

    int q^(mu-1)/(1 + b q)^2 dq = (q^mu/mu) 2F1(2, mu; mu + 1; -b q).

    References
    ----------
    An estimate of this package, in place of the expression in the supplement (S-2) of
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016).
    """
    modulus = positive_array("contact_modulus", contact_modulus)
    hard = positive_array("kappa_hard", kappa_hard)
    stiffness = positive_array("wall_stiffness", wall_stiffness)
    _, hurst, short = numbers_of(roughness)
    rho, r = wavelength_ratios(*band_of(roughness))
    # b q at the wavelengths lambda_s, lambda_L and lambda_max
    start = np.pi * modulus / (stiffness * short)
    knee, end = start * rho, start * rho * r
    mu = 2 - 2 * hurst

    # wave numbers in units of 2 pi/lambda_s
    compliant = _integral(mu, start) - rho**mu * _integral(mu, knee)
    compliant += rho**mu * (_integral(4.0, knee) - r**4 * _integral(4.0, end))
    return hard * np.sqrt(spectral_moment(2, hurst, *band_of(roughness)) / compliant)


def _integral(mu: FloatArray | float, b: FloatArray) -> FloatArray:
    """Return the integral of x^(mu-1)/(1 + b x)^2 from 0 to 1."""
    integral: FloatArray = hyp2f1(2, mu, mu + 1, -b) / mu
    return integral


def inverse_kappa_attractive(
    work_of_adhesion: ArrayLike,
    contact_modulus: ArrayLike,
    attraction_range: ArrayLike,
    rms_slope: ArrayLike,
    rms_curvature: ArrayLike,
) -> FloatArray:
    """Return the attractive part of 1/kappa.

    1/kappa_att = pi (3/16)^(2/3) (w/E*)/(h' D) [4 D/(h' d)]^(2/3), d = 4 h'/h''.

    Parameters
    ----------
    work_of_adhesion : array_like
        Work of adhesion w (energy per area).
    contact_modulus : array_like
        Contact modulus E* (force per area).
    attraction_range : array_like
        Range D of the attraction (length).
    rms_slope : array_like
        Rms slope h' (dimensionless).
    rms_curvature : array_like
        Rms curvature h'' = <(lap h)^2>^(1/2) (inverse length).

    Returns
    -------
    ndarray
        Attractive part 1/kappa_att (dimensionless).

    References
    ----------
    L. Pastewka, M. O. Robbins, Proc. Natl. Acad. Sci. USA 111, 3298 (2014).
    """
    work = positive_array("work_of_adhesion", work_of_adhesion)
    modulus = positive_array("contact_modulus", contact_modulus)
    distance = positive_array("attraction_range", attraction_range)
    slope = positive_array("rms_slope", rms_slope)
    diameter = 4 * slope / positive_array("rms_curvature", rms_curvature)
    geometry = np.cbrt(3 / 16 * 4 * distance / (slope * diameter)) ** 2
    inverse: FloatArray = np.pi * work / (modulus * slope * distance) * geometry
    return inverse


def inverse_kappa(
    contact_modulus: float,
    roughness: Roughness,
    work_of_adhesion: float = 0.0,
    attraction_range: float | None = None,
    kappa_repulsive: float = KAPPA_HARD,
) -> float:
    """Return 1/kappa_rep of the repulsion minus `inverse_kappa_attractive`.

    Parameters
    ----------
    contact_modulus : float
        Contact modulus E* (force per area).
    roughness : Roughness
        Roughness, such as `ase_roughcontact.SelfAffine`.
    work_of_adhesion : float
        Work of adhesion w (energy per area).
    attraction_range : float, optional
        Range D of the attraction (length); without it there is no attraction.
    kappa_repulsive : float
        Constant kappa without the attraction (dimensionless).

    Returns
    -------
    float
        Inverse 1/kappa; negative or zero if the flats adhere without a load.
    """
    if attraction_range is None or work_of_adhesion == 0:
        return 1 / kappa_repulsive
    slope = roughness.rms_slope
    curvature = slope / slope_to_curvature_ratio(roughness)
    attraction = inverse_kappa_attractive(
        work_of_adhesion, contact_modulus, attraction_range, slope, curvature
    )
    return float(1 / kappa_repulsive - attraction)


def flattening_energy(contact_modulus: float, roughness: Roughness) -> float:
    """Return the elastic energy per area of rough flats in full contact.

    The mean energy (E*/4) <q h^2> is, with the moments M_m of the spectrum,

    U = (E*/4) h'^2 (lambda_s/2 pi) M_1/M_2.

    If the work of adhesion w exceeds U, full contact is stable, and the surfaces behave
    like smooth ones with the work of adhesion w - U.

    Parameters
    ----------
    contact_modulus : float
        Contact modulus E* (force per area).
    roughness : Roughness
        Roughness, such as `ase_roughcontact.SelfAffine`.

    Returns
    -------
    float
        Energy U (energy per area).

    References
    ----------
    B. N. J. Persson, E. Tosatti, J. Chem. Phys. 115, 5597 (2001).
    """
    positive(contact_modulus=contact_modulus)
    slope, _, short = numbers_of(roughness)
    length = short / (2 * np.pi) * moment_ratio(1, 2, roughness)
    return float(contact_modulus * slope**2 / 4 * length)
