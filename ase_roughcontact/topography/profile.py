"""Line profiles: heights along one line, which have statistics but no contact."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.units import LENGTHS, with_unit
from ase_roughcontact._util.validation import FloatArray


@dataclass(frozen=True, eq=False)
class LineProfile:
    """Heights along a line, with straight lines between the points.

    Attributes
    ----------
    heights : ndarray, shape (n,)
        Heights (`unit`); NaN at missing points.
    places : ndarray, shape (n,), optional
        Places along the line, if they are known (`lateral_unit`).
    unit, lateral_unit : str, optional
        Units of heights and of places, if they are known; one is valid for both.
    """

    heights: FloatArray
    places: FloatArray | None = None
    unit: str | None = None
    lateral_unit: str | None = None

    def statistics(self, unit: str | None = None) -> tuple[float, float]:
        r"""Return the rms height (Å) and the rms slope along the line.

        The straight line that fits the points best is subtracted. Both are exact
        averages over the straight lines between the points,
        :math:`\langle h^2 \rangle = \sum (h_k^2 + h_k h_{k+1} + h_{k+1}^2) \Delta x_k
        / 3L` and :math:`\langle h'^2 \rangle = \sum \Delta h_k^2 / (\Delta x_k L)`.

        Parameters
        ----------
        unit : str, optional
            Unit of lengths that have none.

        Returns
        -------
        rms_height, rms_slope : float
            NaN without a unit, without places or with fewer than three points.
        """
        height_unit = self.unit or self.lateral_unit or unit
        place_unit = self.lateral_unit or self.unit or unit
        if self.places is None or height_unit is None or place_unit is None:
            return math.nan, math.nan
        known = np.isfinite(self.heights) & np.isfinite(self.places)
        if known.sum() < 3:
            return math.nan, math.nan
        z = self.heights[known] * LENGTHS[height_unit]
        x = self.places[known] * LENGTHS[place_unit]
        z = z - np.polyval(np.polyfit(x, z, 1), x)
        steps, length = np.diff(x), float(np.ptp(x))
        squares = (z[:-1] ** 2 + z[:-1] * z[1:] + z[1:] ** 2) / 3.0
        height = (squares * steps).sum() / length
        slope = (np.diff(z) ** 2 / steps).sum() / length
        return math.sqrt(height), math.sqrt(slope)

    def described(self, unit: str | None = None) -> str:
        """Return number of points and statistics as text."""
        height, slope = self.statistics(unit)
        text = f"a line profile of {len(self.heights)} points"
        if math.isnan(height):
            return text
        return f"{text}, rms height {with_unit(height, 'nm')}, rms slope {slope:.3g}"
