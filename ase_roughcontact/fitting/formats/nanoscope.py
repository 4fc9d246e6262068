r"""Binary files of NanoScope with force curves and force volumes.

The head has lines ``\Key: value`` in sections ``\*Name``. A section
``\*Ciao force image list`` describes the integers of one channel. In a line such as
``\@4:Z scale: V [Sens. DeflSens] (0.000375 V/LSB) 2.5 V`` the number in parentheses is
the signal per integer, and the name in brackets belongs to the line with its
sensitivity, ``\@Sens. DeflSens: V 27.39 nm/V``.

A curve consists of an approach, stored from the contact outwards, and a retraction in
the order of the measurement. Where the heights were not recorded, they follow from the
ramp, in equal steps of ``Ramp size`` over the number of points, towards the surface.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.units import LENGTHS, UNITS
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.formats.table import (
    ArrayColumn,
    CurveTable,
    Position,
    Segment,
    chosen_curve,
)

# Beginnings of files: force curves, and force volumes of electrochemistry.
_STARTS = (b"\\*Force file list", b"\\*EC File list", b"?*Force file list")
# End of the head.
_END = b"\\*File list end"
# A line of the head: a key, which may begin with a group ("@4:"), and a value.
_LINE = re.compile(r"\\(@?(?:\d:)?[^:]+):\s*(.*)")
# A number of the head.
_NUMBER = r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)"
# Name of the sensitivity, signal per integer, value.
_SCALE = re.compile(rf"V \[([^]]*)\] \({_NUMBER} \S+/LSB\)\s*{_NUMBER}")
# Value of a sensitivity, and unit per V.
_SENSITIVITY = re.compile(rf"V\s+{_NUMBER}\s*(?:(\S+)/V)?")
# Sides of an image, with the unit.
_SIZE = re.compile(rf"{_NUMBER} {_NUMBER} (\S+)")
# Channels by their names in brackets.
_CHANNELS = {
    "deflectionerror": "deflection",
    "deflection": "deflection",
    "zsensor": "height sensor",
}
# Unit of sensitivities that are written without one.
_USUAL_UNIT = "nm"
# Advice for files that can't be read.
_EXPORT = "export it as text in NanoScope Analysis, with header, ramp and deflection"

Head = Sequence[tuple[str, Mapping[str, str]]]


def is_nanoscope(data: bytes) -> bool:
    """Return whether a binary file is one of NanoScope."""
    return data.startswith(_STARTS)


def read_nanoscope(file: PathName, data: bytes, curve: int | None) -> CurveTable:
    """Return a curve of a file.

    Parameters
    ----------
    file : path
        Name of the file, for messages.
    data : bytes
        Contents of the file.
    curve : int, optional
        Number of the curve, from 1; needed for a force volume.

    Returns
    -------
    CurveTable
        Deflections in V with the sensitivity of the head, heights by the sensor or the
        ramp, and times by the velocities of the ramp.

    Raises
    ------
    ValueError
        If the file has no deflection or height, or another number of points than the
        head says, as with holds at the surface; or it has several curves and none is
        chosen.
    """
    head = _head(data)
    if _first(head, "PeakForce Capture") == "Allow":
        raise ValueError(
            f"{file} is a capture of PeakForce, without the heights of its points: "
            "export a curve as text in NanoScope Analysis"
        )
    (n, m), (width, height) = _grid(head)
    index = chosen_curve(file, curve, n * m)
    row, column = divmod(index, n)
    channels = [section for name, section in head if name == "Ciao force image list"]
    columns: dict[str, tuple[str, bool | None, FloatArray]] = {}
    points, sensitivity = (0, 0), None
    for section in channels:
        found = re.search(r"\[(\w+)]", section.get("@4:Image Data", ""))
        name = _CHANNELS.get(found[1].lower() if found else "", "")
        if not name or name in columns:
            continue
        per_integer, length = _scale(file, head, section, "@4:Z scale")
        values, points = _integers(file, data, section, index, n * m)
        if name == "deflection":
            sensitivity = length
            columns[name] = ("V", None, per_integer * values)
        else:
            nm = per_integer * length / UNITS["nm"]
            columns[name] = ("nm", None, nm * values)
    if "deflection" not in columns:
        raise ValueError(f"{file} has no channel of the deflection: {_EXPORT}")
    columns |= _ramp(file, head, points, "height sensor" not in columns)
    stiffness = _number(_first(head, "Spring Constant"))
    parts = {"approach": slice(0, points[0]), "retraction": slice(points[0], None)}
    return CurveTable(
        [
            Segment(
                kind,
                [
                    ArrayColumn(name, unit, away, values[part])
                    for name, (unit, away, values) in columns.items()
                ],
            )
            for kind, part in parts.items()
        ],
        stiffness * UNITS["N/m"] if stiffness else None,
        sensitivity,
        Position(width * column / n, height * row / m, column, row) if width else None,
        n * m,
    )


def _head(data: bytes) -> Head:
    """Return the sections of the head with their keys and values."""
    text = data[: data.find(_END)].decode("latin-1")
    sections: list[tuple[str, dict[str, str]]] = []
    for line in text.splitlines():
        if line.startswith("\\*"):
            sections.append((line[2:].strip(), {}))
        elif sections and (found := _LINE.match(line)):
            # a key that is there twice was changed later: the first one is of the data
            sections[-1][1].setdefault(found[1].strip(), found[2].strip())
    return sections


def _first(head: Head, *keys: str) -> str:
    """Return the first value of one of some keys; empty if there is no such key."""
    for _, section in head:
        for key in keys:
            if section.get(key):
                return section[key]
    return ""


def _number(text: str) -> float:
    """Return the first number of a text; zero without one."""
    found = re.search(_NUMBER, text)
    return float(found[1]) if found else 0.0


def _grid(head: Head) -> tuple[tuple[int, int], tuple[float, float]]:
    """Return numbers of curves along x and y, and the sides of their image (Å).

    A force volume has an image with a point for each curve. Sides are zero if there is
    one curve, or they are not in the head.
    """
    for name, section in head:
        if name == "Ciao image list":
            numbers = [
                section.get(key, "1") for key in ("Samps/line", "Number of lines")
            ]
            found = _SIZE.match(section.get("Scan Size", ""))
            unit = LENGTHS.get(found[3].replace("~", "µ"), 0.0) if found else 0.0
            sides = (
                (float(found[1]) * unit, float(found[2]) * unit) if found else (0, 0)
            )
            return (int(_number(numbers[0])), int(_number(numbers[1]))), sides
    return (1, 1), (0.0, 0.0)


def _scale(
    file: PathName, head: Head, section: Mapping[str, str], *keys: str
) -> tuple[float, float]:
    """Return the signal per integer (V), and its sensitivity (Å/V)."""
    found = _SCALE.match(_first([("", section)], *keys))
    if not found:
        raise ValueError(f"{file} has no {keys[0]} in its head: {_EXPORT}")
    return float(found[2]), _length_per_volt(file, head, found[1])


def _length_per_volt(file: PathName, head: Head, name: str) -> float:
    """Return a sensitivity (Å/V) by its name."""
    found = _SENSITIVITY.match(_first(head, f"@{name}"))
    unit = (found[2] or _USUAL_UNIT) if found else ""
    if not found or unit not in LENGTHS:
        raise ValueError(f"{file} has no {name} in nm/V in its head: {_EXPORT}")
    return float(found[1]) * LENGTHS[unit]


def _integers(
    file: PathName, data: bytes, section: Mapping[str, str], index: int, count: int
) -> tuple[FloatArray, tuple[int, int]]:
    """Return the integers of a curve, and the numbers of points of its branches.

    They are in the order of the measurement. Numbers are of two or four bytes: of later
    versions four although the head says two. Of two numbers of points the first one is
    of the retraction, and of both branches if the approach ended early.
    """
    numbers = [int(each) for each in re.findall(r"\d+", section.get("Samps/line", ""))]
    offset, length = (
        int(_number(section.get(key, ""))) for key in ("Data offset", "Data length")
    )
    back, towards = numbers if len(numbers) == 2 else 2 * (numbers or [0])[:1]
    for stored in (towards, back):
        of_curve = stored + back
        for size in (2, 4):
            if min(towards, back) > 0 and length == size * of_curve * count:
                start = offset + size * of_curve * index
                block = data[start : start + size * of_curve]
                values = np.frombuffer(block, f"<i{size}").astype(float)
                if len(values) == of_curve:
                    approach = values[:towards][::-1]
                    both = np.concatenate([approach, values[stored:]])
                    return both, (len(approach), back)
    raise ValueError(
        f"{file} has {length} bytes of a channel, which are not {count} x ({towards} + "
        f"{back}) points of two or four bytes in two branches, as if it had holds: "
        f"{_EXPORT}"
    )


def _ramp(
    file: PathName, head: Head, points: tuple[int, int], needed: bool
) -> dict[str, tuple[str, bool | None, FloatArray]]:
    """Return times, and if needed heights, of a ramp as far as it is in the head."""
    text = _first(head, "@4:Ramp size", "@4:Ramp Size", "@4:Ramp Size Zsweep")
    found = _SCALE.match(text)
    if not found:
        if needed:
            raise ValueError(f"{file} has neither heights nor a ramp: {_EXPORT}")
        return {}
    size, (towards, back) = float(found[3]), points
    step = size / back
    columns: dict[str, tuple[str, bool | None, FloatArray]] = {}
    if needed:
        height = np.append(np.arange(1.0 - towards, 1.0), -np.arange(back))
        nm = step * _length_per_volt(file, head, found[1]) / UNITS["nm"]
        columns["ramp"] = ("nm", False, nm * height)
    forward = _number(_first(head, "Forward vel."))
    reverse = _number(_first(head, "Reverse vel."))
    if forward and reverse:
        down = step / forward * np.arange(towards)
        up = down[-1] + _number(_first(head, "Hold Time", "Ramp delay"))
        up = up + step / reverse * np.arange(1, back + 1)
        columns["time"] = ("s", None, np.append(down, up))
    return columns
