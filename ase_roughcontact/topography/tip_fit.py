"""Radius of curvature of a scanned tip, by a fit around its lowest point."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ase_roughcontact._util.validation import FloatArray, Point
from ase_roughcontact.topography.levelling import polynomial

# Largest radius of the fitted disc over the radius of curvature: the contact is there.
_PART_OF_RADIUS = 0.5
# Smallest radius of the fitted disc, in steps of the map, and number of fits.
_LEAST_STEPS, _FITS = 4, 4
# Share of the variance above which the shape of a scan is that of a tip.
_SHARE_OF_A_TIP = 0.7


@dataclass(frozen=True)
class TipFit:
    """Paraboloid or sphere around the lowest point of a height map.

    Attributes
    ----------
    radius : float
        Radius of curvature; infinity if the map isn't convex there (length).
    share : float
        Share of the variance of the heights that a paraboloid explains around this
        point, up to the nearest edge of the map, or a polynomial of second degree on
        the whole map, if that is less.
    """

    radius: float = math.inf
    share: float = 0.0

    @property
    def is_tip(self) -> bool:
        """Whether the curvature is more than that of a rough flat surface."""
        return self.radius < math.inf and self.share > _SHARE_OF_A_TIP

    @classmethod
    def of(cls, heights: FloatArray, spacing: Point) -> TipFit:
        """Fit a paraboloid with the same curvature along x and y, and a sphere.

        They are fitted in a disc around the lowest point of the heights, shape (n, m),
        as large as the map allows, and at most half as wide as the radius of curvature
        in it. The radius is that of the better fit.
        """
        i, j = np.unravel_index(np.argmin(heights), heights.shape)
        x = spacing[0] * (np.arange(heights.shape[0], dtype=float) - i)
        y = spacing[1] * (np.arange(heights.shape[1], dtype=float) - j)
        widest = float(min(-x[0], x[-1], -y[0], y[-1]))
        least = _LEAST_STEPS * max(spacing)
        if widest < least:
            return cls()
        first, share = _fit(heights, x, y, widest)
        fits = []
        for is_sphere in (False, True):
            curvature, explained = first, 0.0
            for _ in range(_FITS):
                if curvature <= 0.0:
                    return cls()
                disc = max(least, min(widest, _PART_OF_RADIUS / curvature))
                bend = curvature if is_sphere else 0.0
                curvature, explained = _fit(heights, x, y, disc, bend)
            fits.append((explained, curvature))
        _explained, curvature = max(fits)
        if curvature <= 0.0:
            return cls()
        rest = heights - polynomial(heights, 2)
        whole = 1.0 - float(rest.var() / heights.var())
        return cls(1.0 / curvature, min(share, whole))


def _fit(
    heights: FloatArray,
    x: NDArray[Any],
    y: NDArray[Any],
    disc: float,
    bend: float = 0.0,
) -> tuple[float, float]:
    """Return the curvature at the apex, and the share of the variance in a disc.

    The shape is that of a sphere of the curvature `bend`, scaled, or for zero of a
    paraboloid.
    """
    x, y = np.meshgrid(x, y, indexing="ij")
    inside = x**2 + y**2 <= disc**2
    x, y = x[inside], y[inside]
    square = x**2 + y**2
    shape = square / (1.0 + np.sqrt(np.maximum(1.0 - bend**2 * square, 0.0)))
    matrix = np.stack([np.ones(len(x)), x, y, shape], axis=1)
    scale = np.abs(matrix).max(axis=0)
    values = heights[inside]
    found, *_ = np.linalg.lstsq(matrix / scale, values, rcond=None)
    variance = float(values.var())
    rest = float((values - matrix / scale @ found).var())
    return float(found[3] / scale[3]), 1.0 - rest / variance if variance else 0.0
