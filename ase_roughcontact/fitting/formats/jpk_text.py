"""Text exports of JPK: segments with a header each."""

from __future__ import annotations

import re
from collections.abc import Mapping
from itertools import groupby

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.formats.table import (
    CurveTable,
    Position,
    Segment,
    TextColumn,
    segment_kind,
)

# Line of a header that begins a segment.
_SEGMENT = re.compile(r"^# segment: ", re.M)


def is_jpk_text(text: str) -> bool:
    """Return whether a text is an export of JPK."""
    return _SEGMENT.search(text) is not None


def read_jpk_text(lines: Mapping[int, str]) -> CurveTable:
    """Return the segments of an export, pauses as holds.

    Parameters
    ----------
    lines : mapping of int to str
        Lines that are not blank by their numbers.
    """
    segments: list[Segment] = []
    header: dict[str, str] = {}
    for is_header, group in groupby(lines.items(), lambda each: each[1][0] == "#"):
        if is_header:  # a segment has all of its keys, the whole file others
            header |= dict(line[1:].strip().partition(": ")[::2] for _, line in group)
        elif kind := segment_kind(header.get("segment", "")):
            segments.append(Segment(kind, _columns(header, dict(group))))
    return CurveTable(
        segments,
        _quantity(header, "springConstant", UNITS["N/m"]),
        _quantity(header, "sensitivity", UNITS["m"]),
        _position(header),
    )


def _position(header: Mapping[str, str]) -> Position | None:
    """Return the place on the sample by a header; None if it is not known."""
    x, y = (_quantity(header, f"{axis}Position", UNITS["m"]) for axis in "xy")
    return None if x is None or y is None else Position(x, y)


def _columns(header: Mapping[str, str], lines: Mapping[int, str]) -> list[TextColumn]:
    """Return the columns of a segment. Heights are positive away from the surface."""
    rows = {number: line.split() for number, line in lines.items()}
    names = header.get("columns", "").split()
    units = header.get("units", "").split()
    units += len(names) * [""]
    columns = []
    for i, name in enumerate(names):
        cells = [(line, row[i] if i < len(row) else None) for line, row in rows.items()]
        columns.append(TextColumn(name, name.lower(), units[i] or None, True, cells))
    return columns


def _quantity(header: Mapping[str, str], key: str, unit: float) -> float | None:
    """Return a number of a header in ASE's units; None if it is missing."""
    try:
        return float(header[key]) * unit
    except (KeyError, ValueError):
        return None
