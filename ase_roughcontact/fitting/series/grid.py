"""Values of many curves on the grid of a map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.series.row import FittedCurve

# Largest distance of places on one line of a grid, relative to the extent of the map.
_MAX_LINE_DISTANCE = 1e-3
# Largest deviation of a line from its place in the grid, relative to the spacing.
_MAX_LINE_DEVIATION = 0.25


@dataclass(frozen=True, eq=False)
class MapGrid:
    """Regular grid of a map of curves.

    Attributes
    ----------
    first, spacing : ndarray, shape (2,)
        Coordinates of the first point along columns and rows, and distances (Å), which
        are negative if the coordinates decrease.
    shape : (int, int)
        Numbers of columns and rows.
    numbers : ndarray of int, shape (k, 2)
        Column and row of each curve, from 0; -1 for curves without a place.
    """

    first: FloatArray
    spacing: FloatArray
    shape: tuple[int, int]
    numbers: np.ndarray

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """Left, right, lower and upper edge, half a spacing beyond the points (Å)."""
        low = self.first - 0.5 * self.spacing
        high = low + self.spacing * self.shape
        return float(low[0]), float(high[0]), float(low[1]), float(high[1])

    def values(self, values: FloatArray) -> FloatArray:
        """Return values of the curves on the grid, NaN where there is no curve.

        Parameters
        ----------
        values : ndarray, shape (k,)

        Returns
        -------
        ndarray, shape (rows, columns)
        """
        found = np.full(self.shape, np.nan)
        has_place = self.numbers[:, 0] >= 0
        found[tuple(self.numbers[has_place].T)] = values[has_place]
        return found.T


def grid_of(curves: Sequence[FittedCurve]) -> MapGrid | None:
    """Return the grid on which curves were measured; None if they are not on one.

    Columns and rows are numbered as in the file. Without numbers, or if two curves have
    the same, as in a map that is turned, places are on one line if their coordinates
    differ by less than 1/1000 of the map, and the lines must have equal distances. If
    several curves were measured at a place, the map has the last one.

    Parameters
    ----------
    curves : sequence of FittedCurve

    Returns
    -------
    MapGrid or None
    """
    places = np.array([(each.x, each.y) for each in curves], float)
    numbers = np.array([(each.column, each.row) for each in curves], int)
    known = np.isfinite(places).all(axis=1)
    if not known.any() or np.ptp(places[known], axis=0).max() == 0.0:
        return None
    is_unique = len(np.unique(numbers[known], axis=0)) == known.sum()
    if (numbers[known] < 0).any() or not is_unique:
        columns, rows = (_lines(places[known], axis) for axis in (0, 1))
        if columns is None or rows is None:
            return None
        numbers[known] = np.column_stack([columns, rows])
    numbers[known] -= numbers[known].min(axis=0)
    numbers[~known] = -1
    n, m = (int(number) + 1 for number in numbers.max(axis=0))
    first, spacing = _axes(places[known], numbers[known])
    return MapGrid(first, spacing, (n, m), numbers)


def _lines(places: FloatArray, axis: int) -> np.ndarray | None:
    """Return the numbers of lines of equal distances; None without such lines."""
    extent = float(np.ptp(places, axis=0).max())
    order = np.argsort(places[:, axis])
    ordered = places[order, axis]
    begins = np.append(True, np.diff(ordered) > _MAX_LINE_DISTANCE * extent)
    label = np.cumsum(begins) - 1
    at = np.bincount(label, ordered) / np.bincount(label)
    if len(at) == 1:
        return np.zeros(len(places), int)
    along = (at - at[0]) / np.diff(at).min()
    number = np.rint(along)
    if abs(along - number).max() > _MAX_LINE_DEVIATION:
        return None
    found = np.empty(len(places), int)
    found[order] = number[label].astype(int)
    return found


def _axes(places: FloatArray, numbers: np.ndarray) -> tuple[FloatArray, FloatArray]:
    """Return the first coordinates, and the spacings, by straight lines.

    A side of one point gets the spacing of the other side.
    """
    first, spacing = places.min(axis=0), np.zeros(2)
    for axis in range(2):
        if np.ptp(numbers[:, axis]) > 0:
            line = np.polyfit(numbers[:, axis], places[:, axis], 1)
            spacing[axis], first[axis] = line
    spacing[spacing == 0.0] = abs(spacing).max()
    return first, spacing
