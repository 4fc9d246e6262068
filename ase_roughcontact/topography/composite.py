"""Roughness of two bodies as the roughness of one: heights are added."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import chain
from typing import Any, NamedTuple

import numpy as np

from ase_roughcontact._util.rounding import LENGTH_ROUNDING, RATIO_ROUNDING
from ase_roughcontact._util.validation import FloatArray, Point, Shape
from ase_roughcontact._util.validation import surface as check_surface
from ase_roughcontact.theory.self_affine import band_of, numbers_of
from ase_roughcontact.topography.base import Surface
from ase_roughcontact.topography.self_affine_fit import SelfAffineFit
from ase_roughcontact.topography.spectrum import Statistics
from ase_roughcontact.topography.topography import Adapted, Topography, topography_of


def _same(name: str) -> Any:
    """Return a property: an attribute of the surface."""
    return property(lambda inverted: getattr(inverted.surface, name))


@dataclass(frozen=True)
class Inverted(Adapted):
    """Surface with reversed heights.

    The heights of a substrate, positive out of it, become the lower side of an indenter
    on a flat substrate.

    Parameters
    ----------
    surface : Surface
        Heights of the substrate (length).

    Raises
    ------
    ValueError
        If the surface has no method `heights`.
    """

    rms_slope = _same("rms_slope")
    hurst = _same("hurst")
    short_wavelength = _same("short_wavelength")
    long_wavelength = _same("long_wavelength")

    @property
    def anisotropy(self) -> float:
        """Ratio of wavelengths along a direction and across, for theory."""
        return getattr(self.surface, "anisotropy", 1.0)

    def __post_init__(self) -> None:
        """Check the surface."""
        check_surface(surface=self.surface)

    @property
    def parts(self) -> tuple[Topography, ...]:
        """Surfaces of which the heights are reversed."""
        return topography_of(self.surface).parts

    def heights(
        self, shape: Shape, spacing: float, origin: Point = (0.0, 0.0)
    ) -> FloatArray:
        """Sample the reversed heights on a grid; see `Surface.heights`."""
        return -self.surface.heights(shape, spacing, origin)

    @property
    def shortest_wavelength(self) -> float:
        """Shortest wavelength of the heights; NaN if it is not known (length)."""
        return topography_of(self.surface).shortest_wavelength

    @property
    def mean_height(self) -> float:
        """Mean of the reversed heights (length)."""
        return -topography_of(self.surface).mean_height

    def lowest(self, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return the lowest height of a period on a grid; else -infinity (length)."""
        if not np.isfinite(self.periods).all():
            return -math.inf
        x, y = (round(math.remainder(each / spacing, 1.0), 12) for each in origin)
        return _lowest_of_period(self, spacing, x, y)

    def reach(self, level: float, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Raise `ValueError`: the roughness of a substrate has no end."""
        return Topography.reach(self, level, spacing, origin)

    def band_limited(self, shortest: float) -> Inverted:
        """Return the surface without its waves shorter than a wavelength (length)."""
        return Inverted(topography_of(self.surface).band_limited(shortest))

    def points(self, spacing: float) -> int:
        """Return the number of points on which the roughness is synthesised."""
        return topography_of(self.surface).points(spacing)

    def todict(self) -> dict[str, Any]:
        """Return the name and the surface."""
        return {"name": "Inverted", "surface": topography_of(self.surface).todict()}

    def __repr__(self) -> str:
        """Return the class and the surface."""
        return f"Inverted({self.surface!r})"


@dataclass(frozen=True)
class CompositeRoughness(Topography):
    r"""Sum of the roughness of two bodies, or more.

    The gap between a rough tip and a rough substrate depends on the difference of their
    heights alone,

    .. math:: g_0(x, y) = h_\mathrm{tip}(x, y) - h_\mathrm{substrate}(x, y),

    so that both are pressed as one rough tip on a flat substrate, with the contact
    modulus :math:`1/E^* = 1/E_1^* + 1/E_2^*`.

    Parameters
    ----------
    surfaces : sequence of Surface
        Roughness of each body as the lower side of an indenter: of a substrate the
        reversed heights, as `HeightMap.from_topography` returns them with the role
        "substrate", or `Inverted`. A window may not exceed the period or the map of any
        of them. Each one is sampled on the grid, so that pixels and periods may differ.

    Raises
    ------
    ValueError
        If there are fewer than two surfaces, or one has no method `heights`.

    Notes
    -----
    Mean squares of heights, slopes and curvatures are the sums over the surfaces, as of
    independent ones; single realisations differ from it, most in the rms height, to
    which few waves contribute. Theory is evaluated for a self-affine surface with these
    statistics. Its Hurst exponent is the mean, weighted by mean square slopes.

    References
    ----------
    J. A. Greenwood, J. H. Tripp, Proc. Inst. Mech. Eng. 185, 625 (1970). K. L. Johnson,
    Contact Mechanics (Cambridge, 1985), section 4.1: the composite of two bodies.

    Examples
    --------
    >>> from ase_roughcontact import CompositeRoughness, Inverted, RoughSphere
    >>> from ase_roughcontact import SelfAffine
    >>> tip = SelfAffine(0.03, 0.8, short_wavelength=4.0, long_wavelength=16.0, seed=1)
    >>> base = SelfAffine(0.04, 0.8, short_wavelength=4.0, long_wavelength=16.0, seed=2)
    >>> both = CompositeRoughness([tip, Inverted(base)])
    >>> round(both.rms_slope, 6)
    0.05
    >>> RoughSphere(100.0, both).heights((4, 4), 1.0).shape
    (4, 4)
    """

    surfaces: Sequence[Surface]

    def __post_init__(self) -> None:
        """Check the surfaces."""
        object.__setattr__(self, "surfaces", tuple(self.surfaces))
        if len(self.surfaces) < 2:
            raise ValueError(
                "surfaces must be the roughness of two bodies or more, got "
                f"{len(self.surfaces)}"
            )
        for each in self.surfaces:
            check_surface(surfaces=each)

    @cached_property
    def _each(self) -> tuple[Topography, ...]:
        return tuple(map(topography_of, self.surfaces))

    @property
    def parts(self) -> tuple[Topography, ...]:
        """Surfaces of all bodies; heights of a substrate may be reversed."""
        return tuple(chain.from_iterable(each.parts for each in self._each))

    def replaced(self, old: Surface, new: Surface) -> CompositeRoughness:
        """Return the sum with another surface in place of one."""
        surfaces = [new if each is old else each for each in self.surfaces]
        return CompositeRoughness(surfaces)

    def heights(
        self, shape: Shape, spacing: float, origin: Point = (0.0, 0.0)
    ) -> FloatArray:
        """Sample the sum of the heights on a grid; see `Surface.heights`.

        Raises
        ------
        ValueError
            If one of the surfaces can't be sampled on the grid.
        """
        first, *others = self.surfaces
        heights = np.array(first.heights(shape, spacing, origin), dtype=float)
        for each in others:
            heights += each.heights(shape, spacing, origin)
        return heights

    @property
    def extent(self) -> float:
        """Distance from the axis up to which the heights of all are known (length)."""
        return min(each.extent for each in self._each)

    @property
    def middle_extent(self) -> float:
        """The extent if the middle of each map is on the axis (length)."""
        return min(each.middle_extent for each in self._each)

    @property
    def repeats(self) -> bool:
        """Whether all surfaces are periodic beyond the extent."""
        return all(each.repeats for each in self._each)

    @property
    def periods(self) -> Point:
        """Common periods along x and y; infinity without one (length)."""
        x, y = ([each.periods[axis] for each in self._each] for axis in (0, 1))
        return _common(x), _common(y)

    def part_of_period(self, sides: np.ndarray) -> float:
        """Return the smallest ratio of a side of a cell and a period of a surface."""
        ratios = [each.part_of_period(sides) for each in self._each]
        return float(np.fmin.reduce(ratios))

    @property
    def shortest_wavelength(self) -> float:
        """Shortest wavelength of all; NaN if none is known (length)."""
        return float(np.fmin.reduce([each.shortest_wavelength for each in self._each]))

    @property
    def pixel(self) -> float:
        """Largest distance between the points of a scan; NaN without one (length)."""
        return float(np.fmax.reduce([each.pixel for each in self._each]))

    @property
    def seed(self) -> int | None:
        """Seed of the first random surface; None without one."""
        seeds = (each.seed for each in self._each if each.seed is not None)
        return next(seeds, None)

    @property
    def mean_height(self) -> float:
        """Sum of the mean heights (length)."""
        return sum(each.mean_height for each in self._each)

    @property
    def edge_change(self) -> float:  # type: ignore[override]
        """Rms height that was subtracted to make scans periodic (length)."""
        return math.hypot(*(each.edge_change for each in self._each))

    def statistics(self) -> Statistics:
        """Return the rms height, slope and curvature of independent surfaces."""
        found = [each.statistics() for each in self._each]
        return Statistics(
            math.hypot(*(each.rms_height for each in found)),
            math.hypot(*(each.rms_slope for each in found)),
            math.hypot(*(each.rms_curvature for each in found)),
        )

    def lowest(self, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return the sum of the lower bounds of all surfaces (length)."""
        return sum(each.lowest(spacing, origin) for each in self._each)

    def reach(self, level: float, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return where one surface is high enough above the lowest heights of others.

        See `BoundedSurface.reach`.

        Raises
        ------
        ValueError
            If no surface rises with the distance from the axis, as a scanned tip does.
        """
        for tip in self._each:
            if not tip.repeats:
                others = (each for each in self._each if each is not tip)
                lowest = sum(each.lowest(spacing, origin) for each in others)
                return tip.reach(level - lowest, spacing, origin)
        return super().reach(level, spacing, origin)

    def band_limited(self, shortest: float) -> CompositeRoughness:
        """Return the sum without waves shorter than a wavelength (length).

        Raises
        ------
        ValueError
            If the waves of a surface are not known, or all of them are shorter.
        """
        return CompositeRoughness([each.band_limited(shortest) for each in self._each])

    def points(self, spacing: float) -> int:
        """Return the number of points on which the surfaces are synthesised."""
        return sum(each.points(spacing) for each in self._each)

    @property
    def rms_slope(self) -> float:
        """Rms slope of independent surfaces."""
        return self.statistics().rms_slope

    @property
    def anisotropy(self) -> float:
        """Ratio of wavelengths along a direction and across, if it is the same of all.

        Else it is one: the statistics then follow from the wavelengths.
        """
        return self._spectra[0].anisotropy if len(self._spectra) == 1 else 1.0

    @property
    def hurst(self) -> float:
        """Mean Hurst exponent, weighted by mean square slopes."""
        slopes, exponents, _ = zip(*map(numbers_of, self._rough()), strict=True)
        return float(np.average(exponents, weights=np.square(slopes)))

    @property
    def short_wavelength(self) -> float:
        """Lower end of the self-affine range for theory (length)."""
        return self._band[0]

    @property
    def long_wavelength(self) -> float:
        """Upper end of the self-affine range for theory (length)."""
        return self._band[1]

    @property
    def longest_wavelength(self) -> float | None:
        """End of the roll-off, if it is the same of all; else None (length)."""
        return self._band[2]

    @cached_property
    def _band(self) -> tuple[float, float, float | None]:
        """Ends of the range: the same of all, or ones that fit the statistics."""
        if len(self._spectra) == 1:
            return self._spectra[0].band
        longest = max(each.longest for each in self._spectra)
        fit = SelfAffineFit.with_hurst(self.statistics(), self.hurst, longest)
        return fit.short_wavelength, fit.long_wavelength, None

    @cached_property
    def _spectra(self) -> list[_Spectrum]:
        """Different spectra of the surfaces that are not planes."""
        spectra = (
            _Spectrum(getattr(each, "anisotropy", 1.0), each.hurst, band_of(each))
            for each in self._rough()
        )
        return list(dict.fromkeys(spectra))

    def _rough(self) -> Iterator[Any]:
        """Yield the surfaces that are not planes."""
        for each, surface in zip(self._each, self.surfaces, strict=True):
            if each.statistics().rms_slope != 0.0:
                yield surface

    def todict(self) -> dict[str, Any]:
        """Return the name and the surfaces."""
        return {
            "name": "CompositeRoughness",
            "surfaces": [each.todict() for each in self._each],
        }


class _Spectrum(NamedTuple):
    """Parameters of a self-affine spectrum without its amplitude.

    The band has the ends of the self-affine range, and the end of the roll-off or None.
    """

    anisotropy: float
    hurst: float
    band: tuple[float, float, float | None]

    @property
    def longest(self) -> float:
        """Longest wavelength (length)."""
        _, long, longest = self.band
        return self.anisotropy * (longest or long)


def _common(periods: Sequence[float]) -> float:
    """Return the period of all surfaces; infinity without a common one."""
    first = periods[0]
    if all(math.isclose(first, each, rel_tol=RATIO_ROUNDING) for each in periods):
        return first
    return math.inf


@lru_cache(maxsize=16)
def _lowest_of_period(surface: Inverted, spacing: float, x: float, y: float) -> float:
    """Return the lowest height of a period on a grid shifted by (x, y) steps."""
    shape = [math.floor(side / spacing + LENGTH_ROUNDING) for side in surface.periods]
    origin = x * spacing, y * spacing
    return float(surface.heights((shape[0], shape[1]), spacing, origin).min())
