"""Radius of curvature of a scanned tip, by a fit around its lowest point."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import FloatArray, Point
from ase_roughcontact.topography.levelling import polynomial
from ase_roughcontact.topography.pressed_scan import highest

# Largest radius of the fitted disc over the radius of curvature: the contact is there.
_DISC_TO_RADIUS = 0.5
# Smallest radius of the fitted disc, in steps of the map.
_MIN_DISC_STEPS = 4
# Number of fits, each on the disc of the radius before.
_FITS = 4
# Number of sectors of the disc; each one is left out in turn for the error.
_SECTORS = 8
# Least share of the variance that the shape of a tip explains.
_MIN_TIP_SHARE = 0.7
# Largest relative error of the curvature of a tip.
_MAX_TIP_ERROR = 0.5
# Slope below which a scan may also be a flat with the bow of a scanner.
_MAX_BOW_SLOPE = 0.1
# Largest ratio of the curvatures at the lowest point and of the whole map of a tip that
# is as flat as a bow.
_MAX_CURVATURE_RATIO = 2.0


@dataclass(frozen=True)
class TipFit:
    """Paraboloid or sphere around the lowest point of a height map.

    Attributes
    ----------
    radius : float
        Radius of curvature; infinity if the map isn't convex there (length).
    share : float
        Share of the variance of the heights about a plane that a paraboloid explains
        around this point, up to the nearest edge of the map, or a polynomial of second
        degree on the whole map, if that is less.
    error : float
        Relative standard error of the curvature, from fits without one sector of the
        disc each, which shows roughness and unequal curvatures along x and y, and from
        the difference of paraboloid and sphere, as far as both fit.
    whole : float
        Mean curvature of the polynomial over the curvature at the lowest point.
    rise : float
        Mean slope of the polynomial from the middle of the map to the middles of its
        edges.
    at_edge : bool
        Whether the lowest point is too close to an edge for a fit.
    """

    radius: float = math.inf
    share: float = 0.0
    error: float = math.nan
    whole: float = 0.0
    rise: float = 0.0
    at_edge: bool = False

    @property
    def is_tip(self) -> bool:
        """Whether the map is more curved than a rough flat surface."""
        if not (self.radius < math.inf and self.share > _MIN_TIP_SHARE):
            return False
        agree = 1.0 / _MAX_CURVATURE_RATIO < self.whole < _MAX_CURVATURE_RATIO
        return self.error < _MAX_TIP_ERROR and (agree or not self.may_be_bow)

    @property
    def may_be_bow(self) -> bool:
        """Whether the map is as flat as a scan of a flat with the bow of a scanner."""
        return self.rise < _MAX_BOW_SLOPE

    @classmethod
    def of(cls, heights: FloatArray, spacing: Point, margin: float = 0.0) -> TipFit:
        """Fit a paraboloid with the same curvature along x and y, and a sphere.

        They are fitted in a disc around the lowest point of the heights, shape (n, m),
        that is a margin from the edges (length). The disc is as large as the map
        allows, and at most half as wide as the radius of curvature in it. The radius
        follows from the better fit.
        """
        if min(np.multiply(heights.shape, spacing)) < 2.0 * (margin + max(spacing)):
            return cls(at_edge=True)
        i, j = np.rint(np.divide(highest(-heights, spacing, margin), spacing))
        x = spacing[0] * (np.arange(heights.shape[0], dtype=float) - i)
        y = spacing[1] * (np.arange(heights.shape[1], dtype=float) - j)
        widest = float(min(-x[0], x[-1], -y[0], y[-1]))
        least = _MIN_DISC_STEPS * max(spacing)
        if widest < least:
            return cls(at_edge=True)
        x, y = np.meshgrid(x, y, indexing="ij")
        first, share = _Disc.of(heights, x, y, widest).fit()
        fits = []
        for is_sphere in (False, True):
            curvature, explained = first, 0.0
            for _ in range(_FITS):
                if curvature <= 0.0:
                    return cls()
                radius = max(least, min(widest, _DISC_TO_RADIUS / curvature))
                bend = curvature if is_sphere else 0.0
                disc = _Disc.of(heights, x, y, radius)
                curvature, explained = disc.fit(bend)
            fits.append((explained, curvature, disc, bend))
        other, best = sorted(fits, key=lambda fit: fit[0])
        explained, curvature, disc, bend = best
        if curvature <= 0.0:
            return cls()
        tilt, bow = (polynomial(heights, degree) for degree in (1, 2))
        rest = (heights - bow).var() / (heights - tilt).var()
        share = min(share, 1.0 - float(rest))
        # the shape that fits worse counts if it is hardly worse
        worse = (1.0 - explained) / (1.0 - other[0]) if other[0] < 1.0 else 1.0
        shape = worse * (curvature - other[1])
        x_bow = np.diff(bow, 2, axis=0).mean() / spacing[0] ** 2
        y_bow = np.diff(bow, 2, axis=1).mean() / spacing[1] ** 2
        n, m = heights.shape
        return cls(
            1.0 / curvature,
            share,
            error=math.hypot(disc.error(bend), shape) / curvature,
            whole=float(x_bow + y_bow) / 2.0 / curvature,
            rise=float(n * spacing[0] * x_bow + m * spacing[1] * y_bow) / 8.0,
        )


@dataclass(frozen=True, eq=False)
class _Disc:
    """Heights of the points (x, y) of a disc, shapes (number of points,)."""

    x: FloatArray
    y: FloatArray
    heights: FloatArray

    @classmethod
    def of(
        cls, heights: FloatArray, x: FloatArray, y: FloatArray, radius: float
    ) -> _Disc:
        inside = x**2 + y**2 <= radius**2
        return cls(x[inside], y[inside], heights[inside])

    def fit(self, bend: float = 0.0) -> tuple[float, float]:
        """Return the curvature at the apex, and the share of the variance.

        The shape is a sphere of the curvature `bend`, scaled, or for zero a paraboloid.
        The share refers to the variance about the plane that fits best.
        """
        square = self.x**2 + self.y**2
        shape = square / (1.0 + np.sqrt(np.maximum(1.0 - bend**2 * square, 0.0)))
        matrix = np.stack([np.ones(len(self.x)), self.x, self.y, shape], axis=1)
        scale = np.abs(matrix).max(axis=0)
        matrix /= scale
        plane, *_ = np.linalg.lstsq(matrix[:, :3], self.heights, rcond=None)
        found, *_ = np.linalg.lstsq(matrix, self.heights, rcond=None)
        variance = float((self.heights - matrix[:, :3] @ plane).var())
        rest = float((self.heights - matrix @ found).var())
        return float(found[3] / scale[3]), 1.0 - rest / variance if variance else 0.0

    def error(self, bend: float) -> float:
        """Return the standard error of the curvature, by leaving sectors out."""
        angle = np.arctan2(self.y, self.x)
        sector = np.rint(angle * _SECTORS / (2.0 * np.pi)) % _SECTORS
        curvatures = []
        for number in range(_SECTORS):
            kept = sector != number
            part = _Disc(self.x[kept], self.y[kept], self.heights[kept])
            curvatures.append(part.fit(bend)[0])
        return math.sqrt(_SECTORS - 1.0) * float(np.std(curvatures))
