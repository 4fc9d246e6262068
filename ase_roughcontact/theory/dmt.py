"""Derjaguin, Muller and Toporov: a smooth adhesive sphere, small and stiff.

The attraction acts around the contact and leaves its Hertzian profile unchanged. The
contact modulus is E* = E/(1 - nu^2). All functions broadcast over arrays and accept any
consistent system of units. Contacts are stable at every force above pull-off.
"""

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import (
    FloatArray,
    nonnegative_array,
    positive_array,
)
from ase_roughcontact.theory.branches import above_pull_off
from ase_roughcontact.theory.hertz import hertz_contact_radius


def dmt_pull_off_force(radius: ArrayLike, work_of_adhesion: ArrayLike) -> FloatArray:
    """Return the pull-off force, -2 pi w R.

    Parameters
    ----------
    radius : array_like
        R of the sphere, length.
    work_of_adhesion : array_like
        w, energy per area.

    Returns
    -------
    ndarray
        Force, negative; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite and positive.

    References
    ----------
    B. V. Derjaguin, V. M. Muller, Yu. P. Toporov, J. Colloid Interface Sci. 53, 314
    (1975).
    """
    work = positive_array("work_of_adhesion", work_of_adhesion)
    return -2 * np.pi * work * positive_array("radius", radius)


def dmt_contact_radius(
    normal_force: ArrayLike,
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    work_of_adhesion: ArrayLike,
) -> FloatArray:
    """Return the contact radius for a given force, a^3 = (3R/4E*)(N + 2 pi w R).

    Parameters
    ----------
    normal_force : array_like
        N, force, at least the pull-off force.
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    work_of_adhesion : array_like
        w, energy per area.

    Returns
    -------
    ndarray
        a, length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If a force is below the pull-off force, where there is no contact, or another
        argument is not finite and positive.

    References
    ----------
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992), on the DMT limit.
    """
    pull_off = dmt_pull_off_force(radius, work_of_adhesion)
    excess = above_pull_off(normal_force, pull_off)
    return hertz_contact_radius(excess, radius, contact_modulus)


def dmt_force(
    contact_radius: ArrayLike,
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    work_of_adhesion: ArrayLike,
) -> FloatArray:
    """Return the force for a given radius, N = 4 E* a^3/3R - 2 pi w R.

    Parameters
    ----------
    contact_radius : array_like
        a >= 0, length.
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    work_of_adhesion : array_like
        w, energy per area.

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
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992), on the DMT limit.
    """
    cube = nonnegative_array("contact_radius", contact_radius) ** 3
    modulus = positive_array("contact_modulus", contact_modulus)
    repulsive = 4 * modulus * cube / (3 * positive_array("radius", radius))
    return repulsive + dmt_pull_off_force(radius, work_of_adhesion)


def dmt_penetration(contact_radius: ArrayLike, radius: ArrayLike) -> FloatArray:
    """Return the penetration for a given radius, delta = a^2/R as for Hertz.

    Parameters
    ----------
    contact_radius : array_like
        a >= 0, length.
    radius : array_like
        R of the sphere, length.

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
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992), on the DMT limit.
    """
    a = nonnegative_array("contact_radius", contact_radius)
    return a**2 / positive_array("radius", radius)
