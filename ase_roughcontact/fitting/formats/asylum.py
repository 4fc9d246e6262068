"""Waves of Igor Pro (.ibw) as Asylum Research writes them, by igor2.

The last dimension of a wave has the channels, in SI units; heights increase towards
the surface. The note has the calibration (``SpringConstant``, ``InvOLS``), the points
at which segments end (``Indexes``), and their directions: 1 towards the surface, -1
away from it, 0 for a dwell, NaN before the first one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from ase_roughcontact._util.extras import imported
from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.formats.table import ArrayColumn, CurveTable, Segment

# Channels that are read, by quantity; all are in m.
_CHANNELS = {
    "zsnsr": "zsnsr",
    "zsensor": "zsnsr",
    "raw": "z piezo",
    "height": "z piezo",
    "defl": "deflection",
    "deflection": "deflection",
}
# Kinds of segments by their directions.
_KINDS = {1.0: "approach", -1.0: "retraction", 0.0: "hold"}


def read_asylum(file: PathName) -> CurveTable:
    """Return the curve of a wave.

    Raises
    ------
    ValueError
        If the file is not a wave, or has no deflection and height.
    ImportError
        If igor2 is missing.
    """
    wave = _wave(file)
    data = np.asarray(wave["wData"], float)
    labels = [label.decode("latin-1").lower() for label in wave["labels"][1] if label]
    if data.ndim != 2 or len(labels) != data.shape[1]:
        raise ValueError(
            f"{file} is a wave of shape {data.shape}, not a force curve with named "
            "channels: export the curve with Raw or ZSnsr, and Defl"
        )
    spacing = float(wave["wave_header"]["sfA"][0])
    columns = {"time": np.arange(len(data), dtype=float) * spacing}
    for label, values in zip(labels, data.T, strict=True):
        if label in _CHANNELS:
            columns.setdefault(_CHANNELS[label], values)
    note = _note(wave["note"])
    return CurveTable(
        [
            Segment(kind, _columns(columns, points))
            for kind, points in _segments(note, len(data))
        ],
        _number(note, "SpringConstant", UNITS["N/m"]),
        _number(note, "InvOLS", UNITS["m"]),
    )


def _wave(file: PathName) -> Mapping[str, Any]:
    """Return the parts of a wave."""
    need = f"{file} needs the package igor2"
    igor = imported("igor2.binarywave", "curves", need, "; or export the curve as text")
    try:
        wave: Mapping[str, Any] = igor.load(str(file))["wave"]
    except Exception as error:  # igor2 raises errors of any kind
        raise ValueError(f"cannot read a wave from {file}: {error}") from error
    return wave


def _note(note: bytes) -> dict[str, str]:
    """Return the keys of a note, and their values."""
    lines = note.decode("latin-1").replace("\n", "\r").split("\r")
    parts = (line.partition(":") for line in lines)
    return {key.strip(): value.strip() for key, _, value in parts}


def _number(note: Mapping[str, str], key: str, unit: float) -> float | None:
    """Return a positive number of a note in ASE's units; None if it is missing."""
    try:
        value = float(note[key])
    except (KeyError, ValueError):
        return None
    return value * unit if value > 0.0 and math.isfinite(value) else None


def _segments(note: Mapping[str, str], count: int) -> list[tuple[str | None, slice]]:
    """Return kinds and points of the segments."""
    try:
        ends = [int(text) for text in note["Indexes"].split(",") if text.strip()]
        directions = [
            float(text) for text in note["Direction"].split(",") if text.strip()
        ]
    except (KeyError, ValueError):
        return [(None, slice(0, count))]
    kinds = [_KINDS.get(direction) for direction in directions[1:]]
    if len(kinds) != len(ends) - 1 or None in kinds or sorted(ends) != ends:
        return [(None, slice(0, count))]
    points = [slice(a, b) for a, b in pairwise(ends)]
    if points:
        points[-1] = slice(points[-1].start, min(ends[-1] + 1, count))
    return list(zip(kinds, points, strict=True))


def _columns(columns: Mapping[str, FloatArray], points: slice) -> list[ArrayColumn]:
    """Return the columns of a segment."""
    units = {"time": "s"}
    return [
        ArrayColumn(name, units.get(name, "m"), False, values[points])
        for name, values in columns.items()
    ]
