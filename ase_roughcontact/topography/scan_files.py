"""Scans from files: text, NumPy, and by SurfaceTopography all others.

A text is a matrix of heights, with one line of the scan (constant y) on each line, or a
list of points on a regular grid, three columns x, y, z in any order. Lines before the
numbers, and comments after #, are a header. It may contain the size of the scan and the
units, as Gwyddion writes them::

    # Width: 2.00 µm
    # Height: 2.00 µm
    # Value units: nm

Cells that are empty or one of `MISSING` are missing points. Numbers may have a decimal
comma unless commas separate the columns.
"""

from __future__ import annotations

import bz2
import gzip
import lzma
import math
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.extras import imported, silenced
from ase_roughcontact._util.units import LENGTHS
from ase_roughcontact._util.validation import FloatArray, check_matrix, lookup, shown

#: Endings of the names of text files.
TEXT = ".txt", ".asc", ".dat", ".csv", ".xyz", ".tsv"
# Functions that open compressed files, by the endings of their names.
_COMPRESSED: dict[str, Any] = {".gz": gzip.open, ".bz2": bz2.open, ".xz": lzma.open}
# Number of bytes at the start of a file of which none is zero in a text.
_START = 4096
#: Words of missing points, in small letters.
MISSING = frozenset({"", "nan", "bad", "-", "--", "---", "n/a", "na", "null", "none"})
# Separators of columns in the order in which they are tried; None: blanks.
_SEPARATORS = (",", ";", "\t", None)
# Distance of a point from the regular grid, in steps of the grid, that is rounding.
_ROUNDING = 0.05
# Lengths and units of a header, without regard to capitals.
_SIZE = r"{}[^\S\n]*[:=][^\S\n]*([-+]?[\d.,]+(?:[eE][-+]?\d+)?)[^\S\n]*([^\s\d]+)"
_WIDTH = _SIZE.format(r"(?im)(?:width|x[- ]?size|size[ _]x)")
_HEIGHT = _SIZE.format(r"(?im)(?:height|y[- ]?size|size[ _]y)")
_UNIT = r"(?im)units?[^\S\n]*[:=][^\S\n]*([^\s\d]+)\s*$"


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


def read_scan(file: str | Path, channel: int | str | None = None) -> RawScan:
    """Read a scan.

    Parameters
    ----------
    file : path
        NumPy array (.npy), text (.txt, .asc, .dat, .csv, .tsv, .xyz, all of them also
        with .gz, .bz2 or .xz), or any format that SurfaceTopography reads.
    channel : int or str, optional
        Number or name of the channel of a file with several; by default the height.

    Raises
    ------
    ValueError
        If the file cannot be read.
    """
    path = Path(file)
    try:
        if path.suffix == ".npy":
            return RawScan(_array(np.load(path)))
        name = path.with_suffix("") if path.suffix.lower() in _COMPRESSED else path
        if name.suffix.lower() in TEXT:
            contents = _contents(path)
            if b"\0" not in contents[:_START]:
                return scan_from_text(contents.decode("utf-8", errors="replace"))
        return _with_surface_topography(path, channel)
    except ImportError:
        raise
    except Exception as error:  # readers of foreign formats raise errors of any kind
        message = f"cannot read a scan from {str(file)!r}: {error}"
        raise ValueError(message) from error


def scan_of(topography: Any) -> RawScan:
    """Return the scan of an array or of a topography of SurfaceTopography.

    Masked and NaN points are missing.

    Raises
    ------
    ValueError
        If it is not two-dimensional.
    """
    if not callable(getattr(topography, "heights", None)):
        return RawScan(_array(topography))
    pixel_size = getattr(topography, "pixel_size", None)
    if getattr(topography, "dim", 2) != 2 or pixel_size is None:
        raise ValueError(
            f"a topography must be a map of heights on a grid, got {topography!r}"
        )
    x, y = (float(size) for size in pixel_size)
    return RawScan(
        _array(topography.heights()),
        (x, y),
        getattr(topography, "unit", None),
        bool(getattr(topography, "is_periodic", False)),
    )


def _array(values: Any) -> FloatArray:
    """Return heights with NaN in place of masked and infinite points."""
    array: Any = np.ma.asarray(values)
    check_matrix(array)
    heights = array.astype(float).filled(np.nan)
    heights[~np.isfinite(heights)] = np.nan
    return heights


