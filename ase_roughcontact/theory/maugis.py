"""Theory of Maugis and Dugdale, and the choice between theories of smooth spheres."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from ase_roughcontact._util.validation import (
    FloatArray,
    finite_array,
    nonnegative,
    nonnegative_array,
    one_of,
    unmasked,
)
from ase_roughcontact.theory.jkr import JKR
from ase_roughcontact.theory.smooth_sphere import CURVE_POINTS, DMT, Hertz, SphereTheory

# Smallest value of c/a - 1 along a curve, at large forces.
_MIN_ZONE = 1e-8
# Largest value of c/a - 1 along a curve, for a contact that is almost a point.
_MAX_ZONE = 1e4


def edge_zone(
    contact_modulus: float, work_of_adhesion: float, attraction_range: float
) -> float:
    """Return the width of Dugdale's zone at the edge of a large contact.

    The width is pi E* D^2/(4 w) (length). See `MaugisDugdale` for the parameters.
    """
    width = contact_modulus * attraction_range**2 / work_of_adhesion
    return 0.25 * np.pi * width


# Positions of the outputs of `MaugisDugdale._reduced`.
_RADIUS, _FORCE, _DEPTH = 0, 1, 2


@dataclass(frozen=True)
class MaugisDugdale(SphereTheory):
    """Maugis and Dugdale: a tension of finite range; see `SphereTheory`.

    Around the contact of radius a, a constant tension w/D acts up to the radius c at
    which the gap is D. Radius, force and penetration follow from c/a, see `state`.

    Parameters
    ----------
    radius : float
        Radius R of the sphere (length).
    contact_modulus : float
        Contact modulus E* (force per area).
    work_of_adhesion : float
        Work of adhesion w (energy per area).
    attraction_range : float
        Range D of the attraction (length).

    References
    ----------
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992).

    Examples
    --------
    >>> from ase_roughcontact.theory import MaugisDugdale
    >>> theory = MaugisDugdale(200.0, 1.0, work_of_adhesion=0.05, attraction_range=0.8)
    >>> round(float(theory.pull_off_force / (3.14159 * 0.05 * 200.0)), 2)
    1.59
    """

    radius: float
    contact_modulus: float
    work_of_adhesion: float
    attraction_range: float
    name = "Maugis-Dugdale"
    symbol = "MD"

    @cached_property
    def parameter(self) -> float:
        """Maugis' parameter, lambda = (w/D) (9 R/(2 pi w E*^2))^(1/3).

        It is small in the limit of DMT and large in the limit of JKR.
        """
        tension = self.work_of_adhesion / self.attraction_range
        scale = 2 * np.pi * self.work_of_adhesion * self.contact_modulus**2
        return float(tension * np.cbrt(9 * self.radius / scale))

    @property
    def tabor_parameter(self) -> float:
        """Tabor's parameter for an equilibrium distance D, (R w^2/(E*^2 D^3))^(1/3).

        References
        ----------
        D. Tabor, J. Colloid Interface Sci. 58, 2 (1977).
        """
        strain = self.work_of_adhesion / self.contact_modulus
        return float(np.cbrt(self.radius * strain**2) / self.attraction_range)

    @property
    def pull_off_force(self) -> float:
        """Largest tension of a contact, from 2 pi w R (DMT) to (3/2) pi w R (JKR)."""
        return self._pull_off * self._unit_force

    @property
    def pull_off_penetration(self) -> float:
        """Smallest penetration of a contact that is stable at a given height."""
        angle = self._last_stable_angle(_DEPTH)
        return self._unit_depth * float(self._reduced(angle)[_DEPTH])

    def state(self, zone_ratio: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return contact radius, force and penetration for a ratio m = c/a.

        In units of b = (3 pi w R^2/4E*)^(1/3), pi w R and b^2/R, with
        s = sqrt(m^2 - 1), the first equation determines a: ::

            1 = (lambda a^2/2) [s + (m^2 - 2) arctan s]
                + (4 lambda^2 a/3) [s arctan s - m + 1]
            N = a^3 - lambda a^2 [s + m^2 arctan s]
            delta = a^2 - (4/3) lambda a s

        Parameters
        ----------
        zone_ratio : array_like
            Ratio m > 1 (dimensionless). It tends to 1 at large force, and is infinite
            if the contact is a point.

        Returns
        -------
        contact_radius, normal_force, penetration : ndarray
            Contact radius a (length), normal force N (force) and penetration delta
            (length).

        Raises
        ------
        ValueError
            If a ratio is not above 1.
        """
        ratio = unmasked(zone_ratio).astype(float)
        if not np.all(ratio > 1):
            raise ValueError(f"zone_ratio must be above 1, got {zone_ratio!r}")
        a, force, depth = self._reduced(np.arctan(np.sqrt((ratio - 1) * (ratio + 1))))
        b = self._unit_radius
        return b * a, self._unit_force * force, self._unit_depth * depth

    def stability_limit(self, control: Literal["load", "displacement"]) -> float:
        """Return the largest zone ratio m = c/a of a stable contact.

        At this ratio the force, or the penetration, has its minimum.

        Parameters
        ----------
        control : {"load", "displacement"}
            Whether the force or the penetration is prescribed.

        Returns
        -------
        float
            Ratio m (dimensionless); infinity if the contact shrinks to a point without
            an instability.

        References
        ----------
        K. L. Johnson, J. A. Greenwood, J. Colloid Interface Sci. 192, 326 (1997).
        """
        one_of(("load", "displacement"), control=control)
        angle = self._last_stable_angle(_FORCE if control == "load" else _DEPTH)
        return float("inf") if angle == np.pi / 2 else float(1 / np.cos(angle))

    def contact_radius(self, normal_force: ArrayLike) -> FloatArray:
        """Return the radius of the stable contact; see `SphereTheory.contact_radius`.

        The radius does not include Dugdale's zone. It is found by inverting the force
        N(m) of `state` numerically.
        """
        excess = self._above_pull_off(normal_force) / self._unit_force
        angle = self._angles(excess - self._pull_off, _FORCE)
        return self._unit_radius * self._reduced(angle)[_RADIUS]

    def contact_radius_from_penetration(self, penetration: ArrayLike) -> FloatArray:
        """Return the radius of the contact that is stable at a given height.

        The penetration of `state` is inverted numerically; see `SphereTheory`.
        """
        depth = finite_array("penetration", penetration) / self._unit_depth
        least = self.pull_off_penetration / self._unit_depth
        if not np.all(depth >= least - 1e-12 * abs(least)):
            raise ValueError(
                f"penetration must be at least {self.pull_off_penetration}, where the "
                f"contact is lost, got {penetration!r}"
            )
        angle = self._angles(depth, _DEPTH)
        return self._unit_radius * self._reduced(angle)[_RADIUS]

    def force(self, contact_radius: ArrayLike) -> FloatArray:
        """Return the force for a given contact radius; see `SphereTheory.force`.

        The radius of `state` is inverted numerically.
        """
        radius = nonnegative_array("contact_radius", contact_radius)
        angle = self._angles(radius / self._unit_radius, _RADIUS)
        return self._unit_force * self._reduced(angle)[_FORCE]

    def penetration(self, contact_radius: ArrayLike) -> FloatArray:
        """Return the penetration for a given radius; see `SphereTheory.penetration`.

        The radius of `state` is inverted numerically.
        """
        radius = nonnegative_array("contact_radius", contact_radius)
        angle = self._angles(radius / self._unit_radius, _RADIUS)
        return self._unit_depth * self._reduced(angle)[_DEPTH]

    def curve(self, largest: float) -> tuple[FloatArray, FloatArray]:
        """Return penetrations and forces; see `SphereTheory.curve`."""
        end = min(self.stability_limit("displacement") - 1.0, _MAX_ZONE)
        ratio = 1.0 + np.geomspace(end, _MIN_ZONE, 4 * CURVE_POINTS)
        a, force, depth = self.state(ratio)
        inside = a <= largest
        return depth[inside], force[inside]

    @property
    def _unit_force(self) -> float:
        return np.pi * self.work_of_adhesion * self.radius

    @property
    def _unit_radius(self) -> float:
        return float(self._hertz_radius(self._unit_force))

    @property
    def _unit_depth(self) -> float:
        return self._unit_radius**2 / self.radius

    @cached_property
    def _pull_off(self) -> float:
        """Pull-off force in units of pi w R."""
        return -float(self._reduced(self._last_stable_angle(_FORCE))[_FORCE])

    def _reduced(self, angle: ArrayLike) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return contact radius, force and penetration in the units of `state`.

        The angle is arctan s = arccos(a/c).
        """
        t, lam = np.asarray(angle, dtype=float), self.parameter
        # The gap at c is D: quadratic c^2 + linear c = 1.
        quadratic = lam / 2 * (np.sin(2 * t) / 2 - t * np.cos(2 * t))
        linear = 4 * lam**2 / 3 * (t * np.sin(t) - 2 * np.sin(t / 2) ** 2)
        c = 2 / (linear + np.sqrt(linear**2 + 4 * quadratic))
        a = c * np.cos(t)
        force = a**3 - lam * c**2 * (np.sin(2 * t) / 2 + t)
        return a, force, a**2 - 4 / 3 * lam * c * np.sin(t)

    def _angles(self, values: ArrayLike, output: int) -> FloatArray:
        """Return the angles of stable contacts at which an output has values.

        The output, `_RADIUS`, `_FORCE` or `_DEPTH` of `_reduced`, grows as the angle
        decreases. Values below the smallest one have its angle.
        """
        last = np.pi / 2 if output == _RADIUS else self._last_stable_angle(output)

        def difference(angle: float, value: float) -> float:
            return float(self._reduced(angle)[output]) - value

        angles = []
        for value in np.ravel(values):
            end = last
            # it grows as a power of 1 / end, beyond all numbers before end is 0
            while difference(end, value) < 0:
                end /= 2
            if end < last:
                end = brentq(difference, end, 2 * end, args=value, xtol=1e-15)
            angles.append(end)
        return np.reshape(angles, np.shape(values))

    def _last_stable_angle(self, output: int) -> float:
        """Return the angle of the smallest force or penetration."""

        def value(angle: float) -> float:
            return float(self._reduced(angle)[output])

        # The minimum is at an angle of about 1/lambda (JKR) or at the end pi/2 (DMT).
        angles = np.geomspace(0.1 / (1 + self.parameter), np.pi / 2, 200)
        least = int(np.argmin(self._reduced(angles)[output]))
        last = angles.size - 1
        if least == last and value(angles[-1] * (1 - 1e-6)) > value(angles[-1]):
            return float(angles[-1])
        bounds = angles[least - 1], angles[min(least + 1, last)]
        options = {"xatol": 1e-12 * angles[least]}
        return float(minimize_scalar(value, bounds=bounds, options=options).x)


#: Maugis' parameter below which DMT is accurate: R. W. Carpick, D. F. Ogletree,
#: M. Salmeron, J. Colloid Interface Sci. 211, 395 (1999).
DMT_BELOW = 0.1
#: Maugis' parameter above which JKR is accurate, from the same source.
JKR_ABOVE = 5.0


def sphere_theory(
    radius: float,
    contact_modulus: float,
    work_of_adhesion: float = 0.0,
    attraction_range: float | None = None,
) -> SphereTheory:
    """Return the theory of a smooth sphere, chosen by Maugis' parameter.

    Parameters
    ----------
    radius : float
        Radius R of the sphere (length).
    contact_modulus : float
        Contact modulus E* (force per area).
    work_of_adhesion : float
        Work of adhesion w (energy per area).
    attraction_range : float, optional
        Range D of the attraction (length), required with adhesion. It is the distance
        in Tabor's parameter, and w/D is the tension in Maugis' parameter.

    Returns
    -------
    SphereTheory
        `Hertz` without adhesion, otherwise `DMT`, `JKR` or `MaugisDugdale`.

    Raises
    ------
    ValueError
        If an argument is out of range or missing.

    References
    ----------
    K. L. Johnson, J. A. Greenwood, J. Colloid Interface Sci. 192, 326 (1997): map of
    the ranges of these theories.
    """
    nonnegative(work_of_adhesion=work_of_adhesion)
    if work_of_adhesion == 0:
        return Hertz(radius, contact_modulus)
    if attraction_range is None:
        raise ValueError(
            "attraction_range must be given with a work_of_adhesion, got None"
        )
    sphere = radius, contact_modulus, work_of_adhesion
    general = MaugisDugdale(*sphere, attraction_range)
    if general.parameter > JKR_ABOVE:
        return JKR(*sphere)
    if general.parameter < DMT_BELOW:
        return DMT(*sphere)
    return general
