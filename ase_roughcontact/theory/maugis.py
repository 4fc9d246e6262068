"""Maugis-Dugdale: adhesion of a smooth sphere between the limits of DMT and JKR.

Around the contact of radius a, a constant tension sigma0 acts up to the radius c, where
the gap reaches w/sigma0. Any consistent system of units.
"""

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from ase_roughcontact._util.validation import FloatArray, positive, positive_array
from ase_roughcontact.theory.branches import (
    Branch,
    above_pull_off,
    is_stable,
    refuse_beyond,
)
from ase_roughcontact.theory.hertz import hertz_contact_radius
from ase_roughcontact.theory.parameters import maugis_parameter


def maugis_dugdale(
    zone_ratio: ArrayLike, maugis_parameter: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Reduced contact radius, force and penetration of the Maugis-Dugdale model.

    With s = sqrt(m^2 - 1), the first equation giving a: ::

        1 = (lambda a^2/2) [s + (m^2 - 2) arctan s]
            + (4 lambda^2 a/3) [s arctan s - m + 1]
        N = a^3 - lambda a^2 [s + m^2 arctan s]
        delta = a^2 - (4/3) lambda a s

    Parameters
    ----------
    zone_ratio : array_like
        m = c/a > 1: from m -> 1 at large force to m = inf where the contact is a point.
    maugis_parameter : array_like
        lambda > 0, dimensionless.

    Returns
    -------
    contact_radius, normal_force, penetration : ndarray
        In units of b = (3 pi w R^2/4E*)^(1/3), pi w R and b^2/R; shape as the
        arguments broadcast.

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
    """Largest zone ratio m = c/a at which a Maugis-Dugdale contact is stable.

    There the force, or the penetration, is least on the curve.

    Parameters
    ----------
    maugis_parameter : float
        lambda > 0, dimensionless.
    control : {"load", "displacement"}
        Whether the force or the penetration is held.

    Returns
    -------
    float
        m, dimensionless; inf if the contact shrinks to a point without a jump.

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
    """Least force N/(pi w R): -2 for small lambda (DMT), -3/2 for large (JKR).

    Parameters
    ----------
    maugis_parameter : float
        lambda > 0, dimensionless.

    Returns
    -------
    float
        Force in units of pi w R.

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
    """Radius of the Maugis-Dugdale contact under a given force.

    Inverts N(m) of `maugis_dugdale` numerically.

    Parameters
    ----------
    normal_force : array_like
        N, force, any shape, not below pull-off.
    radius : float
        R of the sphere, length.
    contact_modulus : float
        E*, force per area.
    work_of_adhesion : float
        w, energy per area.
    cohesive_stress : float
        sigma0, force per area.
    branch : {"stable", "unstable"}
        Under the given force. The unstable branch ends where its contact is a point.

    Returns
    -------
    ndarray, shape of `normal_force`
        a, without the cohesive zone, length.

    Raises
    ------
    ValueError
        If a force lies below pull-off, where no contact exists, or beyond the unstable
        branch, or another argument is not finite and positive.

    References
    ----------
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992).
    """
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
        refuse_beyond("normal_force", force, float(end * unit_force))

    def reduced_radius(excess: float) -> float:
        def too_strong(angle: float) -> float:
            return float(_state(angle, parameter)[1] - pull_off) - excess

        if excess == 0:
            return float(_state(last, parameter)[0])
        other = last / 2 if stable else np.pi / 2
        while stable and too_strong(other) < 0:
            other /= 2
        # rounding may put the end of the unstable branch below a force given there
        if too_strong(other) <= 0:
            return float(_state(other, parameter)[0])
        angle = brentq(too_strong, *sorted((last, other)), xtol=1e-15)
        return float(_state(angle, parameter)[0])

    radii = np.array([reduced_radius(each) for each in np.asarray(excess).flat])
    unit_radius = hertz_contact_radius(unit_force, radius, contact_modulus)
    return radii.reshape(np.shape(excess)) * unit_radius


def _state(
    angle: ArrayLike, parameter: ArrayLike
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Reduced radius, force and penetration at the angle arctan s = arccos(a/c).

    The angle is regular where the contact shrinks to a point, m = inf.
    """
    t, lam = np.asarray(angle, dtype=float), np.asarray(parameter, dtype=float)
    # Gap w/sigma0 at the edge c of the cohesive zone: quadratic c^2 + linear c = 1.
    quadratic = lam / 2 * (np.sin(2 * t) / 2 - t * np.cos(2 * t))
    linear = 4 * lam**2 / 3 * (t * np.sin(t) - 2 * np.sin(t / 2) ** 2)
    c = 2 / (linear + np.sqrt(linear**2 + 4 * quadratic))
    a = c * np.cos(t)
    force = a**3 - lam * c**2 * (np.sin(2 * t) / 2 + t)
    return a, force, a**2 - 4 / 3 * lam * c * np.sin(t)


def _last_stable_angle(parameter: float, output: Literal[1, 2]) -> float:
    """Angle at which force (1) or penetration (2) is least on the curve."""

    def value(angle: float) -> float:
        return float(_state(angle, parameter)[output])

    # JKR's instabilities lie at angles near 1/lambda, DMT's at the end of the curve.
    angles = np.geomspace(0.1 / (1 + parameter), np.pi / 2, 200)
    least = int(np.argmin(_state(angles, parameter)[output]))
    if least == angles.size - 1 and value(angles[-1] * (1 - 1e-6)) > value(angles[-1]):
        return float(angles[-1])
    bounds = angles[least - 1], angles[min(least + 1, angles.size - 1)]
    options = {"xatol": 1e-12 * angles[least]}
    return float(minimize_scalar(value, bounds=bounds, options=options).x)
