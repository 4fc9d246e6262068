"""Maps of JPK: one archive with many curves, which are read one at a time.

The archive has a folder ``index/N`` for each curve, and files that the curves share. A
copy of one folder and the shared files is a map of one curve, which is read in the same
time whatever the size of the map.
"""

from __future__ import annotations

import re
import zipfile
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.formats.archive import changed_at, renamed_in_errors
from ase_roughcontact.fitting.formats.table import Position, chosen_curve

# Endings of the names of maps.
_SUFFIXES = (".jpk-force-map", ".jpk-qi-data", ".jpk-qi-series")
# Files and folders that the curves share.
_SHARED = re.compile(r"header\.properties|shared-data/.*|index/")
# Folder of a curve, with its number.
_CURVE = re.compile(r"index/(\d+)/")
# Header of a curve.
_HEADER = re.compile(r"index/\d+/header\.properties")
# Position in the header of a curve (m).
_POSITION = re.compile(rb"\.header\.position\.([xy])=(\S+)")


@dataclass(frozen=True)
class _Map:
    """Open archive, the files that its curves share, and the files of each curve."""

    archive: zipfile.ZipFile
    shared: list[str]
    curves: list[list[str]]


def is_jpk_map(file: PathName) -> bool:
    """Return whether a file is a map of JPK."""
    return Path(file).suffix.lower() in _SUFFIXES and zipfile.is_zipfile(file)


def count_jpk_curves(file: PathName) -> int:
    """Return the number of curves in a map."""
    return len(_opened(str(file), changed_at(file)).curves)


def jpk_positions(file: PathName) -> list[Position | None]:
    """Return the positions of the curves in a map, from their headers."""
    opened = _opened(str(file), changed_at(file))
    positions: list[Position | None] = []
    for names in opened.curves:
        header = next(name for name in names if _HEADER.fullmatch(name))
        text = opened.archive.read(header)
        found = {axis: float(value) for axis, value in _POSITION.findall(text)}
        is_known = found.keys() == {b"x", b"y"}
        x, y = (UNITS["m"] * found.get(axis, 0.0) for axis in (b"x", b"y"))
        positions.append(Position(x, y) if is_known else None)
    return positions


@contextmanager
def single_curve(file: PathName, curve: int | None) -> Iterator[Path]:
    """Write a curve of a map as a map of one curve, in a temporary folder.

    Parameters
    ----------
    file : path
        Map.
    curve : int, optional
        Number of the curve, from 1; needed if there are several.

    Yields
    ------
    Path
        Map of one curve. Errors in reading it name the map and the number.

    Raises
    ------
    ValueError
        If there are several curves and none is chosen, or the number is too large.
    """
    opened = _opened(str(file), changed_at(file))
    index = chosen_curve(file, curve, len(opened.curves))
    # a package that reads it may keep the file open, which Windows does not remove
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = Path(folder) / Path(file).name
        with zipfile.ZipFile(path, "w") as single:
            for name in (*opened.shared, *opened.curves[index]):
                single.writestr(name, opened.archive.read(name))
        with renamed_in_errors(path, f"{file}, curve {index + 1}"):
            yield path


@lru_cache(maxsize=2)
def _opened(file: str, changed: int) -> _Map:
    """Open a map; it stays open for its other curves, until the file has changed."""
    archive = zipfile.ZipFile(file)
    shared, curves = list[str](), defaultdict[int, list[str]](list)
    for name in archive.namelist():
        if found := _CURVE.match(name):
            curves[int(found[1])].append(name)
        elif _SHARED.fullmatch(name):
            shared.append(name)
    return _Map(archive, shared, [curves[number] for number in sorted(curves)])
