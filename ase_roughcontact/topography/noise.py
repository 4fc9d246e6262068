"""Noise of the heights of a scan, and outliers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ase_roughcontact._util.validation import FloatArray, Shape

# Order of the differences that noise is estimated from, and the sum of the squares of
# their coefficients: waves of four pixels contribute a hundredth of their height.
_ORDER = 4
_SQUARES = math.comb(2 * _ORDER, _ORDER)
# Standard deviation of normal numbers over the median of their magnitudes.
_PER_MEDIAN = 1.4826
# An outlier is farther from the median of its neighbours than these multiples of the
# standard deviation of this distance, and of the range of the neighbours.
_FAR, _RANGES = 6.0, 2.0


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the noise of a scan.

    Attributes
    ----------
    points : float
        Standard deviation of each height, independent of the others (length).
    lines : float
        Standard deviation of the offset of each line along x, such as by drift
        (length).
    """

    points: float = 0.0
    lines: float = 0.0

    @classmethod
    def of(cls, heights: FloatArray) -> Noise:
        """Estimate the noise of heights, shape (n, m), NaN at missing points.

        The noise of points is at most the estimate: it follows from differences of
        fourth order along x and y, to which waves longer than a few pixels hardly
        contribute. The noise of lines is the excess of the differences of the means of
        lines along x over lines along y, if they had as many points.
        """
        if min(heights.shape) <= _ORDER:
            return cls()
        along_x = np.diff(heights, _ORDER, axis=0)
        along_y = np.diff(heights, _ORDER, axis=1)
        points = deviation(np.diff(along_x, _ORDER, axis=1)) / _SQUARES
        x, y = (deviation(_means(d, axis)) for axis, d in ((1, along_x), (0, along_y)))
        of_points = x**2 * heights.shape[1] / heights.shape[0]
        lines = math.sqrt(max(y**2 - of_points, 0.0) / _SQUARES)
        return cls(points, lines)

    def sample(self, shape: Shape, seed: int) -> FloatArray:
        """Return a realisation of the noise (length)."""
        rng = np.random.default_rng(seed)
        lines = self.lines * rng.standard_normal(shape[1])
        return self.points * rng.standard_normal(shape) + lines


def outliers(heights: FloatArray) -> NDArray[np.bool_]:
    """Return which points, of heights of shape (n, m), are outliers."""
    around = np.ones((3, 3), bool)
    around[1, 1] = False
    middle = ndimage.median_filter(heights, footprint=around)
    highest = ndimage.maximum_filter(heights, footprint=around)
    lowest = ndimage.minimum_filter(heights, footprint=around)
    far = abs(heights - middle)
    return far > np.maximum(_FAR * deviation(far), _RANGES * (highest - lowest))


def deviation(values: NDArray[Any]) -> float:
    """Return the standard deviation about zero, hardly changed by outliers."""
    known = values[~np.isnan(values)]
    return _PER_MEDIAN * float(np.median(abs(known))) if known.size else 0.0


def _means(values: FloatArray, axis: int) -> FloatArray:
    known = ~np.isnan(values)
    return np.nansum(values, axis) / np.maximum(known.sum(axis), 1)
