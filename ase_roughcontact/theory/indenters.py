r"""Axisymmetric indenters and pyramids on an elastic half space, and on a thin layer.

An axisymmetric indenter of profile f(r) without friction and adhesion has, at the
contact radius a (I. N. Sneddon, Int. J. Eng. Sci. **3**, 47 (1965)),

.. math:: d = a \int_0^a \frac{f'(r)}{\sqrt{a^2 - r^2}} \, dr, \qquad
          N = 2 E^* \int_0^a \frac{r^2 f'(r)}{\sqrt{a^2 - r^2}} \, dr, \qquad
          \frac{dN}{dd} = 2 E^* a.

A four-sided pyramid has the force of a cone of another angle: with
:math:`N = 0.7453 \, E^* \tan\theta \, d^2` (G. G. Bilodeau, J. Appl. Mech. **59**, 519
(1992)) the tangent of its half angle is :math:`0.7453 \, (\pi/2) \tan\theta`.

On an incompressible layer of thickness h, bonded to a rigid base, the force is larger
by a polynomial of the contact radius on the half space over h (P. D. Garcia and R.
Garcia, Biophys. J. **114**, 2923 (2018)). The error is less than 1 % up to a ratio of
1/2 for a paraboloid and 3/4 for a cone, and 14 % at a ratio of 1 for a paraboloid: see
`tests/theory/test_indenters.py`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicHermiteSpline

from ase_roughcontact._util.units import ANGLES, LENGTHS, UNITS, quantity
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
# same force.
_PYRAMID_TANGENT_RATIO = 0.7453 * math.pi / 2.0
# Coefficients of the polynomial for a sphere on a thin layer, by powers of a length
# over the thickness.
_LAYER_OF_SPHERE = (1.0, 1.133, 1.497, 1.469, 0.755)
# Coefficients of this polynomial for a cone.
_LAYER_OF_CONE = (1.0, 0.721, 0.650, 0.491, 0.225)
# Coefficients of this polynomial for a punch.
_LAYER_OF_PUNCH = (1.0, 1.133, 1.283, 0.598, -0.291)


class Indenter(ABC):
    """Rigid indenter of a simple shape on an elastic half space.

    Any consistent system of units will do.

    Attributes
    ----------
    name : str
        Name of the shape.
    layer : tuple of float
        Coefficients of the polynomial for a thin layer, by powers of `layer_length`
        over the thickness; empty if they are not known.
    layer_limit : float
        Largest ratio of `layer_length` and thickness for which the polynomial holds.
    """

    name: ClassVar[str]
    layer: ClassVar[tuple[float, ...]] = ()
    layer_limit: ClassVar[float] = 0.5

    @abstractmethod
    def force(self, depth: ArrayLike) -> FloatArray:
        """Return the force over the contact modulus, N/E*.

        Parameters
        ----------
        depth : array_like
            Penetration, zero at the first contact, where the force is zero (length).

        Returns
        -------
        ndarray, shape of `depth`
            Ratio N/E* (area).
        """

    @abstractmethod
    def radius(self, depth: ArrayLike) -> FloatArray:
        """Return the contact radius (length); see `force`."""

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

    name = "paraboloid"
    layer: ClassVar[tuple[float, ...]] = _LAYER_OF_SPHERE

    tip_radius: float

    def __post_init__(self) -> None:
        """Check the radius."""
        positive(tip_radius=self.tip_radius)

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

    name = "cone"
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
    """Four-sided pyramid: N = 0.7453 E* tan(theta) d^2, theta between axis and face."""

    name = "pyramid"
    layer: ClassVar[tuple[float, ...]] = ()

    @property
    def tangent(self) -> float:
        """Tangent of the half angle of a cone with this force."""
        return _PYRAMID_TANGENT_RATIO * math.tan(self.half_angle)


@dataclass(frozen=True)
class Punch(Indenter):
    """Cylinder with a flat end: N = 2 E* a d.

    Attributes
    ----------
    punch_radius : float
        Contact radius a (length).
    """

    name = "punch"
    layer: ClassVar[tuple[float, ...]] = _LAYER_OF_PUNCH

    punch_radius: float

    def __post_init__(self) -> None:
        """Check the radius."""
        positive(punch_radius=self.punch_radius)

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
    def _splines(self) -> tuple[Callable[[FloatArray], FloatArray], ...]:
        """Force and contact radius as functions of the depth."""
        radius = self.radii
        depth, force = self.at_radius(radius)
        depth, force = np.append(0.0, depth), np.append(0.0, force)
        radius = np.append(self.least_radius, radius)
        by_depth = CubicHermiteSpline(depth, force, 2.0 * radius)
        return by_depth, lambda d: np.interp(d, depth, radius)

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
        return self._splines[0](_above_zero(depth))

    def radius(self, depth: ArrayLike) -> FloatArray:
        """Return the contact radius."""
        depth = _above_zero(depth)
        return np.where(depth > 0.0, self._splines[1](depth), 0.0)


@dataclass(frozen=True)
class Sphere(_ByContactRadius):
    """Sphere, also where the contact is as wide as the sphere.

    Attributes
    ----------
    tip_radius : float
        R, length.
    """

    name = "sphere"
    layer: ClassVar[tuple[float, ...]] = _LAYER_OF_SPHERE

    tip_radius: float

    def __post_init__(self) -> None:
        """Check the radius."""
        positive(tip_radius=self.tip_radius)

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

    name = "truncated cone"

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

    @property
    def length(self) -> float:
        """B."""
        return self.end_radius

    @property
    def least_radius(self) -> float:
        """B."""
        return self.end_radius

    @property
    def radii(self) -> FloatArray:
        """Contact radii of the table, from the radius of the end on."""
        return self.end_radius * (1.0 + np.geomspace(1e-8, _MAX_RADIUS, _RADII))

    def at_radius(self, radius: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return depths and forces."""
        return _cone_from(radius, self.end_radius, 1.0 / self.tangent)


