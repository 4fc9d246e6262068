"""Scans in text files.

A text has a table for each channel: a matrix of heights, with one line of the scan
(constant y) on each line, or a list of points on a regular grid, three columns x, y, z
in any order, also with a number of the point in front. Lines before the numbers, and
comments after #, are a header. It may contain name, size and units of the channel, as
Gwyddion writes them::

    # Channel: Height
    # Width: 2.00 µm
    # Height: 2.00 µm
    # Value units: nm

The next channel begins with such a header, or after a blank line. Two columns, the
first one increasing, are a line profile. Cells that are empty, infinite or one of
`MISSING` are missing points. Numbers may have a decimal comma unless commas separate
the columns.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ase_roughcontact._util.units import LENGTHS
from ase_roughcontact._util.validation import FloatArray, shown
from ase_roughcontact.topography.channels import Channel, chosen
from ase_roughcontact.topography.profile import LineProfile
from ase_roughcontact.topography.raw_scan import RawScan
from ase_roughcontact.topography.scan_points import grid_of_points

#: Words of missing points, in small letters.
MISSING = frozenset({"", "nan", "bad", "-", "--", "---", "n/a", "na", "null", "none"})
# Separators of columns in the order in which they are tried; None: blanks.
_SEPARATORS = (",", ";", "\t", None)
# Pattern of a length in a header, after the pattern of its name.
_LENGTH_PATTERN = (
    r"{}[^\S\n]*[:=][^\S\n]*([-+]?[\d.,]+(?:[eE][-+]?\d+)?)[^\S\n]*([^\s\d]+)"
)
# Pattern of the width of a scan.
_WIDTH_PATTERN = _LENGTH_PATTERN.format(r"(?im)(?:width|x[- ]?size|size[ _]x)")
# Pattern of the height of a scan, along y.
_HEIGHT_PATTERN = _LENGTH_PATTERN.format(r"(?im)(?:height|y[- ]?size|size[ _]y)")
# Pattern of a unit, after the words that say of what.
_UNIT_PATTERN = r"(?im)^(.*)units?[^\S\n]*[:=][^\S\n]*([^\s\d]+)\s*$"
# Words of the unit of x and y.
_LATERAL_WORD = re.compile(r"\b(?:lateral|xy?|y)\b", re.IGNORECASE)
# Words of the unit of heights.
_HEIGHT_WORD = re.compile(r"\b(?:value|data|height|z)\b", re.IGNORECASE)
# Pattern of the name of a channel.
_NAME_PATTERN = r"(?im)^\W*channel[^\S\n]*[:=][^\S\n]*(.*?)\s*$"
# Patterns of lines that begin the header of another channel.
_HEADER_PATTERNS = _WIDTH_PATTERN, _HEIGHT_PATTERN, _UNIT_PATTERN, _NAME_PATTERN
# Decimals of a number with a decimal comma, which no whole number looks like.
_DECIMALS = re.compile(r"0\d+")
# Number of columns of points x, y, z.
_POINT_COLUMNS = 3


@dataclass(frozen=True, eq=False)
class Table:
    """One table of numbers of a text.

    Attributes
    ----------
    header : str
        Lines between the table before and this one.
    columns : ndarray, shape (number of columns, number of rows)
        Numbers of the table; NaN for missing ones.
    """

    header: str
    columns: FloatArray

    @cached_property
    def size(self) -> tuple[float, float] | None:
        """Width and height of a matrix by the header (Å)."""
        width, height = (
            _length(pattern, self.header)
            for pattern in (_WIDTH_PATTERN, _HEIGHT_PATTERN)
        )
        return None if width is None or height is None else (width, height)

    @property
    def name(self) -> str:
        """Name of the channel."""
        found = re.search(_NAME_PATTERN, self.header)
        return found[1] if found else ""

    @property
    def unit(self) -> str | None:
        """Unit of the heights."""
        return self._units[0]

    @property
    def lateral_unit(self) -> str | None:
        """Unit of x and y."""
        return self._units[1]

    @cached_property
    def _units(self) -> tuple[str | None, str | None]:
        """Units of the heights and of x and y; one unit is valid for both."""
        unit = lateral = None
        for name, found in re.findall(_UNIT_PATTERN, self.header):
            if _HEIGHT_WORD.search(name):
                unit = unit or found
            elif _LATERAL_WORD.search(name):
                lateral = lateral or found
            elif found in LENGTHS:
                unit = unit or found
            if _LATERAL_WORD.search(name) and found in LENGTHS:
                lateral = lateral or found
        return unit, lateral

    @property
    def is_profile(self) -> bool:
        """Whether the table has heights along a line only."""
        count, rows = self.columns.shape
        if self.size is not None or rows <= 2:
            return False
        return count == 1 or (count == 2 and bool((np.diff(self.columns[0]) > 0).all()))

    @property
    def is_points(self) -> bool:
        """Whether the table is a list of points x, y, z."""
        count, rows = self.columns.shape
        return self.size is None and count == _POINT_COLUMNS < rows

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of a matrix, or number of points of a list."""
        shape = self.columns.shape
        return shape[1:] if self.is_points or self.is_profile else shape

    @property
    def channel(self) -> Channel:
        """Name, unit and shape of the channel."""
        return Channel.with_unit(self.name, self.shape, self.unit)

    @property
    def scan(self) -> RawScan | LineProfile:
        """Heights of the table."""
        if self.is_profile:
            *x, z = self.columns
            places = x[0] if x else None
            return LineProfile(z, places, self.unit, self.lateral_unit)
        if self.is_points:
            known = np.isfinite(self.columns[:2]).all(axis=0)
            heights, spacing = grid_of_points(self.columns[:, known])
            return RawScan(heights, spacing, self.unit, False, self.lateral_unit)
        heights = self.columns
        if self.size is None:
            return RawScan(heights, unit=self.unit)
        x, y = np.divide(self.size, heights.shape).tolist()
        return RawScan(heights, (x, y), self.unit, False, "Å")


