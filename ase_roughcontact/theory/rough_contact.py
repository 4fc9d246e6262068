"""First contact of rough spheres, contact area and crossover to Hertzian contact.

The rms slope is h' = ``<|grad h|^2>^(1/2)``, the rms curvature
h'' = ``<(lap h)^2>^(1/2)``, the contact modulus E* = E/(1 - nu^2). All functions
broadcast over arrays, accept any consistent system of units, and raise `ValueError` for
an argument that is not finite or out of range. Equations are numbered as in L.
Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import (
    FloatArray,
    nonnegative_array,
    positive_array,
)
from ase_roughcontact.theory.rough_flats import KAPPA_HARD, contact_fraction
from ase_roughcontact.theory.self_affine import Roughness, numbers_of
from ase_roughcontact.theory.smooth_sphere import Hertz

#: Factor by which the compliance of the repulsive 9-3 wall increases rho, for the
#: stiffness of the bulk and lambda_s = 4 a0: L. Pastewka, M. O. Robbins, Appl. Phys.
#: Lett. 108, 221601 (2016).
ASPERITY_FACTOR_REPULSIVE = 3.0


def first_contact_radius(radius: ArrayLike, roughness: Roughness) -> FloatArray:
    """Return the radius around the axis within which the first contact is expected.

    Eq. (3) as printed: a'/lambda_s =
    {2 R h'/lambda_s [(1-H)/H]^(1/2)}^(1/(2-H)), for a' < lambda_L.

    Parameters
    ----------
    radius : array_like
        Radius R of the sphere (length).
    roughness : Roughness
        Roughness of the sphere, such as `ase_roughcontact.SelfAffine`.

    Returns
    -------
    ndarray
        Radius a' (length).

    Notes
    -----
    The condition a'^2 = 2 R h_rms(a'), with the rms height of the waves up to a', gives
    a further factor 1/(2 pi) in the brace, which makes a' smaller by
    (2 pi)^(1/(2-H)), 4.6 for H = 0.8: `first_contact_radius_from_height`.
    """
    slope, hurst, short = numbers_of(roughness)
    radius = positive_array("radius", radius)
    brace = 2 * radius * slope / short * np.sqrt((1 - hurst) / hurst)
    return short * brace ** (1 / (2 - hurst))


def first_contact_radius_from_height(
    radius: ArrayLike, roughness: Roughness
) -> FloatArray:
    """Return the radius at which the sphere has risen by the rms height.

    The solution of a'^2 = 2 R h_rms(a'), from which eq. (3) follows, is a'/lambda_s =
    {R h'/(pi lambda_s) [(1-H)/H]^(1/2)}^(1/(2-H)), for a' < lambda_L.

    Parameters
    ----------
    radius, roughness
        See `first_contact_radius`.

    Returns
    -------
    ndarray
        Radius a' (length).
    """
    printed = first_contact_radius(radius, roughness)
    return printed / (2 * np.pi) ** (1 / (2 - roughness.hurst))


def asperity_radius(roughness: Roughness) -> float:
    """Return the radius of the first asperity in contact.

    Eq. (6), right, as printed: rho = lambda_s/(2 pi h') [2(2-H)/(1-H)]^(1/2).

    Parameters
    ----------
    roughness : Roughness
        Roughness, such as `ase_roughcontact.SelfAffine`.

    Returns
    -------
    float
        Radius rho of the first asperity (length).

    Notes
    -----
    The paper equates rho with 2/h'', which is larger by sqrt(2) for lambda_L >>
    lambda_s: `asperity_radius_from_curvature`.
    """
    slope, hurst, short = numbers_of(roughness)
    return float(short / (2 * np.pi * slope) * np.sqrt(2 * (2 - hurst) / (1 - hurst)))


def asperity_radius_from_curvature(rms_curvature: ArrayLike) -> FloatArray:
    """Return the radius of the first asperity from the rms curvature, rho = 2/h''.

    Eq. (6), left.

    Parameters
    ----------
    rms_curvature : array_like
        Rms curvature h'' (inverse length), for example of a measured surface.

    Returns
    -------
    ndarray
        Radius rho of the first asperity (length).
    """
    return 2 / positive_array("rms_curvature", rms_curvature)


def low_load_plateau(asperity_radius: ArrayLike, radius: ArrayLike) -> FloatArray:
    """Return A/A_Hertz while one asperity carries the load, (rho/R)^(2/3).

    Parameters
    ----------
    asperity_radius : array_like
        Radius rho of the first asperity (length).
    radius : array_like
        Radius R of the sphere (length).

    Returns
    -------
    ndarray
        Ratio A/A_Hertz (dimensionless).
    """
    rho = positive_array("asperity_radius", asperity_radius)
    return np.cbrt(rho / positive_array("radius", radius)) ** 2


def predicted_area(
    normal_force: ArrayLike,
    radius: float,
    contact_modulus: float,
    flat: ArrayLike | Callable[[FloatArray], FloatArray],
    *,
    asperity_radius: ArrayLike | None = None,
    asperity_area: ArrayLike = 0.0,
) -> FloatArray:
    """Return the contact area of a rough sphere at any load.

    A = max(A_Hertz(rho), A_adh, A_Hertz f(N/A_Hertz)), where A_Hertz(rho) is the area
    of a smooth sphere with the radius rho of the first asperity, at most R. The last
    term alone is Eq. (4), which tends to N/p_rough at small force and to A_Hertz at
    large force.

    Parameters
    ----------
    normal_force : array_like
        Normal force N >= 0 (force).
    radius : float
        Radius R of the sphere (length).
    contact_modulus : float
        Contact modulus E* (force per area).
    flat : array_like or callable
        Contact of nominally flat surfaces: p_rough of `mean_contact_pressure` for the
        error function, or a function f of the nominal pressure (force per area).
    asperity_radius : array_like, optional
        Radius rho of the first asperity (length), see `asperity_radius`, times
        `ASPERITY_FACTOR_REPULSIVE` for the repulsive wall; by default no first asperity
        is considered.
    asperity_area : array_like
        Area A_adh >= 0 of an adhesive first asperity at small load (area).

    Returns
    -------
    ndarray
        Contact area A (area).

    Notes
    -----
    A single asperity carries the load as long as its pressure N/A_Hertz(rho) is below
    p_rough. More asperities share the load beyond the load at which both are equal,
    which is `crossover_load` with rho in place of R as long as f is linear. The
    transition has a kink, unlike the transition of a simulated sphere. With adhesion,
    A_adh is fitted to a realisation.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eqs. (2), (4) and
    (6), and fig. 2.

    Examples
    --------
    >>> from ase_roughcontact.theory import mean_contact_pressure, predicted_area
    >>> pressure = mean_contact_pressure(0.1, 1.0, kappa=2.0)
    >>> round(float(predicted_area(10.0, 1000.0, 1.0, pressure)))
    199
    """
    a = Hertz(radius, contact_modulus).contact_radius(normal_force)
    # N/A_Hertz in a form that holds at N = 0
    pressure = 4 / (3 * np.pi) * (contact_modulus / radius) * a
    fraction = flat(pressure) if callable(flat) else contact_fraction(pressure, flat)
    if asperity_radius is not None:
        plateau = low_load_plateau(asperity_radius, radius)
        fraction = np.maximum(fraction, np.minimum(plateau, 1.0))
    adhesive = nonnegative_array("asperity_area", asperity_area)
    return np.maximum(np.pi * a**2 * fraction, adhesive)


def crossover_load(
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    rms_slope: ArrayLike,
    kappa: ArrayLike = KAPPA_HARD,
) -> FloatArray:
    """Return the load of the crossover from rough to Hertzian contact.

    N_c = (9 pi^3/16) E* R^2 (h'/kappa)^3.

    Parameters
    ----------
    radius : array_like
        Radius R of the sphere (length).
    contact_modulus : array_like
        Contact modulus E* (force per area).
    rms_slope : array_like
        Rms slope h' (dimensionless).
    kappa : array_like
        Constant kappa (dimensionless).

    Returns
    -------
    ndarray
        Crossover load N_c (force).

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eq. (5).
    """
    radius = positive_array("radius", radius)
    modulus = positive_array("contact_modulus", contact_modulus)
    slope = positive_array("rms_slope", rms_slope)
    # contact radius over R at this load
    ratio = 0.75 * np.pi * slope / positive_array("kappa", kappa)
    return 4 / 3 * modulus * radius**2 * ratio**3
