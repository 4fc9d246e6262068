"""Measured quantities in a file of a force curve: units, directions, calibration."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.units import FORCES, LENGTHS, TIMES, UNITS, quantity
from ase_roughcontact._util.validation import FloatArray, positive
from ase_roughcontact.fitting.calibration import recalibration
from ase_roughcontact.fitting.direction import Heights, increases_away, is_reversed
from ase_roughcontact.fitting.formats.reader import read_table
from ase_roughcontact.fitting.formats.table import (
    Calibration,
    Column,
    CurveTable,
    Segment,
)

# Largest relative difference of equal stiffnesses of the cantilever.
_MAX_STIFFNESS_DIFFERENCE = 0.02
#: Names of columns by quantity, the best ones first. An indentation is zero before the
#: contact, and therefore the last choice.
NAMES = {
    "depth": ("depth", "penetration"),
    "indentation": ("indentation",),
    "separation": ("separation", "tip-sample separation", "sep"),
    "height": (
        "distance",
        "height sensor",
        "height (measured)",
        "measuredheight",
        "capacitivesensorheight",
        "straingaugeheight",
        "smoothedmeasuredheight",
        "smoothedcapacitivesensorheight",
        "smoothedstraingaugeheight",
        "zsnsr",
        "lvdt",
        "z sensor",
        "height",
        "height (piezo)",
        "piezo",
        "z piezo",
        "calc ramp",
        "ramp",
        "z",
    ),
    "deflection": ("deflection", "defl", "vertical deflection", "vdeflection"),
    "force": ("force", "normal_force", "load", "f"),
}
#: Names of columns of curves in time; other curves may have times of day.
NAMES_IN_TIME = NAMES | {"time": ("time",)}


@dataclass(frozen=True, eq=False)
class Part(Summarized):
    """Quantities of a segment.

    Attributes
    ----------
    kind : str or None
        Kind of the segment, see `Segment`.
    found : dict of ndarray
        Points of "depth", "distance", "deflection" and "indentation" (Å), "force"
        (eV/Å) and "time" (s), as far as they are known.
    """

    kind: str | None
    found: dict[str, FloatArray]

    @property
    def count(self) -> int:
        """Number of points."""
        return len(next(iter(self.found.values()), ()))


@dataclass(frozen=True, eq=False)
class Measurement(Summarized):
    """Quantities of the segments of a file, calibrated.

    Attributes
    ----------
    parts : list of Part
        Quantities of each segment, in the order of the measurement.
    stiffness : float or None
        Spring constant of the cantilever (eV/Å^2), if it is known.
    remarks : tuple of str
        Remarks on what was left out or changed.
    table : CurveTable
        Contents of the file.
    """

    parts: list[Part]
    stiffness: float | None
    remarks: tuple[str, ...]
    table: CurveTable

    def joined(self) -> dict[str, FloatArray]:
        """Return the quantities that all segments have, one after the other."""
        common = set(self.parts[0].found)
        for part in self.parts:
            common &= set(part.found)
        return {
            name: np.concatenate([part.found[name] for part in self.parts])
            for name in common
        }


def given_calibration(stiffness: float | None, sensitivity: str) -> Calibration:
    """Return the calibration that a user gives.

    Parameters
    ----------
    stiffness : float or None
        Spring constant of the cantilever (eV/Å^2).
    sensitivity : str
        Deflection per V or per nA, ``"50 nm/V"``; empty if it is not given.

    Returns
    -------
    Calibration

    Raises
    ------
    ValueError
        If the unit of the sensitivity is unknown, or its value not positive.
    """
    if not sensitivity:
        return Calibration(stiffness)
    per = "nA" if sensitivity.rstrip().endswith("/nA") else "V"
    units = {f"{unit}/{per}": value for unit, value in LENGTHS.items()}
    length = quantity("sensitivity", sensitivity, units, "nm/V")
    positive(sensitivity=length)
    # afmformats takes signals in A
    return Calibration(stiffness, length * (1e9 if per == "nA" else 1.0), per)


def read_measurement(
    file: PathName,
    given: Calibration,
    heads: Sequence[str],
    curve: int | str | None,
    known: Mapping[str, tuple[str, ...]],
) -> Measurement:
    """Return the quantities of all segments, in the order of the measurement.

    Parameters
    ----------
    file, heads, curve
        See `read_table`.
    given : Calibration
        Calibration that replaces the calibration of the file.
    known : mapping of str to tuple of str
        Names of columns by quantity, `NAMES` or `NAMES_IN_TIME`.

    Returns
    -------
    Measurement

    Raises
    ------
    ValueError
        If the unit of a column is missing, a value is not a finite number, or forces
        over deflections are not the stiffness.
    """
    table = read_table(file, heads, curve, given)
    calibrated = recalibration(file, table, given)
    length = table.sensitivity or given.sensitivity
    parts = [
        Part(segment.kind, _quantities(file, segment, length, known))
        for segment in table.segments
    ]
    _check_slope(file, table, parts)
    parts = [replace(part, found=calibrated.of(part.found)) for part in parts]
    parts, remarks = _directed(parts, _away(table, parts, known))
    return Measurement(
        parts, calibrated.stiffness, (*calibrated.remarks, *remarks), table
    )


def _quantities(
    file: PathName,
    segment: Segment,
    sensitivity: float | None,
    known: Mapping[str, tuple[str, ...]],
) -> dict[str, FloatArray]:
    """Return depth, height, deflection, force and time as far as there are columns.

    If a quantity has several columns, the best one is taken.
    """
    found: dict[str, FloatArray] = {}
    doubts = []  # columns without a known unit
    for kind, column in _ordered(segment.columns, known):
        unit = column.unit or ""
        if kind == "deflection" and unit in FORCES:
            kind = "force"
        units = {"force": FORCES, "time": {"": 1.0, **TIMES}}.get(kind, LENGTHS)
        if kind == "deflection" and sensitivity:
            units = units | {"V": sensitivity, "mV": 1e-3 * sensitivity}
        if unit in units and kind not in found:
            found[kind] = units[unit] * column.numbers(file)
        elif unit not in units:
            doubts.append(column)
    if "separation" in found:  # distance of tip and surface
        found.setdefault("depth", -found.pop("separation"))
    has_force = bool(found.keys() & {"force", "deflection"})
    has_depth = bool(found.keys() & {"depth", "indentation", "height"})
    if doubts and not (has_force and has_depth):
        raise ValueError(_without_units(file, doubts))
    return found


def _ordered(
    columns: Sequence[Column], known: Mapping[str, tuple[str, ...]]
) -> list[tuple[str, Column]]:
    """Return the quantities of columns, the best ones first."""
    return [
        (kind, column)
        for kind, names in known.items()
        for name in names
        for column in columns
        if column.name == name
    ]


def _away(
    table: CurveTable,
    parts: Sequence[Part],
    known: Mapping[str, tuple[str, ...]],
) -> bool:
    """Return whether heights increase away from the surface, one answer for a file."""
    first = table.segments[0].columns
    for kind, column in _ordered(first, known):
        if kind == "height" and (column.unit or "") in LENGTHS:
            if column.away is not None:
                return column.away
            break
    heights = []
    for part in parts:
        height = part.found.get("height")
        force = part.found.get("force", part.found.get("deflection"))
        if height is not None and force is not None and len(height):
            heights.append(Heights(part.kind, height, force))
    return increases_away(heights) if heights else True


def _directed(parts: Sequence[Part], away: bool) -> tuple[list[Part], list[str]]:
    """Return segments with distances in place of heights, in the order of time."""
    directed, backwards = [], []
    for part in parts:
        found = dict(part.found)
        height = found.pop("height", None)
        if height is not None:
            found["distance"] = height if away else -height
            if "time" not in found and is_reversed(part.kind, found["distance"]):
                backwards.append(part.kind)
                found = {name: values[::-1] for name, values in found.items()}
        directed.append(Part(part.kind, found))
    remarks = [
        f"the {kind} is written against the order of the measurement, and was turned"
        for kind in backwards
    ]
    if {"approach", "retraction"} <= set(backwards):
        remarks = [
            "the approach moves away from the surface, and the retraction towards it: "
            "are the branches swapped? If the height increases towards the surface, "
            "name it ramp (nm)"
        ]
    return directed, remarks


def without_holds(read: Measurement) -> Measurement:
    """Return a measurement without its holds, and with remarks on them.

    Raises
    ------
    ValueError
        If nothing is left.
    """
    remarks, kept = list(read.remarks), []
    for part in read.parts:
        if part.kind != "hold":
            kept.append(part)
            continue
        when = "between" if kept else "before"
        remarks.append(
            f"a hold of {part.count} points {when} the branches is left out; fits over "
            "time keep it"
        )
    if not kept:
        raise ValueError("the curve has neither an approach nor a retraction")
    return replace(read, parts=kept, remarks=tuple(remarks))


def _check_slope(file: PathName, table: CurveTable, parts: Sequence[Part]) -> None:
    """Raise `ValueError` if forces over deflections differ from the header's value."""
    for part in parts:
        bend, force = part.found.get("deflection"), part.found.get("force")
        if bend is None or force is None or not np.ptp(bend) > 0.0:
            continue
        if table.stiffness:
            checked_stiffness(
                file, float(np.polyfit(bend, force, 1)[0]), table.stiffness
            )


