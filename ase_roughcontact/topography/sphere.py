"""The rough sphere."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from ase_roughcontact._util.validation import (
    FloatArray,
    Point,
    Shape,
    one_of,
    positive,
    surface,
    window,
)
from ase_roughcontact.topography.base import Surface
from ase_roughcontact.topography.topography import Plane, Topography, topography_of


@dataclass(frozen=True)
class RoughSphere(Topography):
    r"""Sphere, or the paraboloid of its apex, with roughness added.

    .. math:: h_R = r^2 / 2R \quad \text{(paraboloid)}, \qquad
              h_R = R - \sqrt{R^2 - r^2} \quad \text{(sphere)}

    Parameters
    ----------
    radius : float
        Radius R (length); infinity for a nominally flat indenter, and for a whole tip
        with its scan as the roughness.
    roughness : Surface, optional
        Roughness h, with its origin on the axis of the sphere; by default none.
    profile : {"paraboloid", "sphere"}
        Shape without the roughness.

    Raises
    ------
    ValueError
        If the radius is not positive, the profile is unknown, or the roughness has no
        method `heights`.

    Examples
    --------
    >>> from ase_roughcontact import RoughSphere, SelfAffine
    >>> rough = SelfAffine(0.1, 0.8, short_wavelength=4.0, long_wavelength=16.0)
    >>> RoughSphere(radius=100.0, roughness=rough).heights((2, 2), 1.0).shape
    (2, 2)
    """

    radius: float
    roughness: Surface | None = None
    profile: Literal["paraboloid", "sphere"] = "paraboloid"

    def __post_init__(self) -> None:
        """Check the parameters."""
        if not (isinstance(self.radius, float) and self.radius == math.inf):
            positive(radius=self.radius)
        one_of(("paraboloid", "sphere"), profile=self.profile)
        if self.roughness is not None:
            surface(roughness=self.roughness)

    def heights(
        self, shape: Shape, spacing: float, origin: Point = (0.0, 0.0)
    ) -> FloatArray:
        """Sample the heights h_R + h, with h_R = 0 on the axis; see `Surface.heights`.

        Raises
        ------
        ValueError
            If the window extends beyond the sphere, or the roughness cannot be sampled
            on it.
        """
        shape, spacing, origin = window(shape, spacing, origin)
        x = origin[0] + spacing * np.arange(shape[0])
        y = origin[1] + spacing * np.arange(shape[1])
        smooth = self._profile(x[:, None] ** 2 + y[None, :] ** 2)
        if self.roughness is None:
            return smooth
        return smooth + self.roughness.heights(shape, spacing, origin)

    def _profile(self, square: FloatArray) -> FloatArray:
        if self.profile == "paraboloid" or self.radius == math.inf:
            return square / (2 * self.radius)
        depth = self.radius**2 - square
        if depth.min() < 0:
            raise ValueError(
                f"the window extends to r = {math.sqrt(square.max()):g} from the axis, "
                f"beyond the sphere of radius {self.radius:g}: choose a smaller window "
                "or profile='paraboloid'"
            )
        # R - sqrt(R^2 - r^2) without cancellation
        return square / (self.radius + np.sqrt(depth))

    def reach(self, level: float, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return where the smooth sphere is high enough; see `BoundedSurface.reach`.

        There it is as high as the level minus the lowest height of the roughness.

        Raises
        ------
        ValueError
            If the indenter is flat, or the roughness has no method `lowest`.
        """
        if self.radius == math.inf:
            return self.rough.reach(level, spacing, origin)
        lowest = self.rough.lowest(spacing, origin)
        if lowest == -math.inf:
            raise ValueError(
                "automatic windows need a roughness with a method lowest, such as "
                f"SelfAffine or HeightMap, got {self.roughness!r}: define it, or "
                "choose a fixed window"
            )
        depth = max(level - lowest, 0.0)
        if self.profile == "paraboloid":
            return math.sqrt(2 * self.radius * depth)
        depth = min(depth, self.radius)
        return math.sqrt(depth * (2 * self.radius - depth))

    @property
    def rough(self) -> Topography:
        """Known properties of the roughness: a plane without one."""
        return Plane() if self.roughness is None else topography_of(self.roughness)

    @property
    def apex_radius(self) -> float:
        """Radius R of the sphere (length)."""
        return self.radius

    @property
    def extent(self) -> float:
        """Distance from the axis, along x and y, up to which heights are known.

        Half of the period of a periodic roughness; infinity for a smooth paraboloid.
        """
        extent = self.rough.extent
        if self.profile == "sphere":
            return min(extent, self.radius / math.sqrt(2))  # a square within the sphere
        return extent

    @property
    def repeats(self) -> bool:
        """Whether the heights are known beyond the extent, by periodic roughness."""
        return self.rough.repeats and self.profile == "paraboloid"

    @property
    def periods(self) -> Point:
        """Periods of the roughness along x and y; infinity if not known (length)."""
        return self.rough.periods

    def band_limited(self, shortest: float) -> RoughSphere:
        """Return the sphere without roughness shorter than a wavelength.

        Raises
        ------
        ValueError
            If the roughness has no method `band_limited`.
        """
        if self.roughness is None:
            return self
        return replace(self, roughness=self.rough.band_limited(shortest))

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, including the roughness."""
        return {
            "name": "RoughSphere",
            "radius": self.radius,
            "roughness": None if self.roughness is None else self.rough.todict(),
            "profile": self.profile,
        }
