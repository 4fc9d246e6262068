"""Line profiles: heights along one line, with statistics, and extruded as a map."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.units import LENGTHS, with_unit
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.topography.raw_scan import RawScan

# Number of equal lines of an extruded profile; the contact does not depend on it.
_LINES = 8


@dataclass(frozen=True, eq=False)
class LineProfile(Summarized):
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

    def extruded(self) -> RawScan:
        """Return the map of the profile along x, with the same heights at all y.

        Heights between the points follow straight lines; points at the ends without a
        height are left out. The spacing is not known without places.

        Raises
        ------
        ValueError
            If fewer than three points are known, or places do not increase.
        """
        known = np.isfinite(self.heights)
        places = self.places
        if places is None:
            places = np.arange(len(self.heights), dtype=float)
        x, z = places[known], self.heights[known]
        if len(x) < 3 or not (np.diff(x) > 0.0).all():
            raise ValueError(
                f"a profile needs three points or more with increasing places, got "
                f"{len(x)}"
            )
        count = round(float(np.ptp(x) / np.median(np.diff(x)))) + 1
        even = np.linspace(x[0], x[-1], count)
        step = float(even[1] - even[0])
        return RawScan(
            np.repeat(np.interp(even, x, z)[:, None], _LINES, axis=1),
            None if self.places is None else (step, step),
            self.unit or self.lateral_unit,
            lateral_unit=self.lateral_unit,
        )

    def described(self, unit: str | None = None) -> str:
        """Return number of points and statistics as text."""
        height, slope = self.statistics(unit)
        text = f"a line profile of {len(self.heights)} points"
        if math.isnan(height):
            return text
        return f"{text}, rms height {with_unit(height, 'nm')}, rms slope {slope:.3g}"