def _with_surface_topography(path: Path, channel: int | str | None) -> RawScan:
    if not path.is_file():
        raise FileNotFoundError("there is no such file")
    need = f"{path} needs the package SurfaceTopography"
    package = imported(
        "SurfaceTopography", "topography", need, "; or export the scan as text"
    )
    with silenced(), package.open_topography(str(path)) as reader:
        names = [each.name for each in reader.channels]
        if isinstance(channel, str):
            channel = lookup(
                channel, {name: i for i, name in enumerate(names)}, "channel"
            )
        topography = reader.topography(channel_index=channel)
        return scan_of(topography)


def _contents(path: Path) -> bytes:
    """Return the contents of a file, which may be compressed."""
    opened = _COMPRESSED.get(path.suffix.lower(), open)
    with opened(path, "rb") as file:
        contents: bytes = file.read()
    return contents


def scan_from_text(text: str) -> RawScan:
    """Return the scan of a text.

    Raises
    ------
    ValueError
        If there are no numbers, or rows differ in their number of columns.
    """
    lines = text.lstrip("\ufeff").splitlines()
    # the separator with the most lines of numbers; of equal ones the first
    parsed = max(
        ([_cells(line, separator) for line in lines] for separator in _SEPARATORS),
        key=lambda table: sum(map(bool, table)),
    )
    header = "\n".join(k for k, row in zip(lines, parsed, strict=True) if not row)
    units = [unit for unit in re.findall(_UNIT, header) if unit in LENGTHS]
    heights = _columns(lines, parsed)
    if len(heights) == 3 < heights.shape[1]:
        return _from_points(heights, *units[:1])
    width, height = (_length(pattern, header) for pattern in (_WIDTH, _HEIGHT))
    if not units:
        return RawScan(heights)
    if width is None or height is None:
        return RawScan(heights, unit=units[0])
    x, y = np.divide([width, height], heights.shape) / LENGTHS[units[0]]
    return RawScan(heights, (float(x), float(y)), units[0])


def _cells(line: str, separator: str | None) -> list[float] | None:
    """Return the numbers of a line, NaN for missing ones; None if it has other words.

    The list is empty for a line that is blank but for a comment.
    """
    content = line.partition("#")[0].strip("\r\n ")
    cells = []
    for cell in content.split(separator) if content.strip() else ():
        word = cell.strip()
        if separator != ",":
            word = word.replace(",", ".")
        try:
            cells.append(math.nan if word.lower() in MISSING else float(word))
        except ValueError:
            return None
    return cells


def _columns(lines: list[str], parsed: list[list[float] | None]) -> FloatArray:
    """Return the columns of the table of numbers that begins with the first number."""
    starts = (k for k, row in enumerate(parsed) if row and not np.isnan(row).all())
    start = next(starts, len(lines))
    for number, line in enumerate(lines[start:], start):
        if parsed[number] is None:
            raise ValueError(
                f"line {number + 1} is not one of numbers, as those before it: "
                f"{shown(line.strip())}"
            )
    rows = [row for row in parsed[start:] if row]
    if not rows:
        raise ValueError("the file contains no rows of numbers")
    widths = sorted({len(row) for row in rows})
    if len(widths) > 1:
        raise ValueError(f"rows have different numbers of columns: {widths}")
    columns = np.array(rows).T
    # rows may end with a separator
    return columns[:-1] if np.isnan(columns[-1]).all() else columns


def _length(pattern: str, header: str) -> float | None:
    """Return the first length of the header that follows a pattern (Å)."""
    for value, unit in re.findall(pattern, header):
        if unit.rstrip(",;)") in LENGTHS:
            return float(value.replace(",", ".")) * LENGTHS[unit.rstrip(",;)")]
    return None


def _from_points(columns: FloatArray, unit: str | None = None) -> RawScan:
    """Return the grid of a list of points x, y, z; points may be missing."""
    places, spacing = [], []
    for values, name in zip(columns, "xy", strict=False):
        distinct = np.unique(values)
        steps = np.diff(distinct)
        if not steps.size:
            raise ValueError(f"all points have the same {name}: {values[0]:g}")
        distinct = distinct[np.append(True, steps > 0.5 * steps.max())]
        step = (distinct[-1] - distinct[0]) / (len(distinct) - 1)
        place = (values - distinct[0]) / step
        if abs(place - np.rint(place)).max() > _ROUNDING:
            raise ValueError(
                f"the points (x, y, z) are not on a regular grid along {name}: "
                "interpolate them, for example with scipy.interpolate.griddata, and "
                "give the array"
            )
        places.append(np.rint(place).astype(int))
        spacing.append(float(step))
    heights = np.full([place.max() + 1 for place in places], np.nan)
    heights[tuple(places)] = columns[2]
    return RawScan(heights, (spacing[0], spacing[1]), unit)