class TruncatedPyramid(TruncatedCone):
    """Four-sided pyramid with a flat end: the truncated cone with its force."""

    name = "truncated pyramid"

    @property
    def tangent(self) -> float:
        """Tangent of the half angle of a cone with this force."""
        return _PYRAMID_TANGENT_RATIO * math.tan(self.half_angle)


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

    name = "rounded cone"

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
    """Four-sided pyramid that ends in a paraboloid: the rounded cone with its force."""

    name = "rounded pyramid"

    @property
    def tangent(self) -> float:
        """Tangent of the half angle of a cone with this force."""
        return _PYRAMID_TANGENT_RATIO * math.tan(self.half_angle)


def _cone_from(a: FloatArray, b: float, slope: float) -> tuple[FloatArray, FloatArray]:
    """Return depth and N/E* of a cone of a slope that begins at a radius b."""
    # arccos(b/a), also where a is close to b
    angle = np.arctan2(np.sqrt((a - b) * (a + b)), b)
    force = a**2 * angle + b * np.sqrt((a - b) * (a + b))
    return slope * a * angle, slope * force


#: Shapes by their names, and the lengths or angles that they need.
INDENTERS: dict[str, tuple[type[Indenter], tuple[str, ...]]] = {
    "paraboloid": (Paraboloid, ("length",)),
    "sphere": (Sphere, ("length",)),
    "cone": (Cone, ("angle",)),
    "pyramid": (Pyramid, ("angle",)),
    "punch": (Punch, ("length",)),
    "truncated cone": (TruncatedCone, ("angle", "length")),
    "truncated pyramid": (TruncatedPyramid, ("angle", "length")),
    "rounded cone": (RoundedCone, ("angle", "length")),
    "rounded pyramid": (RoundedPyramid, ("angle", "length")),
}


def named_indenter(text: str) -> Indenter:
    """Return an indenter by its name and dimensions, in Å and rad.

    Parameters
    ----------
    text : str
        Such as ``"sphere 5 um"``, ``"cone 35 deg"``, ``"punch 2 um"`` (radii),
        ``"rounded pyramid 35 deg 20 nm"``.

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
    if name not in INDENTERS:
        raise ValueError(
            f"unknown indenter {name!r}: give one of {', '.join(INDENTERS)}, with its "
            'dimensions, such as "cone 35 deg"'
        )
    made, kinds = INDENTERS[name]
    if len(values) != 2 * len(kinds):
        raise ValueError(
            f"a {name} needs {' and '.join(kinds)} with units, got {text!r}: write "
            f'"{name} {" ".join(_EXAMPLES[kind] for kind in kinds)}"'
        )
    units = {"length": LENGTHS, "angle": ANGLES}
    scales = {"length": 1.0, "angle": math.radians(1.0) / UNITS["deg"]}
    dimensions = [
        scales[kind] * quantity(kind, " ".join(pair), units[kind], _EXAMPLES[kind])
        for kind, pair in zip(
            kinds, zip(values[::2], values[1::2], strict=True), strict=True
        )
    ]
    return made(*dimensions)


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
