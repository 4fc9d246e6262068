"""JKR and DMT: a smooth rigid sphere that adheres to an elastic half space.

The contact modulus is E* = E/(1 - nu^2). All functions broadcast over arrays and take
any consistent system of units. `maugis` holds what lies between the two limits.
"""

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact.checks import (
    FloatArray,
    finite_array,
    nonnegative_array,
    positive_array,
)
from ase_roughcontact.theory.hertz import hertz_contact_radius


def jkr_pull_off_force(radius: ArrayLike, work_of_adhesion: ArrayLike) -> FloatArray:
    """Least force of the JKR contact, -(3/2) pi w R.

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
    K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. Lond. A 324, 301 (1971).
    """
    work = positive_array("work_of_adhesion", work_of_adhesion)
    return -1.5 * np.pi * work * positive_array("radius", radius)


def jkr_contact_radius(
    normal_force: ArrayLike,
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    work_of_adhesion: ArrayLike,
) -> FloatArray:
    """Radius of the JKR contact that is stable under a given force.

    a^3 = (3R/4E*) [N + 3 pi w R + sqrt(6 pi w R N + (3 pi w R)^2)].

    Parameters
    ----------
    normal_force : array_like
        N, force, not below pull-off.
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
        If a force lies below pull-off, where no contact exists, or another argument
        is not finite and positive.

    References
    ----------
    K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. Lond. A 324, 301 (1971).
    """
    pull_off = jkr_pull_off_force(radius, work_of_adhesion)
    excess = above_pull_off(normal_force, pull_off)
    adhesive = excess - pull_off + np.sqrt(-4 * pull_off * excess)
    return hertz_contact_radius(adhesive, radius, contact_modulus)


def jkr_zero_load_area(
    radius: ArrayLike, contact_modulus: ArrayLike, work_of_adhesion: ArrayLike
) -> FloatArray:
    """Area of the JKR contact at zero force, pi (9 pi w R^2/2E*)^(2/3).

    Parameters
    ----------
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    work_of_adhesion : array_like
        w, energy per area.

    Returns
    -------
    ndarray
        Area; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite and positive.

    References
    ----------
    K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. Lond. A 324, 301 (1971).
    """
    a0 = jkr_contact_radius(0.0, radius, contact_modulus, work_of_adhesion)
    return np.pi * a0**2


def jkr_force(
    contact_radius: ArrayLike,
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    work_of_adhesion: ArrayLike,
) -> FloatArray:
    """Force of the JKR contact, N = 4 E* a^3/3R - sqrt(8 pi w E* a^3).

    Both branches: below a^3 = 9 pi w R^2/8E* a contact is unstable at a given force.

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
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), section 5.5.
    """
    cube = nonnegative_array("contact_radius", contact_radius) ** 3
    modulus = positive_array("contact_modulus", contact_modulus)
    work = positive_array("work_of_adhesion", work_of_adhesion)
    repulsive = 4 * modulus * cube / (3 * positive_array("radius", radius))
    return repulsive - np.sqrt(8 * np.pi * work * modulus * cube)


def jkr_penetration(
    contact_radius: ArrayLike,
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    work_of_adhesion: ArrayLike,
) -> FloatArray:
    """Penetration of the JKR contact, delta = a^2/R - sqrt(2 pi w a/E*).

    Both branches: below a^3 = pi w R^2/8E* a contact is unstable at a given height.

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
        delta, length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite or of the wrong sign.

    References
    ----------
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), section 5.5.
    """
    a = nonnegative_array("contact_radius", contact_radius)
    work = positive_array("work_of_adhesion", work_of_adhesion)
    modulus = positive_array("contact_modulus", contact_modulus)
    adhesive = np.sqrt(2 * np.pi * work * a / modulus)
    return a**2 / positive_array("radius", radius) - adhesive


def dmt_pull_off_force(radius: ArrayLike, work_of_adhesion: ArrayLike) -> FloatArray:
    """Least force of the DMT contact, -2 pi w R.

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
    """Radius of the DMT contact, a^3 = (3R/4E*)(N + 2 pi w R); delta = a^2/R.

    Parameters
    ----------
    normal_force : array_like
        N, force, not below pull-off.
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
        If a force lies below pull-off, where no contact exists, or another argument
        is not finite and positive.

    References
    ----------
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992), on the limit of DMT.
    """
    pull_off = dmt_pull_off_force(radius, work_of_adhesion)
    excess = above_pull_off(normal_force, pull_off)
    return hertz_contact_radius(excess, radius, contact_modulus)


def above_pull_off(normal_force: ArrayLike, pull_off: FloatArray) -> FloatArray:
    """Force in excess of pull-off; rounding at pull-off itself counts as zero.

    Parameters
    ----------
    normal_force : array_like
        N, force.
    pull_off : ndarray
        Least force, negative.

    Returns
    -------
    ndarray
        N - pull_off >= 0, force.

    Raises
    ------
    ValueError
        If a force is not finite or below pull-off.
    """
    excess = finite_array("normal_force", normal_force) - pull_off
    if not np.all(excess >= 1e-12 * pull_off):
        raise ValueError(
            f"normal_force must not lie below the pull-off force {pull_off!r}, "
            f"got {normal_force!r}"
        )
    return np.maximum(excess, 0.0)
