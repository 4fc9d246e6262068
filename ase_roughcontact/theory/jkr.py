"""Johnson, Kendall and Roberts: a smooth adhesive sphere, large and soft.

The attraction has no range: it acts inside the contact only. The contact modulus is
E* = E/(1 - nu^2). All functions broadcast over arrays and accept any consistent system
of units.
"""

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import (
    FloatArray,
    finite_array,
    nonnegative_array,
    positive_array,
)
from ase_roughcontact.theory.branches import (
    Branch,
    above_pull_off,
    check_unstable,
    is_stable,
)
from ase_roughcontact.theory.hertz import hertz_contact_radius


def jkr_pull_off_force(radius: ArrayLike, work_of_adhesion: ArrayLike) -> FloatArray:
    """Return the pull-off force, -(3/2) pi w R.

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
    branch: Branch = "stable",
) -> FloatArray:
    """Return the contact radius for a given force.

    a^3 = (3R/4E*) [N + 3 pi w R +- sqrt(6 pi w R N + (3 pi w R)^2)].

    Parameters
    ----------
    normal_force : array_like
        N, force, at least the pull-off force, and at most zero on the unstable branch.
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    work_of_adhesion : array_like
        w, energy per area.
    branch : {"stable", "unstable"}
        Branch at the given force: plus or minus sign.

    Returns
    -------
    ndarray
        a, length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If a force is below the pull-off force, where there is no contact, or beyond the
        end of the unstable branch, or another argument is not finite and positive.

    References
    ----------
    K. L. Johnson, K. Kendall, A. D. Roberts, Proc. R. Soc. Lond. A 324, 301 (1971).
    """
    pull_off = jkr_pull_off_force(radius, work_of_adhesion)
    # The bracket is the square of sqrt(N + P) +- sqrt(P), with P = 1.5 pi w R; the
    # minus sign is evaluated as a quotient to avoid cancellation.
    above = np.sqrt(above_pull_off(normal_force, pull_off))
    root = above + np.sqrt(-pull_off)
    if not is_stable(branch):
        force = finite_array("normal_force", normal_force)
        check_unstable("normal_force", force, 0.0)
        root = -np.minimum(force, 0.0) / root
    return hertz_contact_radius(root**2, radius, contact_modulus)


def jkr_zero_load_area(
    radius: ArrayLike, contact_modulus: ArrayLike, work_of_adhesion: ArrayLike
) -> FloatArray:
    """Return the contact area at zero force, pi (9 pi w R^2/2E*)^(2/3).

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
    """Return the force for a given radius, N = 4 E* a^3/3R - sqrt(8 pi w E* a^3).

    Contacts with a^3 < 9 pi w R^2/8E* are on the unstable branch at a given force.

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
    """Return the penetration for a given radius, delta = a^2/R - sqrt(2 pi w a/E*).

    Contacts with a^3 < pi w R^2/8E* are on the unstable branch at a given penetration.

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


def jkr_pull_off_penetration(
    radius: ArrayLike, contact_modulus: ArrayLike, work_of_adhesion: ArrayLike
) -> FloatArray:
    """Return the penetration at pull-off, -(3/4) (pi^2 w^2 R/E*^2)^(1/3).

    It is the smallest penetration of a contact, with a^3 = pi w R^2/8E*, at which the
    contact is lost under displacement control.

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
        delta, length, negative; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite and positive.

    References
    ----------
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), section 5.5.
    """
    work = positive_array("work_of_adhesion", work_of_adhesion)
    length = np.pi * work / positive_array("contact_modulus", contact_modulus)
    return -0.75 * np.cbrt(length**2 * positive_array("radius", radius))


def jkr_contact_radius_from_penetration(
    penetration: ArrayLike,
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    work_of_adhesion: ArrayLike,
    branch: Branch = "stable",
) -> FloatArray:
    """Return the contact radius for a given penetration.

    Parameters
    ----------
    penetration : array_like
        delta, length, at least `jkr_pull_off_penetration`, and at most zero on the
        unstable branch.
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    work_of_adhesion : array_like
        w, energy per area.
    branch : {"stable", "unstable"}
        Branch at the given penetration: the larger or the smaller radius.

    Returns
    -------
    ndarray
        a, length; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If there is no contact on the branch at a penetration, or another argument is
        not finite and positive.

    Notes
    -----
    With the radius a1 at the smallest penetration, -3 a1^2/R, `jkr_penetration` is the
    quartic x^4 - 4 x = d of x = sqrt(a/a1), with d = delta R/a1^2. Its resolvent
    m^3 + d m = 2 (Ferrari) has one positive root for d >= -3, and
    x = sqrt(m/2) +- sqrt(sqrt(2/m) - m/2).

    References
    ----------
    K. L. Johnson, Contact Mechanics (Cambridge University Press, 1985), section 5.5,
    inverted here.
    """
    least = jkr_pull_off_penetration(radius, contact_modulus, work_of_adhesion)
    depth = finite_array("penetration", penetration)
    d = -3 * depth / least
    if not np.all(d >= -3 * (1 + 1e-12)):
        raise ValueError(
            f"penetration must not be below that of pull-off, {least}, "
            f"got {penetration!r}"
        )
    d = np.maximum(d, -3.0)
    u = np.cbrt(1 + np.sqrt(1 + (d / 3) ** 3)) ** 2
    m = 2 / (u + d / 3 + (d / 3) ** 2 / u)
    half = np.sqrt(np.maximum(np.sqrt(2 / m) - m / 2, 0.0))
    if is_stable(branch):
        x = np.sqrt(m / 2) + half
    else:
        check_unstable("penetration", depth, 0.0)
        x = np.sqrt(m / 2) - half
        x = -d / (4 - x**3)  # one fixed-point step removes the cancellation above
    a1 = np.sqrt(-least / 3 * np.asarray(radius, dtype=float))
    return a1 * x**2
