"""Scans from files: text, NumPy, and by SurfaceTopography all others."""

from __future__ import annotations

import bz2
import gzip
import lzma
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.extras import imported, silenced
from ase_roughcontact._util.registry import Registry
from ase_roughcontact.topography.channels import Channel, chosen
from ase_roughcontact.topography.profile import LineProfile
from ase_roughcontact.topography.raw_scan import (
    RawScan,
    finite_heights,
    heights_of,
    scan_of,
)
from ase_roughcontact.topography.scan_text import Table, scan_from_tables, tables_of

#: Endings of the names of text files.
TEXT = ".txt", ".asc", ".dat", ".csv", ".xyz", ".tsv"
# Functions that open compressed files, by the endings of their names.
_OPENERS: dict[str, Any] = {".gz": gzip.open, ".bz2": bz2.open, ".xz": lzma.open}
# Number of bytes at the start of a file that tell whether it is a text.
_SAMPLE_BYTES = 4096
# A line of a header that has the scale of heights or places.
_SCALE_LINE = re.compile(r"(?i)\b(?:factor|scale|pixel|conversion|mult\w*)\b.*[:=].*\d")
# Formats of SurfaceTopography for text: matrices and columns.
_TEXT_FORMATS = "asc", "xyz"


@dataclass(frozen=True)
class ScanFormat:
    """Format of files with scans.

    Attributes
    ----------
    recognises : callable
        Function that returns whether a file, given by its path, has this format.
    read : callable
        Function of the path, and the number or name of the channel or None, that
        returns a `RawScan`, or raises an error of any kind.
    """

    recognises: Callable[[Path], bool]
    read: Callable[[Path, int | str | None], RawScan | LineProfile]


#: Formats of one's own by their names, which are tried before the formats here.
#: One more is an entry: ``SCAN_FORMATS["mine"] = ScanFormat(recognises, read)``.
SCAN_FORMATS: Registry[ScanFormat] = Registry("format of scans")


def read_scan(
    file: str | Path, channel: int | str | None = None
) -> RawScan | LineProfile:
    """Read a scan or a line profile.

    Parameters
    ----------
    file : path
        NumPy array (.npy), text (.txt, .asc, .dat, .csv, .tsv, .xyz, all of them also
        with .gz, .bz2 or .xz; see `scan_text`), or any format that SurfaceTopography
        reads. If it is installed, it also reads texts with a header without sizes that
        are known here.
    channel : int or str, optional
        Number or name of the channel of a file with several; by default the only one
        that is a height.

    Raises
    ------
    ValueError
        If the file cannot be read, or the channel is not clear.
    """
    path = Path(file)
    try:
        for own in SCAN_FORMATS.values():
            if own.recognises(path):
                return own.read(path, channel)
        if path.suffix == ".npy":
            heights = heights_of(np.load(path))
            chosen([Channel("", heights.shape)], channel)
            return RawScan(heights)
        name = path.with_suffix("") if path.suffix.lower() in _OPENERS else path
        if name.suffix.lower() in TEXT:
            contents = _contents(path)
            if b"\0" not in contents[:_SAMPLE_BYTES]:
                return _from_text(contents.decode("utf-8", errors="replace"), channel)
        return _with_surface_topography(path, channel)
    except ImportError:
        raise
    except Exception as error:  # readers of foreign formats raise errors of any kind
        message = f"cannot read a scan from {str(file)!r}: {error}"
        raise ValueError(message) from error


def _from_text(text: str, channel: int | str | None) -> RawScan | LineProfile:
    """Return the scan of a text, with the sizes that its header has."""
    tables = tables_of(text)
    if tables[0].header.strip() and not any(each.size for each in tables):
        found = _sizes_by_surface_topography(text, tables, channel)
        if found is not None:
            return found
        lines = "\n".join(each.header for each in tables).splitlines()
        for line in filter(_SCALE_LINE.search, lines):
            warnings.warn(
                f"the header line {line.strip()!r} is not understood, and heights are "
                "taken as they are: install the extra topography, or scale them",
                stacklevel=2,
            )
    return scan_from_tables(tables, channel)


def _sizes_by_surface_topography(
    text: str, tables: list[Table], channel: int | str | None
) -> RawScan | LineProfile | None:
    """Return the scan by a reader of SurfaceTopography that finds its sizes, if any.

    Readers that find other numbers of points are not used: they leave lines out that
    they do not understand.
    """
    if find_spec("SurfaceTopography") is None:
        return None
    package = import_module("SurfaceTopography")
    shapes = {each.columns.shape for each in tables}
    shapes |= {each.shape for each in tables if each.is_profile}
    for name in _TEXT_FORMATS:
        try:
            with silenced():
                reader = package.open_topography(StringIO(text), name)
        except Exception:  # the text has another format
            continue
        with reader:
            is_same = all(each.nb_grid_pts in shapes for each in reader.channels)
            has_sizes = all(
                each.physical_sizes and each.unit for each in reader.channels
            )
            if is_same and has_sizes:
                return _scan_of_channel(reader, channel)
    return None


def _with_surface_topography(
    path: Path, channel: int | str | None
) -> RawScan | LineProfile:
    if not path.is_file():
        raise FileNotFoundError("there is no such file")
    need = f"{path} needs the package SurfaceTopography"
    package = imported(
        "SurfaceTopography", "topography", need, "; or export the scan as text"
    )
    try:
        with silenced(), package.open_topography(str(path)) as reader:
            return _scan_of_channel(reader, channel)
    except package.Exceptions.CannotDetectFileFormat as error:
        raise ValueError(
            "SurfaceTopography does not read this format, or the file is damaged: "
            "export the scan as text"
        ) from error


def _scan_of_channel(reader: Any, channel: int | str | None) -> RawScan | LineProfile:
    """Return a channel of a reader of SurfaceTopography; see `chosen`."""
    number = chosen([_channel(each) for each in reader.channels], channel)
    found = reader.channels[number]
    sizes = None if found.physical_sizes is not None else found.nb_grid_pts
    with silenced():
        topography = reader.topography(channel_index=number, physical_sizes=sizes)
    if topography.dim == 1:
        places = np.asarray(topography.positions()) if sizes is None else None
        return LineProfile(
            finite_heights(topography.heights()), places, topography.unit
        )
    scan = scan_of(topography)
    return scan if sizes is None else replace(scan, spacing=None)


def _channel(found: Any) -> Channel:
    """Return a channel of SurfaceTopography.

    If heights have another unit than x and y, the unit is a tuple; the unit of the
    heights may be missing.
    """
    unit, shape = found.data_unit or found.unit, found.nb_grid_pts
    is_length = found.data_kind.value == "height"
    if isinstance(unit, tuple):
        unit = unit[1]
        is_length = is_length and unit is not None
    return Channel(found.name, shape, unit, is_length)


def _contents(path: Path) -> bytes:
    """Return the contents of a file, which may be compressed."""
    opened = _OPENERS.get(path.suffix.lower(), open)
    with opened(path, "rb") as file:
        contents: bytes = file.read()
    return contents
