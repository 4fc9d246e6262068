"""Scans from files: text and NumPy files, all others by the package SurfaceTopography.

Text is a matrix, with one line of the scan (constant y) for each line of the file, or a
list of points with three columns x, y, z on a regular grid, in any order. Lines before
the numbers, and comments after #, are a header. It may contain the size of the scan and
the units, as Gwyddion writes them::

    # Width: 2.00 µm
    # Height: 2.00 µm
    # Value units: nm
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.units import LENGTHS
from ase_roughcontact._util.validation import FloatArray, check_matrix, lookup

_TEXT = ".txt", ".asc", ".dat", ".csv", ".xyz", ".tsv"
# Distance of a point from the regular grid, in steps of the grid, that is rounding.
_ROUNDING = 0.05
_NUMBER = r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)"
_SIZE = rf"(?:scan\s+|physical\s+)?{{}}\s*[:=]\s*{_NUMBER}\s*([^\s\d]+)"
_WIDTH, _HEIGHT = (
    re.compile(_SIZE.format(name), re.IGNORECASE)
    for name in (r"(?:width|x[- ]?size|size[ _]x)", r"(?:height|y[- ]?size|size[ _]y)")
)
_UNIT = re.compile(
    r"(?:value|height|z)?[- ]?units?\s*[:=]\s*([^\s\d]+)\s*$", re.IGNORECASE
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


def read_scan(file: str | Path, channel: int | str | None = None) -> RawScan:
    """Read a scan.

    Parameters
    ----------
    file : path
        NumPy array (.npy), text (.txt, .asc, .dat, .csv, .tsv, .xyz), or any format
        that SurfaceTopography reads.
    channel : int or str, optional
        Number or name of the channel of a file with several; by default the height.

    Returns
    -------
    RawScan

    Raises
    ------
    ValueError
        If the file cannot be read.
    """
    path = Path(file)
    try:
        if path.suffix == ".npy":
            return RawScan(_array(np.load(path)))
        if path.suffix.lower() in _TEXT and not _is_binary(path):
            return _from_text(path.read_text(encoding="utf-8", errors="replace"))
        return _with_surface_topography(path, channel)
    except ImportError:
        raise
    except Exception as error:  # readers of foreign formats raise errors of any kind
        message = f"cannot read a scan from {str(file)!r}: {error}"
        raise ValueError(message) from error


def scan_of(topography: Any) -> RawScan:
    """Return the scan of an array or of a topography of SurfaceTopography.

    Parameters
    ----------
    topography : array_like or SurfaceTopography object
        Masked and NaN points are missing.

    Returns
    -------
    RawScan

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
    try:
        from SurfaceTopography import open_topography
    except ImportError as error:
        raise ImportError(
            f"{path} needs the package SurfaceTopography: install the extra "
            "topography: pip install '.[topography]' in the folder of the source "
            "code; or export the scan as text"
        ) from error
    if not path.is_file():
        raise FileNotFoundError("there is no such file")
    with open_topography(str(path)) as reader:
        names = [each.name for each in reader.channels]
        if isinstance(channel, str):
            channel = lookup(
                channel, {name: i for i, name in enumerate(names)}, "channel"
            )
        topography = reader.topography(channel_index=channel)
        return scan_of(topography)


def _is_binary(path: Path) -> bool:
    with path.open("rb") as file:
        return b"\0" in file.read(4096)


def _from_text(text: str) -> RawScan:
    """Read a matrix or a list of points, with the sizes and the unit in the header."""
    header: list[str] = []
    rows: list[list[float]] = []
    for line in text.lstrip("\ufeff").splitlines():
        content, _, comment = line.partition("#")
        header.append(comment)
        numbers = _numbers(content)
        if numbers:
            rows.append(numbers)
        elif rows and content.strip():
            raise ValueError(f"a line after the first numbers is not one: {content!r}")
        else:
            header.append(content)
    if not rows:
        raise ValueError(
            "the file contains no rows of numbers; decimals are written with points"
        )
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


def _numbers(line: str) -> list[float] | None:
    """Return the numbers of a line, None if something else is in it."""
    for separator in (",", ";", None):
        words = line.strip().rstrip(",;").split(separator) if line.strip() else []
        try:
            return [float(word) for word in words]
        except ValueError:
            continue
    return None


def _header_size(header: list[str], pattern: re.Pattern) -> float | None:
    """Return a size of the header in Å."""
    for line in header:
        found = pattern.search(line)
        if found and found[2].rstrip(",;)") in LENGTHS:
            return float(found[1]) * LENGTHS[found[2].rstrip(",;)")]
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
