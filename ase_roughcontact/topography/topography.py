"""Properties of an indenter or a roughness besides its heights."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.registry import Registered, Registry
from ase_roughcontact._util.validation import (
    FloatArray,
    Point,
    Shape,
    window,
)
from ase_roughcontact.topography.base import Surface
from ase_roughcontact.topography.spectrum import Statistics

#: Roughnesses of one's own by their `kind`; filled by the definition of subclasses.
ROUGHNESSES: Registry[type[Topography]] = Registry("kind of roughness")


class Topography(Registered, Surface):
    """Base class of surfaces: indenters, and the roughness of a sphere.

    A subclass defines `heights`, and all other known properties. A number that it
    does not define is "not known": NaN, infinity where it is a bound, or zero where
    there is nothing of the kind. A surface of another class is described by
    `topography_of`.

    A subclass with a `kind` can be the roughness of a scene file; its `parameters` are
    keys of the section ``[roughness]``. Theory needs its `rms_slope`, `hurst`,
    `short_wavelength` and `long_wavelength`.

    Attributes
    ----------
    edge_change : float
        Rms height that was subtracted to make a scan periodic (length).
    """

    registry = ROUGHNESSES
    edge_change: float = 0.0

    @abstractmethod
    def heights(
        self, shape: Shape, spacing: float, origin: Point = (0.0, 0.0)
    ) -> FloatArray:
        """Sample the heights on a grid; see `Surface.heights`."""

    @property
    def rough(self) -> Topography:
        """Roughness on a sphere; the surface itself if it is no sphere."""
        return self

    @property
    def parts(self) -> tuple[Topography, ...]:
        """Surfaces that are summed; the surface itself if it is no sum."""
        return (self,)

    def replaced(self, old: Surface, new: Surface) -> Surface:
        """Return the surface with another one in place of one of its parts."""
        return new if old is self else self

    @property
    def apex_radius(self) -> float:
        """Radius of curvature of a sphere; infinity for other surfaces (length)."""
        return math.inf

    @property
    def profile(self) -> str:
        """Shape of a sphere without its roughness; empty for other surfaces."""
        return ""

    @property
    def has_edges(self) -> bool:
        """Whether edges between faces touch, as of a pyramid."""
        return False

    @property
    def vertical_sides(self) -> bool:
        """Whether the sides are vertical and never touch, as of a punch."""
        return False

    @property
    def extent(self) -> float:
        """Distance from the axis, along x and y, up to which heights are known.

        Half of the period of a periodic surface; infinity without a bound (length).
        """
        return math.inf

    @property
    def middle_extent(self) -> float:
        """The extent if the middle of a map is on the axis (length)."""
        return self.extent

    @property
    def repeats(self) -> bool:
        """Whether the surface is periodic beyond the extent."""
        return False

    @property
    def periods(self) -> Point:
        """Periods along x and y; infinity where they are not known (length)."""
        return math.inf, math.inf

    @property
    def side(self) -> float:
        """Side of the domain on which waves are synthesised; else zero (length)."""
        return 0.0

    @property
    def shortest_wavelength(self) -> float:
        """Shortest wavelength of the heights; NaN if it is not known (length)."""
        return math.nan

    @property
    def longest_wavelength(self) -> float | None:
        """End of the roll-off of the power spectrum; None without one (length)."""
        return None

    @property
    def pixel(self) -> float:
        """Distance between the points of a scan; NaN without a scan (length)."""
        return math.nan

    @property
    def seed(self) -> int | None:
        """Seed of a random surface; None for other surfaces."""
        return None

    @property
    def mean_height(self) -> float:
        """Mean of the heights (length)."""
        return 0.0

    def statistics(self) -> Statistics:
        """Return the rms height, slope and curvature; NaN if they are not known."""
        return Statistics(math.nan, math.nan, math.nan)

    @property
    def rms_height(self) -> float:
        """Rms height by `statistics` (length)."""
        return self.statistics().rms_height

    @property
    def rms_curvature(self) -> float:
        """Rms curvature by `statistics` (1/length)."""
        return self.statistics().rms_curvature

    def lowest(self, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return a lower bound of the heights on a grid; -infinity without a bound.

        `origin` is the position of a point of the grid relative to the axis (length).
        """
        return -math.inf

    def reach(self, level: float, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return a distance from the axis; see `BoundedSurface.reach`.

        Raises
        ------
        ValueError
            If it is not known.
        """
        raise ValueError(
            "automatic windows and first_contact need a BoundedSurface with a method "
            f"reach, such as a sphere or a scanned tip, got {self!r}: choose a fixed "
            "window"
        )

    def band_limited(self, shortest: float) -> Surface:
        """Return the surface without waves shorter than a wavelength (length).

        Raises
        ------
        ValueError
            If its waves are not known.
        """
        raise ValueError(
            "a coarser grid needs a roughness with a method band_limited, such as "
            f"SelfAffine, got {self!r}: smooth it yourself"
        )

    def part_of_period(self, sides: np.ndarray) -> float:
        """Return the smaller ratio of a side of a cell, shape (2,), and the period.

        It is one, but for rounding, if the surface continues across the edges of a
        periodic cell, as no cell is larger than a period; NaN without a period.
        """
        known = np.isfinite(self.periods)
        ratios = np.where(known, np.divide(sides, self.periods), np.nan)
        return float(np.round(ratios.min(), 9))

    def points(self, spacing: float) -> int:
        """Return the number of points on which the roughness is synthesised."""
        rough = self.rough
        if rough is self:
            return round(self.side / spacing) ** 2
        return rough.points(spacing)


@dataclass(frozen=True)
class Plane(Topography):
    """Surface of height zero: the roughness of a smooth sphere."""

    def heights(
        self, shape: Shape, spacing: float, origin: Point = (0.0, 0.0)
    ) -> FloatArray:
        """Sample the heights on a grid; see `Surface.heights`."""
        return np.zeros(window(shape, spacing, origin)[0])

    def statistics(self) -> Statistics:
        """Return an rms height, slope and curvature of zero."""
        return Statistics(0.0, 0.0, 0.0)

    def lowest(self, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return zero."""
        return 0.0

    def band_limited(self, shortest: float) -> Plane:
        """Return the plane."""
        return self


def topography_of(surface: Surface) -> Topography:
    """Return the known properties of any surface.

    Parameters
    ----------
    surface : Surface
        An object with the method `heights`.

    Returns
    -------
    Topography
        The same object if it is a `Topography`. Of another class the attributes and
        methods with the names of `Topography` are used, its `radius` and
        `short_wavelength`, and its `roughness`.
    """
    return surface if isinstance(surface, Topography) else Adapted(surface)


def _delegated(name: str, other: str = "") -> Any:
    """Return a property: an attribute of the surface, by default of `Topography`."""

    def value(adapted: Adapted) -> Any:
        default = getattr(super(Adapted, adapted), name)
        return getattr(adapted.surface, other or name, default)

    return property(value)


@dataclass(frozen=True)
class Adapted(Topography):
    """A surface of a class that is not derived from `Topography`."""

    surface: Any

    apex_radius = _delegated("apex_radius", "radius")
    shortest_wavelength = _delegated("shortest_wavelength", "short_wavelength")
    profile = _delegated("profile")
    extent = _delegated("extent")
    middle_extent = _delegated("middle_extent")
    repeats = _delegated("repeats")
    periods = _delegated("periods")
    side = _delegated("side")
    longest_wavelength = _delegated("longest_wavelength")
    pixel = _delegated("pixel")
    seed = _delegated("seed")
    mean_height = _delegated("mean_height")
    edge_change = _delegated("edge_change")
    statistics = _delegated("statistics")
    lowest = _delegated("lowest")
    reach = _delegated("reach")
    band_limited = _delegated("band_limited")
    todict = _delegated("todict")

    def heights(
        self, shape: Shape, spacing: float, origin: Point = (0.0, 0.0)
    ) -> FloatArray:
        """Sample the heights on a grid; see `Surface.heights`."""
        return self.surface.heights(shape, spacing, origin)

    @property
    def rough(self) -> Topography:
        """Roughness on a sphere; the surface itself if it is no sphere."""
        rough = getattr(self.surface, "roughness", self.surface)
        if rough is None:
            return Plane()
        return self if rough is self.surface else topography_of(rough)

    def __repr__(self) -> str:
        """Return the representation of the surface."""
        return repr(self.surface)
