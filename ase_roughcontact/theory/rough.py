"""The rough sphere: contact area and crossover load.

Rms slope h' = ``<|grad h|^2>^(1/2)``, contact modulus E* = E/(1 - nu^2). All functions
broadcast over arrays and take any consistent system of units.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import erf

from ase_roughcontact._util.validation import (
    FloatArray,
    nonnegative_array,
    positive_array,
)
from ase_roughcontact.theory.hertz import hertz_contact_radius
from ase_roughcontact.theory.rough_flats import KAPPA_HARD


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
    return predicted_area(normal_force, radius, contact_modulus, rough_pressure)


def predicted_area(
    normal_force: ArrayLike,
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    flat: ArrayLike | Callable[[FloatArray], FloatArray],
    *,
    asperity_radius: ArrayLike | None = None,
    asperity_area: ArrayLike = 0.0,
) -> FloatArray:
    """Contact area of a rough sphere from the first asperity to full contact.

    A = max(A_Hertz(rho), A_adh, A_Hertz f(N/A_Hertz)) with A_Hertz(rho) the
    area of a smooth sphere of radius rho, at most R.

    Parameters
    ----------
    normal_force : array_like
        N >= 0, force.
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    flat : array_like or callable
        What is known of nominally flat surfaces: p_rough of `mean_contact_pressure`, or
        a function f of the nominal pressure (force per area), such as
        `FlatReference.fraction`.
    asperity_radius : array_like, optional
        rho of `asperity_radius`, times `ASPERITY_FACTOR_REPULSIVE` for the repulsive
        wall; length. Default: no first asperity.
    asperity_area : array_like
        A_adh >= 0 that an adhesive first asperity has at any small load, area.

    Returns
    -------
    ndarray
        A, area; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or of the wrong sign.

    Notes
    -----
    Of both curves the larger one holds: one asperity is enough as long as its pressure
    N/A_Hertz(rho) is below p_rough. Where both are equal, at `crossover_load` with
    rho in place of R while f is linear, more asperities begin to share the load at
    p_rough, and touch on more area than the first one would alone. The corner is
    sharp; a measured curve is round. With adhesion, A_adh is fitted to a realisation.

    For R = 1000 a0, h' = 0.1 and the repulsive wall, three realisations had 0.11 to
    0.16 of the area of Hertz below N_c(rho), where this says 0.16 (rho three times eq.
    6), and 0.68 of it at 0.92 N_c, where the error function says 0.78 and the tabulated
    `FlatReference` 0.65. With w = 0.005 E* a0 and N_c of the repulsive wall the sphere
    had 0.79 at 0.1 N_c and 0.84 at 0.92 N_c, the table 0.49 and 0.74. Likely
    its contact, smaller than lambda_L, lacks the long waves that part flats.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eqs. (2), (4) and
    (6), and fig. 2.
    """
    a = hertz_contact_radius(normal_force, radius, contact_modulus)
    # N/A_Hertz without dividing by the area, which vanishes with N.
    pressure = 4 / (3 * np.pi) * np.divide(contact_modulus, radius) * a
    fraction = flat(pressure) if callable(flat) else contact_fraction(pressure, flat)
    if asperity_radius is not None:
        plateau = low_load_plateau(asperity_radius, radius)
        fraction = np.maximum(fraction, np.minimum(plateau, 1.0))
    least = nonnegative_array("asperity_area", asperity_area)
    return np.maximum(np.pi * a**2 * fraction, least)


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