def checked_stiffness(file: PathName, found: float, stiffness: float | None) -> float:
    """Return the stiffness of a cantilever, which the columns must not contradict.

    Parameters
    ----------
    file : path
        Name of the file, for messages.
    found : float
        Slope of the forces over the deflections (eV/Å^2).
    stiffness : float or None
        Stiffness by the header or the user (eV/Å^2), if it is known.

    Raises
    ------
    ValueError
        If they differ by more than 2 %.
    """
    if stiffness is None:
        return found
    if not math.isclose(found, stiffness, rel_tol=_MAX_STIFFNESS_DIFFERENCE):
        unit = UNITS["N/m"]
        raise ValueError(
            f"{file}: forces over deflections give a cantilever of {found / unit:.4g} "
            f"N/m, the scene or its header {stiffness / unit:.4g} N/m: correct "
            "cantilever_stiffness in [path], or the file"
        )
    return stiffness


def _without_units(file: PathName, columns: Sequence[Column]) -> str:
    """Return the message for columns that can't be converted."""
    if all(column.unit in ("V", "mV") for column in columns):
        return (
            f"{file}: {columns[0].head} needs the sensitivity of the instrument: "
            '--sensitivity "50 nm/V"'
        )
    texts = []
    for column in columns:
        unit = f"the unknown unit {column.unit!r}" if column.unit else "no unit"
        texts.append(f"{column.head} has {unit}")
    return (
        f"{file}: {', '.join(texts)}. Write units behind the names in the first line, "
        'such as "Height (nm)", or give names and units of all columns: --columns '
        '"height (nm), deflection (nm)"; lengths may be in nm, um or m, forces in pN, '
        "nN or N, deflections also in V"
    )
