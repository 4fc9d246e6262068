"""A scan as the lower side of an indenter: noise, filter, and copies with its errors.

A copy has half the pixels, as much noise again, or edges that fit each other.
`paths.scan_errors` presses them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ase_roughcontact._util.validation import FloatArray, Point, Shape
from ase_roughcontact.topography.interpolation import interpolated
from ase_roughcontact.topography.spectrum import (
    Statistics,
    has_edge_step,
    power_spectrum,
    pressed_statistics,
    smooth_component,
)

# Order of the differences that noise is estimated from, and the sum of the squares of
# their coefficients: waves of four pixels contribute a hundredth of their height.
_ORDER = 4
_SQUARES = math.comb(2 * _ORDER, _ORDER)
# Standard deviation of normal numbers over the median of their magnitudes.
_PER_MEDIAN = 1.4826
# An outlier is farther from the median of its neighbours than these multiples of the
# standard deviation of this distance, and of the range of the neighbours.
_FAR, _RANGES = 6.0, 2.0
# Noise is neglected if its rms slope is below this part of that of the map.
_LEAST_NOISE = 1e-3
# Fewest points along a side, for the interpolation.
_LEAST_POINTS = 4
# Standard deviation of the Gaussian filter in units of the cutoff wavelength, of which
# it transmits a half (ISO 16610-61).
_DEVIATION = math.sqrt(math.log(2.0) / 2.0) / math.pi
# Pixels of a wave at which the spectrum of noise is still flat. Where waves between
# pixels looked like noise it was flat up to 3.0 of them, and with noise on waves of
# four pixels up to 3.7 (examples/benchmarks/scan_errors.py).
_DISTINCT = 3.5
#: Numbers of noisy copies, and of successive halvings of the number of pixels.
NOISY, HALVINGS = 4, 2


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the noise of a scan.

    Attributes
    ----------
    points : float
        Of each height, independent of the others (length).
    lines : float
        Of the offset of each line along x, such as by drift (length).
    """

    points: float = 0.0
    lines: float = 0.0

    @classmethod
    def of(cls, heights: FloatArray) -> Noise:
        """Estimate the noise of heights, shape (n, m), NaN at missing points.

        That of points is at most the estimate: it follows from differences of fourth
        order along x and y, to which waves longer than a few pixels hardly contribute.
        That of lines is by how much more the means of lines along x differ than those
        along y would, if they had as many points.
        """
        if min(heights.shape) <= _ORDER:
            return cls()
        along_x = np.diff(heights, _ORDER, axis=0)
        along_y = np.diff(heights, _ORDER, axis=1)
        points = _deviation(np.diff(along_x, _ORDER, axis=1)) / _SQUARES
        x, y = (_deviation(_means(d, axis)) for axis, d in ((1, along_x), (0, along_y)))
        of_points = x**2 * heights.shape[1] / heights.shape[0]
        lines = math.sqrt(max(y**2 - of_points, 0.0) / _SQUARES)
        return cls(points, lines)

    def sample(self, shape: Shape, seed: int) -> FloatArray:
        """Return a realisation of the noise (length)."""
        rng = np.random.default_rng(seed)
        lines = self.lines * rng.standard_normal(shape[1])
        return self.points * rng.standard_normal(shape) + lines


