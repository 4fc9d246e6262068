"""Heights as they are in a file or an object, before they are levelled."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import FloatArray, check_matrix


@dataclass(frozen=True, eq=False)
class RawScan:
    """Heights as they are in a file or an object.

    Attributes
    ----------
    heights : ndarray, shape (n, m)
        Heights, NaN at missing points; the first index is along x.
    spacing : (float, float), optional
        Distance between points along x and y, if it is known (`lateral_unit`).
    unit : str, optional
        Unit of the heights, if it is known.
    periodic : bool
        Whether the scan is periodic.
    lateral_unit : str, optional
        Unit of the spacing; by default the unit of the heights.
    """

    heights: FloatArray
    spacing: tuple[float, float] | None = None
    unit: str | None = None
    periodic: bool = False
    lateral_unit: str | None = None

    @property
    def transposed(self) -> RawScan:
        """The scan with x and y exchanged."""
        spacing = self.spacing and self.spacing[::-1]
        return replace(self, heights=self.heights.T, spacing=spacing)


def scan_of(topography: Any) -> RawScan:
    """Return the scan of an array or of a topography of SurfaceTopography.

    Masked and NaN points are missing.

    Raises
    ------
    ValueError
        If it is not two-dimensional.
    """
    if not callable(getattr(topography, "heights", None)):
        return RawScan(heights_of(topography))
    pixel_size = getattr(topography, "pixel_size", None)
    if getattr(topography, "dim", 2) != 2 or pixel_size is None:
        raise ValueError(
            f"a topography must be a map of heights on a grid, got {topography!r}"
        )
    x, y = (float(size) for size in pixel_size)
    return RawScan(
        heights_of(topography.heights()),
        (x, y),
        getattr(topography, "unit", None),
        bool(getattr(topography, "is_periodic", False)),
    )


def heights_of(values: Any) -> FloatArray:
    """Return a matrix of heights with NaN in place of masked and infinite points.

    Raises
    ------
    ValueError
        If they are not a matrix of real numbers.
    """
    array: Any = np.ma.asarray(values)
    check_matrix(array)
    return finite_heights(array)


def finite_heights(values: Any) -> FloatArray:
    """Return heights with NaN in place of masked and infinite points."""
    array: Any = np.ma.asarray(values)
    heights: FloatArray = array.astype(float).filled(np.nan)
    heights[~np.isfinite(heights)] = np.nan
    return heights
