"""Noise of the heights of a scan, and outliers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from ase_roughcontact._util.validation import FloatArray, Shape

# Order of the differences that noise is estimated from: waves of four pixels contribute
# a hundredth of their height.
_DIFFERENCE_ORDER = 4
# Sum of the squares of the coefficients of these differences.
_SUM_OF_SQUARES = math.comb(2 * _DIFFERENCE_ORDER, _DIFFERENCE_ORDER)
# Standard deviation of normal numbers over the median of their magnitudes.
_DEVIATION_PER_MEDIAN = 1.4826
# Least distance of an outlier from the median of its neighbours, in its deviation.
_OUTLIER_DEVIATIONS = 6.0
# Least distance of an outlier from the median of its neighbours, in their range.
_OUTLIER_RANGES = 2.0


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
        if min(heights.shape) <= _DIFFERENCE_ORDER:
            return cls()
        along_x = np.diff(heights, _DIFFERENCE_ORDER, axis=0)
        along_y = np.diff(heights, _DIFFERENCE_ORDER, axis=1)
        points = (
            deviation(np.diff(along_x, _DIFFERENCE_ORDER, axis=1)) / _SUM_OF_SQUARES
        )
        x, y = deviation(_means(along_x, 1)), deviation(_means(along_y, 0))
        of_points = x**2 * heights.shape[1] / heights.shape[0]
        lines = math.sqrt(max(y**2 - of_points, 0.0) / _SUM_OF_SQUARES)
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
    least = _OUTLIER_DEVIATIONS * deviation(far)
    return far > np.maximum(least, _OUTLIER_RANGES * (highest - lowest))


def deviation(values: NDArray[Any]) -> float:
    """Return the standard deviation about zero, hardly changed by outliers."""
    known = values[~np.isnan(values)]
    return _DEVIATION_PER_MEDIAN * float(np.median(abs(known))) if known.size else 0.0


def _means(values: FloatArray, axis: int) -> FloatArray:
    known = ~np.isnan(values)
    return np.nansum(values, axis) / np.maximum(known.sum(axis), 1)