def scan_from_tables(
    tables: Sequence[Table], channel: int | str | None = None
) -> RawScan | LineProfile:
    """Return the scan of the channel of the height, or of a given one; see `chosen`."""
    return tables[chosen([each.channel for each in tables], channel)].scan


def tables_of(text: str) -> list[Table]:
    """Return the tables of a text.

    Raises
    ------
    ValueError
        If there are no numbers, rows of a table differ in their number of columns, or
        commas are decimal and separate columns.
    """
    lines = text.lstrip("\ufeff").splitlines()
    # the separator with the largest number of lines of numbers; of equal ones the first
    separator, parsed, largest = None, [], -1
    for each in _SEPARATORS:
        rows = [_cells(line, each) for line in lines]
        count = sum(map(bool, rows))
        if count > largest:
            separator, parsed, largest = each, rows, count
    if separator == ",":
        _check_commas(lines, parsed)
    if separator is not None:
        parsed = _without_empty_ends(lines, parsed, separator)
    return _joined(_split(lines, parsed, separator))


def _split(
    lines: list[str], parsed: list[list[float] | None], separator: str | None
) -> list[Table]:
    """Return the tables of a text, with the lines above each as its header."""
    tables: list[Table] = []
    rows: list[list[float]] = []  # of the present table
    header = ""  # above it
    between: list[str] = []  # lines since its last row
    for number, (line, cells) in enumerate(zip(lines, parsed, strict=True), 1):
        if cells and (rows or not np.isnan(cells).all()):
            if rows and _separates(between, len(rows[0])):
                tables.append(_table(header, rows))
                rows = []
            if not rows:
                header = "\n".join(between)
            rows.append(cells)
            between = []
        elif rows and cells is None and _is_damaged(line, separator):
            raise ValueError(
                f"line {number} has other words than numbers, unlike the lines before: "
                f"{shown(line.strip())}"
            )
        else:
            between.append(line)
    if not rows:
        raise ValueError("the file contains no rows of numbers")
    return [*tables, _table(header, rows)]


