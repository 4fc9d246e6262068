"""Scans from text: a matrix of heights, or a list of points.

A matrix has one line of the scan (constant y) on each line of the text, a list three
columns x, y, z on a regular grid, in any order. Lines before the numbers, and comments
after #, are a header. It may contain the size of the scan and the units, as Gwyddion
writes them::

    # Width: 2.00 µm
    # Height: 2.00 µm
    # Value units: nm

Cells that are empty or one of `MISSING` are missing points. Numbers have a decimal
comma if columns are separated otherwise.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

import numpy as np

from ase_roughcontact._util.units import LENGTHS
from ase_roughcontact._util.validation import FloatArray, shown

#: Words of missing points, in small letters.
MISSING = frozenset({"", "nan", "bad", "-", "--", "---", "n/a", "na", "null", "none"})
# Distance of a point from the regular grid, in steps of the grid, that is rounding.
_ROUNDING = 0.05
_COMMA = re.compile(r"[-+]?\d+(?:,\d+)?(?:[eE][-+]?\d+)?")
_NUMBER = r"([-+]?[\d.,]+(?:[eE][-+]?\d+)?)"
_SIZE = rf"(?:scan\s+|physical\s+)?{{}}\s*[:=]\s*{_NUMBER}\s*([^\s\d]+)"
_WIDTH, _HEIGHT = (
    re.compile(_SIZE.format(name), re.IGNORECASE)
    for name in (r"(?:width|x[- ]?size|size[ _]x)", r"(?:height|y[- ]?size|size[ _]y)")
)
_UNIT = re.compile(
    r"(?:value|height|z)?[- ]?units?\s*[:=]\s*([^\s\d]+)\s*$", re.IGNORECASE
)
# Separators of columns and signs of decimals, in the order in which they are tried;
# None: blanks.
_FORMATS = (
    (",", "."),
    (";", "."),
    ("\t", "."),
    (None, "."),
    (";", ","),
    ("\t", ","),
    (None, ","),
)


@dataclass(frozen=True, eq=False)
class RawScan:
    """Heights as they are in a file or an object.

    Attributes
    ----------
    heights : ndarray, shape (n, m)
        NaN at missing points; the first index is along x.
    spacing : (float, float), optional
        Distance between points along x and y, if it is known.
    unit : str, optional
        Unit of lengths and heights, if it is known.
    periodic : bool
    """

    heights: FloatArray
    spacing: tuple[float, float] | None = None
    unit: str | None = None
    periodic: bool = False


def scan_from_text(text: str) -> RawScan:
    """Return the scan of a text; see `scan_text`.

    Parameters
    ----------
    text : str

    Returns
    -------
    RawScan

    Raises
    ------
    ValueError
        If there are no numbers, or rows differ in their number of columns.
    """
    header, rows = _split(text)
    if not rows:
        raise ValueError("the file contains no rows of numbers")
    widths = sorted({len(row) for row in rows})
    if len(widths) > 1:
        raise ValueError(f"rows have different numbers of columns: {widths}")
    unit = _header_unit(header)
    if widths == [3] and len(rows) > 3:
        return _from_points(np.array(rows), unit)
    heights = np.array(rows).T
    n, m = heights.shape
    width, height = (_header_size(header, pattern) for pattern in (_WIDTH, _HEIGHT))
    if width is None or height is None or unit is None:
        return RawScan(heights, unit=unit)
    step = width / n / LENGTHS[unit], height / m / LENGTHS[unit]
    return RawScan(heights, step, unit)


def _split(text: str) -> tuple[list[str], list[list[float]]]:
    """Return the lines of the header and the rows of numbers."""
    lines = text.lstrip("\ufeff").splitlines()
    # the format with the most rows; of equal ones the first
    tables = [_Table.of(lines, *each) for each in _FORMATS]
    table = max(tables, key=lambda each: len(each.rows))
    if table.problem:
        raise ValueError(table.problem)
    return table.header, _filled(table.rows)


@dataclass(frozen=True)
class _Table:
    """Header and rows of a text in one of the formats, up to a line that is none."""

    header: list[str]
    rows: list[list[float | None]]
    problem: str = ""

    @classmethod
    def of(cls, lines: list[str], separator: str | None, decimal: str) -> _Table:
        table = cls([], [])
        for number, line in enumerate(lines, 1):
            content, _, comment = line.partition("#")
            table.header.append(comment)
            row = _row(content, separator, decimal) if content.strip() else None
            if row and (table.rows or any(cell is not None for cell in row)):
                table.rows.append(row)
            elif table.rows and content.strip():
                problem = (
                    f"line {number} is not one of numbers, as those before it: "
                    f"{shown(content.strip())}"
                )
                return replace(table, problem=problem)
            else:
                table.header.append(content)
        return table


def _row(line: str, separator: str | None, decimal: str) -> list[float | None] | None:
    """Return the cells of a line, None for missing ones; None if it has others."""
    cells: list[float | None] = []
    for cell in line.strip("\r\n ").split(separator):
        word = cell.strip()
        if word.lower() in MISSING:
            cells.append(None)
            continue
        if decimal == ",":
            if not _COMMA.fullmatch(word):
                return None
            word = word.replace(",", ".")
        try:
            cells.append(float(word))
        except ValueError:
            return None
    return cells


def _filled(rows: list[list[float | None]]) -> list[list[float]]:
    """Return rows with NaN for missing cells, without an empty column at the end."""
    if rows and all(row[-1] is None for row in rows):
        rows = [row[:-1] for row in rows]
    return [[np.nan if cell is None else cell for cell in row] for row in rows]


def _header_size(header: list[str], pattern: re.Pattern) -> float | None:
    """Return a size of the header in Å."""
    for line in header:
        found = pattern.search(line)
        if found and found[2].rstrip(",;)") in LENGTHS:
            value = float(found[1].replace(",", "."))
            return value * LENGTHS[found[2].rstrip(",;)")]
    return None


def _header_unit(header: list[str]) -> str | None:
    for line in header:
        found = _UNIT.search(line)
        if found and found[1] in LENGTHS:
            return found[1]
    return None


def _from_points(points: FloatArray, unit: str | None) -> RawScan:
    """Return the grid of a list of points x, y, z; points may be missing."""
    places, counts, spacing = [], [], []
    for axis, name in enumerate("xy"):
        values = np.unique(points[:, axis])
        step = np.diff(values).max(initial=0.0)
        if step == 0.0:
            raise ValueError(f"all points have the same {name}: {values[0]:g}")
        distinct = values[np.append(True, np.diff(values) > 0.5 * step)]
        step = (distinct[-1] - distinct[0]) / max(len(distinct) - 1, 1)
        place = (points[:, axis] - distinct[0]) / step
        if abs(place - np.rint(place)).max() > _ROUNDING:
            raise ValueError(
                f"the points (x, y, z) are not on a regular grid along {name}: "
                "interpolate them, for example with scipy.interpolate.griddata, and "
                "give the array"
            )
        places.append(np.rint(place).astype(int))
        counts.append(len(distinct))
        spacing.append(float(step))
    heights = np.full(counts, np.nan)
    heights[tuple(places)] = points[:, 2]
    return RawScan(heights, (spacing[0], spacing[1]), unit)
