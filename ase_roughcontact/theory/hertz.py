"""Hertz: a smooth rigid sphere on an elastic half space, without adhesion.

The contact modulus is E* = E/(1 - nu^2). All functions broadcast over arrays and accept
any consistent system of units.
"""

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import (
    FloatArray,
    nonnegative_array,
    positive_array,
)


def hertz_contact_radius(
    normal_force: ArrayLike, radius: ArrayLike, contact_modulus: ArrayLike
) -> FloatArray:
    """Return the contact radius for a given force, a = (3 N R/4E*)^(1/3).

    Parameters
    ----------
    normal_force : array_like
        N >= 0, force.
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.

    Returns
    -------
    ndarray
        a, length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or of the wrong sign.

    References
    ----------
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), eq. (4.22).
    """
    force = nonnegative_array("normal_force", normal_force)
    modulus = positive_array("contact_modulus", contact_modulus)
    return np.cbrt(0.75 * force * positive_array("radius", radius) / modulus)


def hertz_contact_radius_from_penetration(
    penetration: ArrayLike, radius: ArrayLike
) -> FloatArray:
    """Return the contact radius for a given penetration, a = sqrt(R delta).

    Parameters
    ----------
    penetration : array_like
        delta >= 0, length.
    radius : array_like
        R of the sphere, length.

    Returns
    -------
    ndarray
        a, length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or of the wrong sign.

    References
    ----------
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), eq. (4.23).
    """
    penetration = nonnegative_array("penetration", penetration)
    return np.sqrt(positive_array("radius", radius) * penetration)


def hertz_force(
    penetration: ArrayLike, radius: ArrayLike, contact_modulus: ArrayLike
) -> FloatArray:
    """Return the force for a given penetration, N = (4/3) E* sqrt(R) delta^(3/2).

    Parameters
    ----------
    penetration : array_like
        delta >= 0, length.
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.

    Returns
    -------
    ndarray
        N, force; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or of the wrong sign.

    References
    ----------
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), eq. (4.23).
    """
    penetration = nonnegative_array("penetration", penetration)
    modulus = positive_array("contact_modulus", contact_modulus)
    root = np.sqrt(positive_array("radius", radius))
    return 4 / 3 * modulus * root * penetration**1.5


def hertz_penetration(
    normal_force: ArrayLike, radius: ArrayLike, contact_modulus: ArrayLike
) -> FloatArray:
    """Return the penetration for a given force, delta = a^2/R.

    Parameters
    ----------
    normal_force : array_like
        N >= 0, force.
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.

    Returns
    -------
    ndarray
        delta, length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or of the wrong sign.

    References
    ----------
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), eq. (4.23).
    """
    a = hertz_contact_radius(normal_force, radius, contact_modulus)
    return a**2 / np.asarray(radius, dtype=float)


def hertz_contact_area(
    normal_force: ArrayLike, radius: ArrayLike, contact_modulus: ArrayLike
) -> FloatArray:
    """Return the contact area for a given force, A = pi a^2.

    Parameters
    ----------
    normal_force : array_like
        N >= 0, force.
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.

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
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), eq. (4.22).
    """
    return np.pi * hertz_contact_radius(normal_force, radius, contact_modulus) ** 2


def hertz_pressure(
    distance: ArrayLike,
    contact_radius: ArrayLike,
    radius: ArrayLike,
    contact_modulus: ArrayLike,
) -> FloatArray:
    """Return the pressure in the contact, p(r) = (2 E* a/pi R) sqrt(1 - r^2/a^2).

    Parameters
    ----------
    distance : array_like
        r >= 0 from the axis of the sphere, length.
    contact_radius : array_like
        a, length.
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.

    Returns
    -------
    ndarray
        p, force per area, zero beyond a; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or of the wrong sign.

    References
    ----------
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), section 4.2.
    """
    distance = nonnegative_array("distance", distance)
    contact_radius = positive_array("contact_radius", contact_radius)
    modulus = positive_array("contact_modulus", contact_modulus)
    chord = np.sqrt(np.maximum(contact_radius**2 - distance**2, 0.0))
    return 2 * modulus / (np.pi * positive_array("radius", radius)) * chord
