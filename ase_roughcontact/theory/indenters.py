r"""Axisymmetric indenters and pyramids on an elastic half space, and on a thin layer.

An axisymmetric indenter of profile f(r) without friction and adhesion has, at the
contact radius a (I. N. Sneddon, Int. J. Eng. Sci. **3**, 47 (1965)),

.. math:: d = a \int_0^a \frac{f'(r)}{\sqrt{a^2 - r^2}} \, dr, \qquad
          N = 2 E^* \int_0^a \frac{r^2 f'(r)}{\sqrt{a^2 - r^2}} \, dr, \qquad
          \frac{dN}{dd} = 2 E^* a.

A four-sided pyramid has the force of a cone of another angle: with
:math:`N = 0.7376 \, E^* \tan\theta \, d^2` the tangent of its half angle is
:math:`0.7376 \, (\pi/2) \tan\theta`, and the area of its contact is 0.865 times that
of this cone. Both numbers follow from relaxed contacts on finer and finer grids; an
estimate is 0.7453 (G. G. Bilodeau, J. Appl. Mech. **59**, 519 (1992)).

On an incompressible layer of thickness h, bonded to a rigid base, the force is larger
by a polynomial of the contact radius on the half space over h (P. D. Garcia and R.
Garcia, Biophys. J. **114**, 2923 (2018)). The error is less than 1 % up to a ratio of
1/2 for a paraboloid and 3/4 for a cone, and 14 % at a ratio of 1 for a paraboloid: see
`tests/theory/test_indenters.py`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline

from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact._util.registry import Registered, Registry
from ase_roughcontact._util.units import ANGLES, LENGTHS, quantity, with_unit
from ase_roughcontact._util.validation import (
    FloatArray,
    nonnegative_array,
    positive,
    unmasked,
)

# Smallest contact radius of the table that inverts depths, relative to the length of
# the shape.
_MIN_RADIUS = 1e-4
# Largest contact radius of this table, relative to the length of the shape.
_MAX_RADIUS = 1e4
# Number of contact radii of this table.
_RADII = 4000
# Tangent of the half angle of a cone over the tangent for a four-sided pyramid with the
# same force: relaxed pyramids have N = 0.73762 E* tan(theta) d^2.
_PYRAMID_TANGENT_RATIO = 0.73762 * math.pi / 2.0
# Contact area of a pyramid over the contact area of this cone: relaxed pyramids have
# A = 1.4785 (tan(theta) d)^2.
_PYRAMID_AREA_RATIO = 1.4785 / (math.pi * 0.73762**2)
# Power of b/a by which this ratio decreases from 1 for a relaxed truncated pyramid.
_TRUNCATED_AREA_POWER = 3.5
# Coefficients of this ratio for a relaxed rounded pyramid, by powers of b/a.
_ROUNDED_AREA_RATIO = (_PYRAMID_AREA_RATIO, 0.1543, 0.4232, -0.39882)
# Smallest b/a of its contacts on the paraboloid, which are circles.
_ROUNDED_END_RATIO = 1.14
# Coefficients of the polynomial for a sphere on a thin layer, by powers of a length
# over the thickness.
_LAYER_OF_SPHERE = (1.0, 1.133, 1.497, 1.469, 0.755)
# Coefficients of this polynomial for a cone.
_LAYER_OF_CONE = (1.0, 0.721, 0.650, 0.491, 0.225)
# Coefficients of this polynomial for a punch.
_LAYER_OF_PUNCH = (1.0, 1.133, 1.283, 0.598, -0.291)


# Height of the side of a punch in units of its radius: beyond all depths.
_PUNCH_HEIGHT = 1e3
# Angle of an indenter in scene files and commands.
_ANGLE = Parameter("deg", below=90.0)
# Length of an indenter in scene files and commands.
_LENGTH = Parameter("a0")
# Number of steps of Newton's method for a depth, which converge from above.
_NEWTON_STEPS = 60

#: Shapes by their names; filled by the definition of subclasses.
INDENTERS: Registry[Any] = Registry("kind of indenter")


class Indenter(Registered, ABC):
    """Rigid indenter of a simple shape on an elastic half space.

    Any consistent system of units will do; only `label` assumes the units of ASE. A
    subclass with a `kind` can be named in scene files and commands; its `parameters`
    are lengths in units of the spacing, and angles in degrees, which it gets in rad.

    Attributes
    ----------
    layer : tuple of float
        Coefficients of the polynomial for a thin layer, by powers of `layer_length`
        over the thickness; empty if they are not known.
    layer_limit : float
        Largest ratio of `layer_length` and thickness for which the polynomial holds.
    area_ratio : float
        Ratio of the area of a large contact to the area of a circle of its radius.
    vertical : bool
        Whether the sides are vertical, so that they never touch.
    edged : bool
        Whether edges between faces touch, as of a pyramid.
    """

    registry = INDENTERS
    layer: ClassVar[tuple[float, ...]] = ()
    layer_limit: ClassVar[float] = 0.5
    area_ratio: ClassVar[float] = 1.0
    vertical: ClassVar[bool] = False
    edged: ClassVar[bool] = False

    @classmethod
    def of_parameters(cls, **parameters: Any) -> Indenter:
        """Return the indenter of lengths, and angles in degrees."""
        units = {name: parameter.unit for name, parameter in cls.parameters.items()}
        return cls(
            **{
                name: math.radians(value) if units[name] == "deg" else value
                for name, value in parameters.items()
            }
        )

    @property
    def name(self) -> str:
        """Name of the shape."""
        return self.kind

    @property
    def label(self) -> str:
        """Name and dimensions: "cone, half angle 35°"."""
        words = [self.name]
        for name, parameter in self.parameters.items():
            value = getattr(self, name)
            text = f"{math.degrees(value):.4g}°"
            if parameter.unit != "deg":
                text = with_unit(value, "nm")
            short = name.removeprefix(f"{self.name}_").replace("_", " ")
            words.append(f"{short} {text}")
        return ", ".join(words)

    @abstractmethod
    def profile(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the heights of the lower side, zero at the tip.

        Parameters
        ----------
        x, y : ndarray
            Positions relative to the axis, broadcast against each other (length).

        Returns
        -------
        ndarray
            Heights (length).
        """

    @abstractmethod
    def reach(self, level: float) -> float:
        """Return a distance from the axis beyond which all heights exceed a level.

        Parameters
        ----------
        level : float
            Height, not negative (length).
        """

    def force(self, depth: ArrayLike) -> FloatArray:
        """Return the force over the contact modulus, N/E*; by default not known.

        Parameters
        ----------
        depth : array_like
            Penetration, zero at the first contact, where the force is zero (length).

        Returns
        -------
        ndarray, shape of `depth`
            Ratio N/E* (area); NaN if there is no closed form.
        """
        return np.full(np.shape(depth), np.nan)

    def radius(self, depth: ArrayLike) -> FloatArray:
        """Return the contact radius (length); see `force`."""
        return np.full(np.shape(depth), np.nan)

    def contact_area(self, radius: ArrayLike) -> FloatArray:
        """Return the contact area.

        Parameters
        ----------
        radius : array_like
            Contact radius a, for a pyramid of the cone with its force (length).

        Returns
        -------
        ndarray, shape of `radius`
            Area (length squared).
        """
        return self.area_ratio * np.pi * np.asarray(radius, float) ** 2

    def depth(self, force: ArrayLike) -> FloatArray:
        """Return the penetration under a force, by Newton's method.

        Parameters
        ----------
        force : array_like
            Ratio N/E*, not negative (area).

        Returns
        -------
        ndarray, shape of `force`
            Penetration (length).
        """
        force = nonnegative_array("force", force)
        depth = np.sqrt(force)
        while np.any(low := self.force(depth) < force):
            depth = np.where(low, 2.0 * depth, depth)
        for _ in range(_NEWTON_STEPS):  # the force is convex, with the slope 2 a
            slope = 2.0 * self.radius(depth)
            excess = self.force(depth) - force
            steps = np.divide(excess, slope, out=np.zeros_like(depth), where=slope > 0)
            depth = np.maximum(depth - steps, 0.0)
        return np.where(np.isnan(self.force(depth)), np.nan, depth)

    def layer_length(self, depth: ArrayLike) -> FloatArray:
        """Return the length in the polynomial for a thin layer; see `force`."""
        return self.radius(depth)

    def force_on_layer(self, depth: ArrayLike, thickness: float) -> FloatArray:
        """Return N/E* on an incompressible layer that is bonded to a rigid base.

        Parameters
        ----------
        depth : array_like
            Penetration, see `force` (length).
        thickness : float
            Thickness h of the layer (length).

        Returns
        -------
        ndarray
            Ratio N/E* with the contact modulus E* of the layer (area).

        Raises
        ------
        ValueError
            If the thickness is not positive, or no formula is known for the shape.
        """
        if math.isinf(thickness):
            return self.force(depth)
        positive(thickness=thickness)
        if not self.layer:
            raise ValueError(
                f"no formula for a thin layer is known for a {self.name}: use a scene "
                "with layer_thickness in [substrate], or a sphere, cone or punch"
            )
        ratio = self.layer_length(depth) / thickness
        return self.force(depth) * np.polynomial.polynomial.polyval(ratio, self.layer)