@dataclass(frozen=True, eq=False)
class Measurement:
    """Heights of the lower side of a scan before it was filtered, and their noise.

    Attributes
    ----------
    heights : ndarray, shape (n, m)
        Length.
    spacing : (float, float)
        Of the pixels along x and y (length).
    periodic : bool
    noise : Noise
    cutoff : float
        Cutoff wavelength of the filter; zero for none (length).
    missing, outliers : int
        Numbers of points that were not measured, and that are outliers.
    """

    heights: FloatArray
    spacing: Point
    periodic: bool
    noise: Noise
    cutoff: float = 0.0
    missing: int = 0
    outliers: int = 0

    @cached_property
    def pressed(self) -> FloatArray:
        """The heights without short waves, by a Gaussian filter (ISO 16610-61).

        It transmits a half of the height of a wave of the cutoff wavelength.
        """
        if not self.cutoff:
            return self.heights
        width = [_DEVIATION * self.cutoff / step for step in self.spacing]
        mode = "wrap" if self.periodic else "reflect"
        return ndimage.gaussian_filter(self.heights, width, mode=mode)

    @cached_property
    def statistics(self) -> Statistics:
        """Rms height, slope and curvature after the filter; `pressed_statistics`."""
        return pressed_statistics(self.pressed, self.spacing, self.periodic)

    @cached_property
    def noise_slope(self) -> float:
        """Rms slope of the noise as it is pressed."""
        noise = next(self.noisy()).pressed - self.pressed
        return pressed_statistics(noise, self.spacing, self.periodic).rms_slope

    @cached_property
    def lost_slope(self) -> float:
        """Part of the rms slope that the filter removed.

        Without that of noise, if it is not roughness.
        """
        if not self.cutoff:
            return 0.0
        before, after = (
            each.statistics.rms_slope**2 - each.noise_is_distinct * each.noise_slope**2
            for each in (replace(self, cutoff=0.0), self)
        )
        return 1.0 - math.sqrt(max(after, 0.0) / before) if before > after else 0.0

    def copies(self) -> dict[str, list[Measurement]]:
        """Return copies that show the errors of the scan.

        "coarser" ones have half and a quarter of the pixels along each side, "noisy"
        ones as much noise again, none if there is hardly any, and "seamless" ones edges
        that fit each other, where they should and do not.
        """
        noisy, seamless, pressed = [], [], self.pressed
        if self.noise_slope > _LEAST_NOISE * self.statistics.rms_slope:
            noisy = list(self.noisy())
        if self.periodic and has_edge_step(pressed):
            heights = pressed - smooth_component(pressed)
            seamless = [replace(self, heights=heights, cutoff=0.0)]
        return {"coarser": list(self.coarser()), "noisy": noisy, "seamless": seamless}

    def noisy(self) -> Iterator[Measurement]:
        """Yield copies with as much noise again as there is."""
        for seed in range(NOISY):
            noise = self.noise.sample(self.heights.shape, seed)
            yield replace(self, heights=self.heights + noise)

    @property
    def noise_is_distinct(self) -> bool:
        """Whether the noise is certainly none, or more than waves of a few pixels.

        Waves between the pixels, which a scan can't show, look like noise, but the
        spectrum of longer ones is larger.
        """
        least = _DISTINCT * max(self.spacing)
        return not self.noise.points or self.least_wavelength > least

    @cached_property
    def least_wavelength(self) -> float:
        """Wavelength below which the heights are mostly noise (length).

        From the largest value of the power spectrum on, the first that is below twice
        that of the noise.
        """
        without_lines = self.heights - self.heights.mean(axis=0)
        q, density = power_spectrum(without_lines, self.spacing, periodic=False)
        noise = self.noise.points**2 * math.prod(self.spacing)
        q, density = q[density.argmax() :], density[density.argmax() :]
        return 2.0 * math.pi / float(np.append(q[density < 2.0 * noise], q[-1])[0])

    def coarser(self) -> Iterator[Measurement]:
        """Yield copies with half as many pixels and a quarter.

        Both are sampled between the same edges, where that needs it by interpolation.
        """
        for halving in range(1, HALVINGS + 1):
            values, spacing = self.heights, []
            for axis, (n, step) in enumerate(
                zip(self.heights.shape, self.spacing, strict=True)
            ):
                last = 0 if self.periodic else 1
                count = (n - last) // 2**halving
                if count + last < _LEAST_POINTS:
                    return
                places = np.linspace(0.0, n - last, count + 1)[: count + last]
                values = interpolated(values, places, axis, self.periodic)
                spacing.append(step * (n - last) / count)
            x, y = spacing
            yield replace(self, heights=values, spacing=(x, y))


def outliers(heights: FloatArray) -> NDArray[np.bool_]:
    """Return which points, of heights of shape (n, m), stick out far alone."""
    around = np.ones((3, 3), bool)
    around[1, 1] = False
    middle = ndimage.median_filter(heights, footprint=around)
    highest = ndimage.maximum_filter(heights, footprint=around)
    lowest = ndimage.minimum_filter(heights, footprint=around)
    far = abs(heights - middle)
    return far > np.maximum(_FAR * _deviation(far), _RANGES * (highest - lowest))


def _deviation(values: NDArray[Any]) -> float:
    """Return the standard deviation about zero, hardly changed by outliers."""
    known = values[~np.isnan(values)]
    return _PER_MEDIAN * float(np.median(abs(known))) if known.size else 0.0


def _means(values: FloatArray, axis: int) -> FloatArray:
    known = ~np.isnan(values)
    return np.nansum(values, axis) / np.maximum(known.sum(axis), 1)