def _separates(lines: list[str], columns: int) -> bool:
    """Return whether lines between rows of numbers begin another channel.

    Points x, y, z may have blank lines between the lines of a scan.
    """
    header = "\n".join(lines)
    if any(re.search(key, header) for key in _HEADER_PATTERNS):
        return True
    return columns > _POINT_COLUMNS and any(not line.strip() for line in lines)


def _joined(tables: list[Table]) -> list[Table]:
    """Return tables, or one table if each of them is a single row."""
    if any(each.columns.shape[1] > 1 for each in tables):
        return tables
    if len({each.columns.shape[0] for each in tables}) > 1:
        return tables
    columns = np.concatenate([each.columns for each in tables], axis=1)
    return [Table(tables[0].header, columns)]


def _cells(line: str, separator: str | None) -> list[float] | None:
    """Return the numbers of a line, NaN for missing ones; None if it has other words.

    The list is empty for a line that is blank but for a comment.
    """
    cells = []
    for cell in _words(line, separator):
        value = _number(cell, separator)
        if value is None:
            return None
        cells.append(value)
    return cells


def _words(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line without its comment; none if it is blank."""
    content = line.partition("#")[0].strip("\r\n ")
    return content.split(separator) if content.strip() else []


def _without_empty_ends(
    lines: list[str], parsed: list[list[float] | None], separator: str
) -> list[list[float] | None]:
    """Return rows without the empty cells with which all of them end."""
    numbers = []
    for line, cells in zip(lines, parsed, strict=True):
        if cells and not np.isnan(cells).all():
            full = [k for k, word in enumerate(_words(line, separator)) if word.strip()]
            numbers.append(len(cells) - 1 - full[-1])
    empty = min(numbers, default=0)
    return [cells[: len(cells) - empty] if cells else cells for cells in parsed]


def _number(cell: str, separator: str | None) -> float | None:
    """Return the number in a cell, NaN if it is missing, None for another word."""
    word = cell.strip()
    if separator != ",":
        word = word.replace(",", ".")
    if word.lower() in MISSING:
        return math.nan
    try:
        value = float(word)
    except ValueError:
        return None
    return value if math.isfinite(value) else math.nan


def _is_damaged(line: str, separator: str | None) -> bool:
    """Return whether a line after numbers has numbers, and is no line of a header."""
    if ":" in line or "=" in line:
        return False
    words = [word for word in _words(line, separator) if word.strip()]
    return any(_number(word, separator) is not None for word in words)


def _check_commas(lines: list[str], parsed: list[list[float] | None]) -> None:
    """Raise `ValueError` if commas separate columns and are decimal commas, too."""
    rows = [line for line, cells in zip(lines, parsed, strict=True) if cells]
    if any("." in row.partition("#")[0] for row in rows):
        return
    for row in rows:
        for word in _words(row, ",")[1::2]:
            if _DECIMALS.fullmatch(word.strip()):
                raise ValueError(
                    "commas separate the columns and are decimal commas, too, as in "
                    f"{shown(row.strip())}: export the scan with another separator"
                )


def _table(header: str, rows: list[list[float]]) -> Table:
    """Return a table without numbers of points."""
    widths = sorted({len(row) for row in rows})
    if len(widths) > 1:
        raise ValueError(f"rows have different numbers of columns: {widths}")
    columns = np.array(rows).T
    counts = len(columns[0]) > _POINT_COLUMNS and bool(
        (np.diff(columns[0]) == 1.0).all()
    )
    if counts and len(columns) == _POINT_COLUMNS + 1:
        columns = columns[1:]
    elif counts and len(columns) > _POINT_COLUMNS + 1:
        raise ValueError(
            f"the first column counts the rows ({columns[0, 0]:g}, {columns[0, 1]:g}, "
            "...): leave it out"
        )
    return Table(header, columns)


def _length(pattern: str, header: str) -> float | None:
    """Return the first length of the header that follows a pattern (Å)."""
    for value, unit in re.findall(pattern, header):
        if unit.rstrip(",;)") in LENGTHS:
            return float(value.replace(",", ".")) * LENGTHS[unit.rstrip(",;)")]
    return None
