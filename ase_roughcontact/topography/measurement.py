"""A scan as the lower side of an indenter: noise, filter, and copies with its errors.

A copy has half the pixels, as much noise again, or edges that fit each other.
`results.scan_errors` presses them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import ndimage

from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import FloatArray, Point
from ase_roughcontact.topography.interpolation import interpolated
from ase_roughcontact.topography.noise import Noise
from ase_roughcontact.topography.spectrum import (
    Statistics,
    has_edge_step,
    power_spectrum,
    pressed_statistics,
    smooth_component,
)

# Largest rms slope of noise that is neglected, relative to the rms slope of the map.
_MAX_NEGLECTED_SLOPE = 1e-3
# Fewest points along a side, for the interpolation.
_MIN_POINTS = 4
# Standard deviation of the Gaussian filter in units of the cutoff wavelength: a half of
# a wave of this length is transmitted (ISO 16610-61).
_FILTER_WIDTH = math.sqrt(math.log(2.0) / 2.0) / math.pi
# Pixels of a wave at which the spectrum of noise is still flat. Where waves between
# pixels looked like noise it was flat up to 3.0 of them, and with noise on waves of
# four pixels up to 3.7 (examples/benchmarks/scan_errors.py).
_MIN_PIXELS_PER_WAVE = 3.5
#: Number of noisy copies.
NOISY = 4
#: Number of successive halvings of the number of pixels.
HALVINGS = 2


class ScanWarning(UserWarning):
    """A doubt about a scan that was read."""


@dataclass(frozen=True, eq=False)
class Measurement(Summarized):
    """Heights of the lower side of a scan before it was filtered, and their noise.

    Attributes
    ----------
    heights : ndarray, shape (n, m)
        Heights, positive upward (length).
    spacing : (float, float)
        Distance of the pixels along x and y (length).
    periodic : bool
        Whether the scan is periodic.
    noise : Noise
        Noise of the heights.
    cutoff : float
        Cutoff wavelength of the filter; zero for none (length).
    missing, outliers : int
        Numbers of points that were not measured, and that are outliers.
    doubts : tuple of str
        Faults of lines of the scan, each with advice.
    margin : float
        Distance from the edges within which no lowest point is sought (length).
    strain : float
        Relative change of distances along y, for a grid of squares.
    """

    heights: FloatArray
    spacing: Point
    periodic: bool
    noise: Noise
    cutoff: float = 0.0
    missing: int = 0
    outliers: int = 0
    doubts: tuple[str, ...] = ()
    margin: float = 0.0
    strain: float = 0.0

    @cached_property
    def pressed(self) -> FloatArray:
        """The heights without short waves, by a Gaussian filter (ISO 16610-61).

        It transmits a half of the height of a wave of the cutoff wavelength.
        """
        if not self.cutoff:
            return self.heights
        width = [_FILTER_WIDTH * self.cutoff / step for step in self.spacing]
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

        Without the slope of noise, if it is not roughness.
        """
        if not self.cutoff:
            return 0.0
        before = replace(self, cutoff=0.0)._square_slope_of_surface
        after = self._square_slope_of_surface
        return 1.0 - math.sqrt(max(after, 0.0) / before) if before > after else 0.0

    @property
    def _square_slope_of_surface(self) -> float:
        """Mean square slope without the noise, if the noise is distinct."""
        square = self.statistics.rms_slope**2
        return square - self.noise_slope**2 if self.noise_is_distinct else square

    def copies(self) -> dict[str, list[Measurement]]:
        """Return copies that show the errors of the scan.

        "coarser" ones have half and a quarter of the pixels along each side, "noisy"
        ones as much noise again, none if there is hardly any, and "seamless" ones edges
        that fit each other, where they should and do not.
        """
        noisy, seamless, pressed = [], [], self.pressed
        if self.noise_slope > _MAX_NEGLECTED_SLOPE * self.statistics.rms_slope:
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
        least = _MIN_PIXELS_PER_WAVE * max(self.spacing)
        return not self.noise.points or self.least_wavelength > least

    @cached_property
    def least_wavelength(self) -> float:
        """Wavelength below which the heights are mostly noise (length).

        It is the first one, from the largest value of the power spectrum on, at which
        the spectrum is below twice the spectrum of the noise.
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
            for axis in (0, 1):
                n, step = self.heights.shape[axis], self.spacing[axis]
                last = 0 if self.periodic else 1
                count = (n - last) // 2**halving
                if count + last < _MIN_POINTS:
                    return
                places = np.linspace(0.0, n - last, count + 1)[: count + last]
                values = interpolated(values, places, axis, self.periodic)
                spacing.append(step * (n - last) / count)
            x, y = spacing
            yield replace(self, heights=values, spacing=(x, y))
