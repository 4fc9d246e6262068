"""First contact of a rough sphere: where it is, and how sharp the asperity is.

The rms slope is h' = ``<|grad h|^2>^(1/2)``, the rms curvature
h'' = ``<(lap h)^2>^(1/2)``. All functions broadcast over arrays, accept any consistent
system of units, and raise `ValueError` for an argument that is not finite or out of
range. Equations are those of L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601
(2016).
"""

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import FloatArray, positive_array
from ase_roughcontact.theory.self_affine import Roughness, numbers_of

#: Factor by which the compliance of the repulsive 9-3 wall increases rho, for the
#: stiffness of the bulk and lambda_s = 4 a0: L. Pastewka, M. O. Robbins, Appl. Phys.
#: Lett. 108, 221601 (2016).
ASPERITY_FACTOR_REPULSIVE = 3.0


def first_contact_radius(radius: ArrayLike, roughness: Roughness) -> FloatArray:
    """Return the radius around the axis within which the first contact is expected.

    This is eq. (3) as printed, a'/lambda_s =
    {2 R h'/lambda_s [(1-H)/H]^(1/2)}^(1/(2-H)), for a' < lambda_L.

    Parameters
    ----------
    radius : array_like
        R of the sphere, length.
    roughness : Roughness
        Roughness of the sphere, such as `ase_roughcontact.SelfAffine`.

    Returns
    -------
    ndarray
        a', length.

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
        a', length.
    """
    printed = first_contact_radius(radius, roughness)
    return printed / (2 * np.pi) ** (1 / (2 - roughness.hurst))


def asperity_radius(roughness: Roughness) -> float:
    """Return the radius of the first asperity in contact.

    This is eq. (6), right, as printed: rho = lambda_s/(2 pi h') [2(2-H)/(1-H)]^(1/2).

    Parameters
    ----------
    roughness : Roughness
        Such as `ase_roughcontact.SelfAffine`.

    Returns
    -------
    float
        rho, length.

    Notes
    -----
    The paper equates it with 2/h'', which is larger by sqrt(2) for lambda_L >>
    lambda_s: `asperity_radius_from_curvature`.
    """
    slope, hurst, short = numbers_of(roughness)
    return float(short / (2 * np.pi * slope) * np.sqrt(2 * (2 - hurst) / (1 - hurst)))


def asperity_radius_from_curvature(rms_curvature: ArrayLike) -> FloatArray:
    """Return the radius of the first asperity from the rms curvature, rho = 2/h''.

    This is eq. (6), left.

    Parameters
    ----------
    rms_curvature : array_like
        h'', inverse length, such as that of a measured surface.

    Returns
    -------
    ndarray
        rho, length.
    """
    return 2 / positive_array("rms_curvature", rms_curvature)


def low_load_plateau(asperity_radius: ArrayLike, radius: ArrayLike) -> FloatArray:
    """Return A/A_Hertz while one asperity carries the load, (rho/R)^(2/3).

    Parameters
    ----------
    asperity_radius : array_like
        rho, length.
    radius : array_like
        R of the sphere, length.

    Returns
    -------
    ndarray
        A/A_Hertz, dimensionless.
    """
    rho = positive_array("asperity_radius", asperity_radius)
    return np.cbrt(rho / positive_array("radius", radius)) ** 2