@dataclass(frozen=True)
class Paraboloid(Indenter):
    """Paraboloid, Hertz' sphere: N = 4/3 E* sqrt(R) d^(3/2).

    Attributes
    ----------
    tip_radius : float
        R, length.
    """

    kind = "paraboloid"
    parameters: ClassVar[Mapping[str, Parameter]] = {"tip_radius": _LENGTH}
    layer: ClassVar[tuple[float, ...]] = _LAYER_OF_SPHERE

    tip_radius: float

    def __post_init__(self) -> None:
        """Check the radius."""
        positive(tip_radius=self.tip_radius)

    def profile(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return r^2/2R."""
        return (x**2 + y**2) / (2.0 * self.tip_radius)

    def reach(self, level: float) -> float:
        """Return the distance at which a height is reached."""
        return math.sqrt(2.0 * self.tip_radius * level)

    def force(self, depth: ArrayLike) -> FloatArray:
        """Return N/E*."""
        depth = _above_zero(depth)
        return 4.0 / 3.0 * math.sqrt(self.tip_radius) * depth**1.5

    def radius(self, depth: ArrayLike) -> FloatArray:
        """Return the contact radius."""
        return np.sqrt(self.tip_radius * _above_zero(depth))


@dataclass(frozen=True)
class Cone(Indenter):
    """Cone: N = 2/pi E* tan(theta) d^2.

    Attributes
    ----------
    half_angle : float
        theta between axis and side, rad.
    """

    kind = "cone"
    parameters: ClassVar[Mapping[str, Parameter]] = {"half_angle": _ANGLE}
    layer: ClassVar[tuple[float, ...]] = _LAYER_OF_CONE
    layer_limit: ClassVar[float] = 0.75

    half_angle: float

    def __post_init__(self) -> None:
        """Check the angle."""
        _check_angle(self.half_angle)

    @property
    def tangent(self) -> float:
        """Tangent of the half angle of a cone with this force."""
        return math.tan(self.half_angle)

    def profile(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return r cot(theta)."""
        return np.hypot(x, y) / math.tan(self.half_angle)

    def reach(self, level: float) -> float:
        """Return the distance at which a height is reached."""
        return level * math.tan(self.half_angle)

    def force(self, depth: ArrayLike) -> FloatArray:
        """Return N/E*."""
        return 2.0 / math.pi * self.tangent * _above_zero(depth) ** 2

    def radius(self, depth: ArrayLike) -> FloatArray:
        """Return the contact radius."""
        return 2.0 / math.pi * self.tangent * _above_zero(depth)

    def layer_length(self, depth: ArrayLike) -> FloatArray:
        """Return d tan(theta)."""
        return self.tangent * _above_zero(depth)


class Pyramid(Cone):
    """Four-sided pyramid: N = 0.7376 E* tan(theta) d^2, theta between axis and face."""

    area_ratio: ClassVar[float] = _PYRAMID_AREA_RATIO
    edged: ClassVar[bool] = True
    kind = "pyramid"
    layer: ClassVar[tuple[float, ...]] = ()

    @property
    def tangent(self) -> float:
        """Tangent of the half angle of a cone with this force."""
        return _PYRAMID_TANGENT_RATIO * math.tan(self.half_angle)

    def profile(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return max(abs(x), abs(y)) cot(theta)."""
        return np.maximum(abs(x), abs(y)) / math.tan(self.half_angle)

    def reach(self, level: float) -> float:
        """Return the distance of a corner at which a height is reached."""
        return math.sqrt(2.0) * super().reach(level)


@dataclass(frozen=True)
class Punch(Indenter):
    """Cylinder with a flat end: N = 2 E* a d.

    Attributes
    ----------
    punch_radius : float
        Contact radius a (length).
    """

    kind = "punch"
    vertical: ClassVar[bool] = True
    parameters: ClassVar[Mapping[str, Parameter]] = {"punch_radius": _LENGTH}
    layer: ClassVar[tuple[float, ...]] = _LAYER_OF_PUNCH

    punch_radius: float

    def __post_init__(self) -> None:
        """Check the radius."""
        positive(punch_radius=self.punch_radius)

    def profile(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return zero on the end, and a height beyond all depths outside of it."""
        outside = np.hypot(x, y) > self.punch_radius
        return np.where(outside, _PUNCH_HEIGHT * self.punch_radius, 0.0)

    def reach(self, level: float) -> float:
        """Return the radius of the end."""
        return self.punch_radius

    def force(self, depth: ArrayLike) -> FloatArray:
        """Return N/E*."""
        return 2.0 * self.punch_radius * _above_zero(depth)

    def radius(self, depth: ArrayLike) -> FloatArray:
        """Return the contact radius, the radius of the end of the punch."""
        return np.where(_above_zero(depth) > 0.0, self.punch_radius, 0.0)


class _ByContactRadius(Indenter):
    """Indenter with depth and force as functions of the contact radius."""

    @property
    @abstractmethod
    def length(self) -> float:
        """Length of the shape by which contact radii are chosen."""

    @abstractmethod
    def at_radius(self, radius: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return depths, and forces N/E*, at contact radii."""

    @cached_property
    def _table(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Depths, forces and contact radii, from the first contact on."""
        depth, force = self.at_radius(self.radii)
        radius = np.append(self.least_radius, self.radii)
        return np.append(0.0, depth), np.append(0.0, force), radius

    @cached_property
    def _force_spline(self) -> Callable[[FloatArray], FloatArray]:
        """Force as a function of the depth in the table."""
        depth, force, radius = self._table
        return CubicHermiteSpline(depth, force, 2.0 * radius)

    def _beyond(self, depth: FloatArray) -> tuple[FloatArray, float]:
        """Return depths beyond the table, and the slope of the radius there."""
        table, _, radius = self._table
        slope = (radius[-1] - radius[-2]) / (table[-1] - table[-2])
        return np.maximum(depth - table[-1], 0.0), float(slope)

    @property
    def least_radius(self) -> float:
        """Contact radius at the first contact."""
        return 0.0

    @property
    def radii(self) -> FloatArray:
        """Contact radii of a table."""
        return self.length * np.geomspace(_MIN_RADIUS, _MAX_RADIUS, _RADII)

    def force(self, depth: ArrayLike) -> FloatArray:
        """Return N/E*."""
        depth = _above_zero(depth)
        beyond, slope = self._beyond(depth)
        added = beyond * (2.0 * self._table[2][-1] + slope * beyond)
        return self._force_spline(depth - beyond) + added

    def radius(self, depth: ArrayLike) -> FloatArray:
        """Return the contact radius; beyond the table it is linear in the depth."""
        depth = _above_zero(depth)
        beyond, slope = self._beyond(depth)
        table, _, radius = self._table
        inside = np.interp(depth, table, radius) + slope * beyond
        return np.where(depth > 0.0, inside, 0.0)


@dataclass(frozen=True)
class Sphere(_ByContactRadius):
    """Sphere, also where the contact is as wide as the sphere.

    Attributes
    ----------
    tip_radius : float
        R, length.
    """

    kind = "sphere"
    parameters: ClassVar[Mapping[str, Parameter]] = {"tip_radius": _LENGTH}
    layer: ClassVar[tuple[float, ...]] = _LAYER_OF_SPHERE

    tip_radius: float

    def __post_init__(self) -> None:
        """Check the radius."""
        positive(tip_radius=self.tip_radius)

    def profile(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return R - sqrt(R^2 - r^2), beyond the equator its height R."""
        square = np.minimum(x**2 + y**2, self.tip_radius**2)
        return square / (self.tip_radius + np.sqrt(self.tip_radius**2 - square))

    def reach(self, level: float) -> float:
        """Return the distance at which a height is reached, at most R."""
        level = min(level, self.tip_radius)
        return math.sqrt(level * (2.0 * self.tip_radius - level))

    @property
    def length(self) -> float:
        """R."""
        return self.tip_radius

    @property
    def radii(self) -> FloatArray:
        """Contact radii up to the equator."""
        half = np.geomspace(_MIN_RADIUS, 0.5, _RADII)
        near = 1.0 - np.geomspace(0.5, 1e-12, _RADII)[1:]
        return self.tip_radius * np.append(half, near)

    def at_radius(self, radius: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return depths and forces."""
        a, R = radius, self.tip_radius
        logarithm = np.log1p(2.0 * a / (R - a))
        force = 0.5 * (a**2 + R**2) * logarithm - a * R
        # the difference is lost in rounding for a small contact
        small = a < 0.02 * R
        x = a / R
        series = R**2 * (4.0 / 3.0 * x**3 + 8.0 / 15.0 * x**5 + 12.0 / 35.0 * x**7)
        return 0.5 * a * logarithm, np.where(small, series, force)

    def layer_length(self, depth: ArrayLike) -> FloatArray:
        """Return sqrt(R d)."""
        return np.sqrt(self.tip_radius * _above_zero(depth))


@dataclass(frozen=True)
class TruncatedCone(_ByContactRadius):
    """Cone with a flat end.

    Attributes
    ----------
    half_angle : float
        theta between axis and side, rad.
    end_radius : float
        b of the end, length.
    """

    kind = "truncated cone"
    parameters: ClassVar[Mapping[str, Parameter]] = {
        "half_angle": _ANGLE,
        "end_radius": _LENGTH,
    }

    half_angle: float
    end_radius: float

    def __post_init__(self) -> None:
        """Check angle and radius."""
        _check_angle(self.half_angle)
        positive(end_radius=self.end_radius)

    @property
    def tangent(self) -> float:
        """Tangent of the half angle."""
        return math.tan(self.half_angle)

    def profile(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return zero on the end, and (r - b) cot(theta) on the side."""
        beyond = np.maximum(np.hypot(x, y) - self.end_radius, 0.0)
        return beyond / math.tan(self.half_angle)

    def reach(self, level: float) -> float:
        """Return the distance at which a height is reached."""
        return self.end_radius + level * math.tan(self.half_angle)

    @property
    def length(self) -> float:
        """b, the radius of the end."""
        return self.end_radius

    @property
    def least_radius(self) -> float:
        """b, the radius of the end."""
        return self.end_radius

    @property
    def radii(self) -> FloatArray:
        """Contact radii of the table, from the radius of the end on."""
        return self.end_radius * (1.0 + np.geomspace(1e-8, _MAX_RADIUS, _RADII))

    def at_radius(self, radius: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return depths and forces."""
        return _cone_from(radius, self.end_radius, 1.0 / self.tangent)


class TruncatedPyramid(TruncatedCone):
    """Four-sided pyramid with a flat end: the truncated cone with its force.

    The end is a square with the area of a circle of the radius `end_radius`. Where both
    end and sides count, the force of a relaxed contact is about 2 % larger. The ratio
    of the contact area to a circle was fitted to relaxed contacts, with an error of
    0.5 %.
    """

    kind = "truncated pyramid"
    area_ratio: ClassVar[float] = _PYRAMID_AREA_RATIO
    edged: ClassVar[bool] = True

    @property
    def tangent(self) -> float:
        """Tangent of the half angle of a cone with this force."""
        return _PYRAMID_TANGENT_RATIO * math.tan(self.half_angle)

    @property
    def half_side(self) -> float:
        """Half the side of the end."""
        return 0.5 * math.sqrt(math.pi) * self.end_radius

    def contact_area(self, radius: ArrayLike) -> FloatArray:
        """Return the contact area, see `Indenter.contact_area`."""
        radius = np.asarray(radius, float)
        beyond = np.maximum(radius, self.end_radius)
        end = (self.end_radius / beyond) ** _TRUNCATED_AREA_POWER
        return (self.area_ratio + (1.0 - self.area_ratio) * end) * np.pi * radius**2

    def profile(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the heights of four faces around a square."""
        beyond = np.maximum(np.maximum(abs(x), abs(y)) - self.half_side, 0.0)
        return beyond / math.tan(self.half_angle)

    def reach(self, level: float) -> float:
        """Return the distance of a corner at which a height is reached."""
        side = self.half_side + level * math.tan(self.half_angle)
        return math.sqrt(2.0) * side


@dataclass(frozen=True)
class RoundedCone(_ByContactRadius):
    """Cone that ends in a paraboloid, without an edge between them.

    B. J. Briscoe, K. S. Sebastian and M. J. Adams, J. Phys. D **27**, 1156 (1994).

    Attributes
    ----------
    half_angle : float
        theta between axis and side, rad.
    tip_radius : float
        R of the end, length.
    """

    kind = "rounded cone"
    parameters: ClassVar[Mapping[str, Parameter]] = {
        "half_angle": _ANGLE,
        "tip_radius": _LENGTH,
    }

    half_angle: float
    tip_radius: float

    def __post_init__(self) -> None:
        """Check angle and radius."""
        _check_angle(self.half_angle)
        positive(tip_radius=self.tip_radius)

    @property
    def tangent(self) -> float:
        """Tangent of the half angle."""
        return math.tan(self.half_angle)

    def profile(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return r^2/2R at the tip, and r s - R s^2/2 with s = cot(theta) beyond."""
        slope = 1.0 / math.tan(self.half_angle)
        r = np.hypot(x, y)
        side = r * slope - 0.5 * self.tip_radius * slope**2
        return np.where(
            r < self.tip_radius * slope, r**2 / (2.0 * self.tip_radius), side
        )

    def reach(self, level: float) -> float:
        """Return the distance at which a height is reached."""
        slope, R = 1.0 / math.tan(self.half_angle), self.tip_radius
        if level < 0.5 * R * slope**2:
            return math.sqrt(2.0 * R * level)
        return level / slope + 0.5 * R * slope

    @property
    def length(self) -> float:
        """Radius at which the cone begins."""
        return self.tip_radius / self.tangent

    def at_radius(self, radius: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return depths and forces."""
        a, b, R = radius, self.length, self.tip_radius
        beyond = np.sqrt(np.maximum(a**2 - b**2, 0.0))
        depth = a * (a - beyond) / R
        force = 2.0 / (3.0 * R) * (2.0 * a**3 - (2.0 * a**2 + b**2) * beyond)
        side = _cone_from(np.maximum(a, b), b, 1.0 / self.tangent)
        return depth + side[0], np.where(a < b, 4.0 * a**3 / (3.0 * R), force + side[1])


class RoundedPyramid(RoundedCone):
    r"""Four-sided pyramid with a rounded tip: the rounded cone with its force.

    Where both tip and sides count, the force of a relaxed contact is about 3 % larger.
    The ratio of the contact area to a circle was fitted to relaxed contacts, with an
    error of 0.5 %. Tip and edges are rounded by a paraboloid,
    :math:`h = \max_p [p \cdot x - R p^2/2]` with :math:`|p_x| + |p_y| \le \cot\theta`:
    the slopes of a pyramid and of its edges.
    """

    kind = "rounded pyramid"
    area_ratio: ClassVar[float] = _PYRAMID_AREA_RATIO

    @property
    def tangent(self) -> float:
        """Tangent of the half angle of a cone with this force."""
        return _PYRAMID_TANGENT_RATIO * math.tan(self.half_angle)

    def contact_area(self, radius: ArrayLike) -> FloatArray:
        """Return the contact area, see `Indenter.contact_area`."""
        radius = np.asarray(radius, float)
        beyond = np.maximum(radius, self.length / _ROUNDED_END_RATIO)
        ratio = np.polynomial.Polynomial(_ROUNDED_AREA_RATIO)(self.length / beyond)
        return ratio * np.pi * radius**2

    def profile(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return the heights of faces, rounded edges and a paraboloid at the tip."""
        slope, R = 1.0 / math.tan(self.half_angle), self.tip_radius
        u, v = np.broadcast_arrays(abs(x), abs(y))
        # the slope of a paraboloid, or the closest slope on an edge
        along = np.clip(0.5 * (slope + (u - v) / R), 0.0, slope)
        at_tip = u + v <= R * slope
        p, q = np.where(at_tip, u / R, along), np.where(at_tip, v / R, slope - along)
        return p * u + q * v - 0.5 * R * (p**2 + q**2)

    def reach(self, level: float) -> float:
        """Return a distance beyond which a height is exceeded."""
        slope, R = 1.0 / math.tan(self.half_angle), self.tip_radius
        if level < 0.25 * R * slope**2:  # within the paraboloid
            return math.sqrt(2.0 * R * level)
        return math.sqrt(2.0) * (level / slope + 0.5 * R * slope)


def _cone_from(a: FloatArray, b: float, slope: float) -> tuple[FloatArray, FloatArray]:
    """Return depth and N/E* of a cone of a slope that begins at a radius b."""
    # arccos(b/a), also where a is close to b
    angle = np.arctan2(np.sqrt((a - b) * (a + b)), b)
    force = a**2 * angle + b * np.sqrt((a - b) * (a + b))
    return slope * a * angle, slope * force


def named_indenter(text: str) -> Indenter:
    """Return an indenter by its name and dimensions, in Å and rad.

    Parameters
    ----------
    text : str
        Such as ``"sphere 5 um"``, ``"cone 35 deg"``, ``"punch 2 um"`` (radii), also
        "flat punch" or "cylinder", ``"rounded pyramid 35 deg 20 nm"``.

    Returns
    -------
    Indenter

    Raises
    ------
    ValueError
        If the name, the number of dimensions, or a unit is unknown.
    """
    words = text.split()
    count = next((i for i, word in enumerate(words) if not word.isalpha()), len(words))
    name, values = " ".join(words[:count]), words[count:]
    name = _OTHER_NAMES.get(name, name)
    if name not in INDENTERS:
        raise ValueError(
            f"unknown indenter {name!r}: give one of {', '.join(INDENTERS)}, with its "
            'dimensions, such as "cone 35 deg"'
        )
    made = INDENTERS[name]
    kinds = [_KINDS[each.unit] for each in made.parameters.values()]
    if len(values) != 2 * len(kinds):
        raise ValueError(
            f"a {name} needs {' and '.join(kinds)} with units, got {text!r}: write "
            f'"{name} {" ".join(_EXAMPLES[kind] for kind in kinds)}"'
        )
    units = {"length": LENGTHS, "angle": ANGLES}
    dimensions = {}
    for i, (key, kind) in enumerate(zip(made.parameters, kinds, strict=True)):
        given = " ".join(values[2 * i : 2 * i + 2])
        dimensions[key] = quantity(kind, given, units[kind], _EXAMPLES[kind])
    indenter: Indenter = made.of_parameters(**dimensions)
    return indenter


# Other names of indenters.
_OTHER_NAMES = {"flat punch": "punch", "cylinder": "punch"}
# Dimensions by the units of their parameters.
_KINDS = {"a0": "length", "deg": "angle"}
# Examples of the dimensions of an indenter, for messages.
_EXAMPLES = {"length": "20 nm", "angle": "35 deg"}


def _above_zero(depth: ArrayLike) -> FloatArray:
    """Return depths, zero above the surface."""
    values: FloatArray = np.asarray(unmasked(depth), float)
    return nonnegative_array("depth", np.maximum(values, 0.0))


def _check_angle(angle: float) -> None:
    """Raise `ValueError` if the half angle of a cone is not below 90 degrees."""
    positive(half_angle=angle)
    if angle >= math.pi / 2.0:
        raise ValueError(
            f"half_angle must be below 90 degrees, got {math.degrees(angle):.4g}"
        )
