"""The rough sphere: contact area and crossover load.

Rms slope h' = <|grad h|^2>^(1/2), contact modulus E* = E/(1 - nu^2). All functions
broadcast over arrays and take any consistent system of units.
"""

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf

from ase_roughcontact.checks import FloatArray, nonnegative_array, positive_array
from ase_roughcontact.theory.hertz import hertz_contact_radius
from ase_roughcontact.theory.kappa import KAPPA_HARD


def contact_fraction(pressure: ArrayLike, rough_pressure: ArrayLike) -> FloatArray:
    """Fraction of rough flats in contact, f(p) = erf(sqrt(pi) p/(2 p_rough)).

    Parameters
    ----------
    pressure : array_like
        Nominal pressure p = N/A0 >= 0, force per area.
    rough_pressure : array_like
        p_rough of `mean_contact_pressure`, force per area.

    Returns
    -------
    ndarray
        f between 0 and 1; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or of the wrong sign.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eq. (2).
    """
    pressure = nonnegative_array("pressure", pressure)
    scale = positive_array("rough_pressure", rough_pressure)
    fraction: FloatArray = erf(np.sqrt(np.pi) / 2 * pressure / scale)
    return fraction


def contact_area(
    normal_force: ArrayLike,
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    rough_pressure: ArrayLike,
) -> FloatArray:
    """Contact area of a rough sphere, A = A_Hertz f(N/A_Hertz).

    It tends to N/p_rough at small and to A_Hertz at large force.

    Parameters
    ----------
    normal_force : array_like
        N >= 0, force.
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    rough_pressure : array_like
        p_rough of `mean_contact_pressure`, force per area.

    Returns
    -------
    ndarray
        A, area; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or of the wrong sign.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eq. (4).
    """
    a = hertz_contact_radius(normal_force, radius, contact_modulus)
    # N/A_Hertz without dividing by the area, which vanishes with N.
    stiffness = np.divide(contact_modulus, radius)
    pressure = 4 / (3 * np.pi) * stiffness * a
    return np.pi * a**2 * contact_fraction(pressure, rough_pressure)


def crossover_load(
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    rms_slope: ArrayLike,
    kappa: ArrayLike = KAPPA_HARD,
) -> FloatArray:
    """Load from rough to Hertzian contact, N_c = (9 pi^3/16) E* R^2 (h'/kappa)^3.

    Parameters
    ----------
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    rms_slope : array_like
        h', dimensionless.
    kappa : array_like
        Dimensionless.

    Returns
    -------
    ndarray
        N_c, force; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite and positive.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eq. (5).
    """
    radius = positive_array("radius", radius)
    modulus = positive_array("contact_modulus", contact_modulus)
    ratio = crossover_radius_ratio(rms_slope, kappa)
    return 4 / 3 * modulus * radius**2 * ratio**3


def crossover_radius_ratio(
    rms_slope: ArrayLike, kappa: ArrayLike = KAPPA_HARD
) -> FloatArray:
    """Contact radius at the crossover load, a/R = (3 pi/4) h'/kappa.

    Parameters
    ----------
    rms_slope : array_like
        h', dimensionless.
    kappa : array_like
        Dimensionless.

    Returns
    -------
    ndarray
        a/R, dimensionless; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite and positive.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), after eq. (6).
    """
    slope = positive_array("rms_slope", rms_slope)
    return 0.75 * np.pi * slope / positive_array("kappa", kappa)


def low_load_plateau(asperity_radius: ArrayLike, radius: ArrayLike) -> FloatArray:
    """Value of A/A_Hertz while one asperity carries the load, (rho/R)^(2/3).

    Parameters
    ----------
    asperity_radius : array_like
        rho, length.
    radius : array_like
        R of the sphere, length.

    Returns
    -------
    ndarray
        A/A_Hertz, dimensionless; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite and positive.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), with eq. (6).
    """
    rho = positive_array("asperity_radius", asperity_radius)
    return np.cbrt(rho / positive_array("radius", radius)) ** 2
