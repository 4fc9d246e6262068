"""Maugis-Dugdale: a smooth adhesive sphere between the limits of DMT and JKR.

Around the contact of radius a, a constant tension sigma0 acts up to the radius c at
which the gap is w/sigma0. All functions accept any consistent system of units.
"""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from ase_roughcontact._util.validation import FloatArray, positive, positive_array
from ase_roughcontact.theory.branches import (
    Branch,
    above_pull_off,
    check_unstable,
    is_stable,
)
from ase_roughcontact.theory.hertz import hertz_contact_radius


def tabor_parameter(
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    work_of_adhesion: ArrayLike,
    equilibrium_distance: ArrayLike,
) -> FloatArray:
    """Return Tabor's parameter, mu = (R w^2/(E*^2 z0^3))^(1/3).

    It is small in the limit of DMT and large in that of JKR.

    Parameters
    ----------
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    work_of_adhesion : array_like
        w, energy per area.
    equilibrium_distance : array_like
        z0, gap of lowest energy, length.

    Returns
    -------
    ndarray
        mu, dimensionless; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite and positive.

    References
    ----------
    D. Tabor, J. Colloid Interface Sci. 58, 2 (1977).
    """
    work = positive_array("work_of_adhesion", work_of_adhesion)
    modulus = positive_array("contact_modulus", contact_modulus)
    distance = positive_array("equilibrium_distance", equilibrium_distance)
    return np.cbrt(positive_array("radius", radius) * (work / modulus) ** 2) / distance


def maugis_parameter(
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    work_of_adhesion: ArrayLike,
    cohesive_stress: ArrayLike,
) -> FloatArray:
    """Return Maugis' parameter, lambda = sigma0 (9 R/(2 pi w E*^2))^(1/3).

    Parameters
    ----------
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    work_of_adhesion : array_like
        w, energy per area.
    cohesive_stress : array_like
        sigma0, force per area.

    Returns
    -------
    ndarray
        lambda, dimensionless; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite and positive.

    References
    ----------
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992), who writes
    lambda = 2 sigma0 (R/(pi w K^2))^(1/3) with K = 4 E*/3.
    """
    stress = positive_array("cohesive_stress", cohesive_stress)
    work = positive_array("work_of_adhesion", work_of_adhesion)
    modulus = positive_array("contact_modulus", contact_modulus)
    radius = positive_array("radius", radius)
    return stress * np.cbrt(9 * radius / (2 * np.pi * work * modulus**2))


def maugis_dugdale(
    zone_ratio: ArrayLike, maugis_parameter: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return reduced contact radius, force and penetration.

    With s = sqrt(m^2 - 1), where the first equation determines a: ::

        1 = (lambda a^2/2) [s + (m^2 - 2) arctan s]
            + (4 lambda^2 a/3) [s arctan s - m + 1]
        N = a^3 - lambda a^2 [s + m^2 arctan s]
        delta = a^2 - (4/3) lambda a s

    Parameters
    ----------
    zone_ratio : array_like
        m = c/a > 1, which tends to 1 at large force, and is infinite if the contact is
        a point.
    maugis_parameter : array_like
        lambda > 0, dimensionless.

    Returns
    -------
    contact_radius, normal_force, penetration : ndarray
        a, N and delta in units of b = (3 pi w R^2/4E*)^(1/3), pi w R and b^2/R; shape
        as the arguments broadcast.

    Raises
    ------
    ValueError
        If m <= 1, or lambda is not finite and positive.

    References
    ----------
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992).
    """
    ratio = np.asarray(zone_ratio, dtype=float)
    if not np.all(ratio > 1):
        raise ValueError(f"zone_ratio must be above 1, got {zone_ratio!r}")
    angle = np.arctan(np.sqrt((ratio - 1) * (ratio + 1)))
    return _state(angle, positive_array("maugis_parameter", maugis_parameter))


def maugis_dugdale_stability_limit(
    maugis_parameter: float, control: Literal["load", "displacement"]
) -> float:
    """Return the largest zone ratio m = c/a of a stable contact.

    At this ratio the force, or the penetration, has its minimum.

    Parameters
    ----------
    maugis_parameter : float
        lambda > 0, dimensionless.
    control : {"load", "displacement"}
        Whether the force or the penetration is prescribed.

    Returns
    -------
    float
        m, dimensionless; infinity if the contact shrinks to a point without an
        instability.

    Raises
    ------
    ValueError
        If lambda is not finite and positive, or `control` is unknown.

    References
    ----------
    K. L. Johnson, J. A. Greenwood, J. Colloid Interface Sci. 192, 326 (1997).
    """
    positive(maugis_parameter=maugis_parameter)
    if control not in ("load", "displacement"):
        raise ValueError(f"control must be 'load' or 'displacement', got {control!r}")
    angle = _last_stable_angle(maugis_parameter, 1 if control == "load" else 2)
    return float("inf") if angle == np.pi / 2 else float(1 / np.cos(angle))


def maugis_dugdale_pull_off_force(maugis_parameter: float) -> float:
    """Return the pull-off force in units of pi w R.

    It is -2 for small lambda (DMT) and -3/2 for large lambda (JKR).

    Parameters
    ----------
    maugis_parameter : float
        lambda > 0, dimensionless.

    Returns
    -------
    float
        N/(pi w R), dimensionless.

    Raises
    ------
    ValueError
        If lambda is not finite and positive.

    References
    ----------
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992).
    """
    positive(maugis_parameter=maugis_parameter)
    angle = _last_stable_angle(maugis_parameter, 1)
    return float(_state(angle, maugis_parameter)[1])


def maugis_dugdale_contact_radius(
    normal_force: ArrayLike,
    radius: float,
    contact_modulus: float,
    work_of_adhesion: float,
    cohesive_stress: float,
    branch: Branch = "stable",
) -> FloatArray:
    """Return the contact radius for a given force.

    N(m) of `maugis_dugdale` is inverted numerically.

    Parameters
    ----------
    normal_force : array_like
        N, force, at least the pull-off force.
    radius : float
        R of the sphere, length.
    contact_modulus : float
        E*, force per area.
    work_of_adhesion : float
        w, energy per area.
    cohesive_stress : float
        sigma0, force per area.
    branch : {"stable", "unstable"}
        Branch at the given force. The unstable one ends where the contact is a point.

    Returns
    -------
    ndarray, shape of `normal_force`
        a, which does not include the cohesive zone, length.

    Raises
    ------
    ValueError
        If a force is below the pull-off force, where there is no contact, or beyond the
        end of the unstable branch, or another argument is not finite and positive.

    References
    ----------
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992).
    """
    positive(
        radius=radius,
        contact_modulus=contact_modulus,
        work_of_adhesion=work_of_adhesion,
        cohesive_stress=cohesive_stress,
    )
    parameter = float(
        maugis_parameter(radius, contact_modulus, work_of_adhesion, cohesive_stress)
    )
    unit_force = np.pi * work_of_adhesion * radius
    last = _last_stable_angle(parameter, 1)
    pull_off = _state(last, parameter)[1]
    excess = above_pull_off(normal_force, pull_off * unit_force) / unit_force
    stable = is_stable(branch)
    if not stable:
        end = _state(np.pi / 2, parameter)[1]
        force = np.asarray(normal_force, dtype=float)
        check_unstable("normal_force", force, float(end * unit_force))

    def reduced_radius(excess: float) -> float:
        def difference(angle: float) -> float:
            return float(_state(angle, parameter)[1] - pull_off) - excess

        if excess == 0:
            return float(_state(last, parameter)[0])
        end = last / 2 if stable else np.pi / 2
        while stable and difference(end) < 0:  # the force is not bounded as end -> 0
            end /= 2
        if difference(end) <= 0:  # a force at the end of the unstable branch, rounded
            return float(_state(end, parameter)[0])
        angle = brentq(difference, *sorted((last, end)), xtol=1e-15)
        return float(_state(angle, parameter)[0])

    radii = np.array([reduced_radius(each) for each in np.asarray(excess).flat])
    unit_radius = hertz_contact_radius(unit_force, radius, contact_modulus)
    return radii.reshape(np.shape(excess)) * unit_radius


def _state(
    angle: ArrayLike, parameter: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return reduced radius, force and penetration at the angle arctan s = arccos(a/c).

    The angle is finite, pi/2, where the contact is a point, m = inf.
    """
    t, lam = np.asarray(angle, dtype=float), np.asarray(parameter, dtype=float)
    # The gap at c is w/sigma0: quadratic c^2 + linear c = 1.
    quadratic = lam / 2 * (np.sin(2 * t) / 2 - t * np.cos(2 * t))
    linear = 4 * lam**2 / 3 * (t * np.sin(t) - 2 * np.sin(t / 2) ** 2)
    c = 2 / (linear + np.sqrt(linear**2 + 4 * quadratic))
    a = c * np.cos(t)
    force = a**3 - lam * c**2 * (np.sin(2 * t) / 2 + t)
    return a, force, a**2 - 4 / 3 * lam * c * np.sin(t)


def _last_stable_angle(parameter: float, output: Literal[1, 2]) -> float:
    """Return the angle at which force (output 1) or penetration (2) has its minimum."""

    def value(angle: float) -> float:
        return float(_state(angle, parameter)[output])

    # The minimum is at an angle of about 1/lambda (JKR) or at the end pi/2 (DMT).
    angles = np.geomspace(0.1 / (1 + parameter), np.pi / 2, 200)
    least = int(np.argmin(_state(angles, parameter)[output]))
    if least == angles.size - 1 and value(angles[-1] * (1 - 1e-6)) > value(angles[-1]):
        return float(angles[-1])
    bounds = angles[least - 1], angles[min(least + 1, angles.size - 1)]
    options = {"xatol": 1e-12 * angles[least]}
    return float(minimize_scalar(value, bounds=bounds, options=options).x)
