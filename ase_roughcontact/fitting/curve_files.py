"""Measured force curves from files: quantities, units, directions, calibration."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.units import FORCES, LENGTHS, TIMES, UNITS, quantity
from ase_roughcontact._util.validation import FloatArray, positive
from ase_roughcontact.fitting.calibration import recalibration
from ase_roughcontact.fitting.direction import Heights, increases_away, is_reversed
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.fitting.formats.reader import read_table
from ase_roughcontact.fitting.formats.table import (
    Calibration,
    Column,
    CurveTable,
    Segment,
)

# Relative difference up to which stiffnesses of the cantilever are the same.
_SAME_STIFFNESS = 0.02
# Names of columns by quantity, the best ones first. An indentation is zero before the
# contact, and therefore the last choice.
_NAMES = {
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
# Names of columns of curves in time; other curves may have times of day.
_NAMES_IN_TIME = _NAMES | {"time": ("time",)}


@dataclass(frozen=True, eq=False)
class _Part:
    """Quantities of a segment: depth, distance, deflection, force, time."""

    kind: str | None
    found: dict[str, FloatArray]

    @property
    def count(self) -> int:
        """Number of points."""
        return len(next(iter(self.found.values()), ()))


@dataclass(frozen=True, eq=False)
class _Measurement:
    """Quantities of the segments of a file, calibrated.

    Attributes
    ----------
    parts : list of _Part
        Quantities of each segment, in the order of the measurement.
    stiffness : float or None
        Spring constant of the cantilever (eV/Å^2), if it is known.
    remarks : tuple of str
        Remarks on what was left out or changed.
    table : CurveTable
        Contents of the file.
    """

    parts: list[_Part]
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


def read_curve(
    file: PathName,
    branch: str | None = None,
    stiffness: float | None = None,
    sensitivity: str = "",
    heads: Sequence[str] = (),
    curve: int | str | None = None,
) -> ForceCurve:
    """Read a force curve.

    Parameters
    ----------
    file : path
        A table with names of columns, separated by commas, or by semicolons, tabs or
        blanks with decimal points or commas. Columns are ``depth (nm)``, or the
        ``separation (nm)`` of tip and surface, and ``force (nN)``; or ``distance (nm)``
        of the base, or its height, with ``deflection (nm)`` of the cantilever, also in
        V, and ``force (nN)``: one of the two may be left out if the stiffness is known;
        or the columns of ``curve.csv``. Or a text export of NanoScope, JPK or Chiaro,
        or, with the extra ``curves``, a file of an instrument; or a zip archive of such
        files.
    branch : str, optional
        "approach" or "retraction". Holds between them are left out.
    stiffness : float, optional
        Spring constant of the cantilever (eV/Å^2); by default the value in the file, or
        the ratio of forces and deflections, infinite without deflections. A value other
        than in the file recalibrates the forces.
    sensitivity : str, optional
        Deflection per V: ``"50 nm/V"``, for NT-MDT per nA; by default the value in the
        file. A value other than in the file recalibrates deflections and forces.
    heads : sequence of str
        Names and units of the columns in place of those in the file.
    curve : int or str, optional
        Number of the curve in the file, from 1; in an archive also the name of a file.

    Returns
    -------
    ForceCurve
        The curve, with `remarks` on what was left out or changed.

    Raises
    ------
    ValueError
        If a column or its unit is missing, a value is not a finite number, there are
        several curves and none is chosen, or forces over deflections are not the
        stiffness.
    ImportError
        If a package that reads the format is missing.
    """
    given = _given(stiffness, sensitivity)
    read = _without_holds(_measurement(file, given, heads, curve, _NAMES))
    turn = None
    if all(part.kind is not None for part in read.parts):
        turn = sum(part.count for part in read.parts if part.kind == "approach")
    whole = _force_curve(file, read, turn)
    return whole if branch is None else _only(file, whole, branch)


def read_in_time(
    file: PathName,
    kind: str,
    branch: str | None = None,
    stiffness: float | None = None,
    sensitivity: str = "",
    heads: Sequence[str] = (),
    curve: int | str | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Read a force or a depth over time.

    Parameters
    ----------
    file : path
        File as for `read_curve`, with times: a table needs the column ``time (s)``.
    kind : {"force", "depth"}
        Quantity to read. A force may follow from the deflection, if the stiffness is
        known, a depth from the distance of the base and a force.
    branch, stiffness, sensitivity, heads, curve
        See `read_curve`. Holds are kept, unless a branch is chosen.

    Returns
    -------
    time, values : ndarray, shape (k,)
        Times (s), and forces (eV/Å) or depths (Å).

    Raises
    ------
    ValueError
        If a column or its unit is missing, or a value is not a finite number.
    """
    given = _given(stiffness, sensitivity)
    read = _measurement(file, given, heads, curve, _NAMES_IN_TIME)
    if branch is not None:
        kept = [part for part in read.parts if part.kind == branch]
        if not kept:
            raise ValueError(_no_branch(file, branch))
        read = replace(read, parts=kept)
    found, known = read.joined(), read.stiffness
    if known is not None and "deflection" in found:
        found.setdefault("force", known * found["deflection"])
    if known is not None and {"distance", "force"} <= set(found):
        found.setdefault("depth", -(found["distance"] + found["force"] / known))
    if "indentation" in found:
        found.setdefault("depth", found["indentation"])
    if not {"time", kind} <= set(found):
        unit = "nN" if kind == "force" else "nm"
        raise ValueError(_missing(file, read.table, f"time (s) and {kind} ({unit})"))
    return found["time"], found[kind]


def read_with_times(
    file: PathName,
    stiffness: float | None = None,
    sensitivity: str = "",
    heads: Sequence[str] = (),
    curve: int | str | None = None,
) -> tuple[FloatArray, ForceCurve]:
    """Read approach and hold of a force curve with the times in the file.

    Parameters
    ----------
    file, stiffness, sensitivity, heads, curve
        See `read_curve`.

    Returns
    -------
    time : ndarray, shape (k,)
        Times of the points (s).
    curve : ForceCurve
        Approach and hold, without earlier points and without the retraction.

    Raises
    ------
    ValueError
        If the file has no times, or as in `read_curve`.
    """
    given = _given(stiffness, sensitivity)
    read = _measurement(file, given, heads, curve, _NAMES_IN_TIME)
    kinds = [part.kind for part in read.parts]
    if "approach" not in kinds:
        raise ValueError(
            f"{file} does not say which of its points are the approach and the hold: "
            "give a column branch (approach, hold, retraction)"
        )
    end = kinds.index("retraction") if "retraction" in kinds else len(kinds)
    read = replace(read, parts=read.parts[kinds.index("approach") : end])
    found = read.joined()
    if "time" not in found:
        raise ValueError(_missing(file, read.table, "time (s)"))
    return found["time"], _force_curve(file, read, len(found["time"]))


def _force_curve(file: PathName, read: _Measurement, turn: int | None) -> ForceCurve:
    """Return the force curve of a measurement, from the quantities that it has."""
    found, known = read.joined(), read.stiffness
    force, depth, bend = (found.get(k) for k in ("force", "depth", "deflection"))
    if bend is not None and force is not None and np.ptp(bend) > 0.0:
        # a slope, as either may have another zero
        slope = float(np.polyfit(bend, force, 1)[0])
        known = _checked(file, slope, known)
    if known is not None:
        if force is None and bend is not None:
            force = known * bend
        if bend is None and force is not None:
            bend = force / known
    if depth is None and bend is not None and "distance" in found:
        depth = -(found["distance"] + bend)
    if depth is None:
        depth = found.get("indentation")
    if force is None or depth is None:
        raise ValueError(_incomplete(file, read))
    stiffness = math.inf if known is None else known
    return ForceCurve(depth, force, stiffness, turn, read.remarks)


def _given(stiffness: float | None, sensitivity: str) -> Calibration:
    """Return the calibration that a user gives."""
    if not sensitivity:
        return Calibration(stiffness)
    per = "nA" if sensitivity.rstrip().endswith("/nA") else "V"
    units = {f"{unit}/{per}": value for unit, value in LENGTHS.items()}
    length = quantity("sensitivity", sensitivity, units, "nm/V")
    positive(sensitivity=length)
    # afmformats takes signals in A
    return Calibration(stiffness, length * (1e9 if per == "nA" else 1.0), per)


def _measurement(
    file: PathName,
    given: Calibration,
    heads: Sequence[str],
    curve: int | str | None,
    known: Mapping[str, tuple[str, ...]],
) -> _Measurement:
    """Return the quantities of all segments, in the order of the measurement."""
    table = read_table(file, heads, curve, given)
    calibrated = recalibration(file, table, given)
    length = table.sensitivity or given.sensitivity
    parts = [
        _Part(segment.kind, _quantities(file, segment, length, known))
        for segment in table.segments
    ]
    _check_slope(file, table, parts)
    parts = [replace(part, found=calibrated.of(part.found)) for part in parts]
    parts, remarks = _directed(parts, _away(table, parts, known))
    return _Measurement(
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
    parts: Sequence[_Part],
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


def _directed(parts: Sequence[_Part], away: bool) -> tuple[list[_Part], list[str]]:
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
        directed.append(_Part(part.kind, found))
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


def _without_holds(read: _Measurement) -> _Measurement:
    """Return a measurement without its holds, and remarks on them."""
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


def _only(file: PathName, curve: ForceCurve, branch: str) -> ForceCurve:
    """Return one branch of a curve."""
    direction = {"approach": -1.0, "retraction": 1.0}[branch]
    for each in curve.branches:
        if each.direction == direction:
            turn = each.points.stop - each.points.start if direction < 0.0 else 0
            return replace(
                curve,
                depth=curve.depth[each.points],
                force=curve.force[each.points],
                turn=turn,
            )
    raise ValueError(_no_branch(file, branch))


def _no_branch(file: PathName, branch: str) -> str:
    return f"{file} contains no points of the branch {branch!r}: leave out --branch"


def _check_slope(file: PathName, table: CurveTable, parts: Sequence[_Part]) -> None:
    """Raise `ValueError` if forces over deflections differ from the header's value."""
    for part in parts:
        bend, force = part.found.get("deflection"), part.found.get("force")
        if bend is None or force is None or not np.ptp(bend) > 0.0:
            continue
        if table.stiffness:
            _checked(file, float(np.polyfit(bend, force, 1)[0]), table.stiffness)


def _checked(file: PathName, found: float, stiffness: float | None) -> float:
    """Return the stiffness of a cantilever, which the columns must not contradict."""
    if stiffness is None:
        return found
    if not math.isclose(found, stiffness, rel_tol=_SAME_STIFFNESS):
        unit = UNITS["N/m"]
        raise ValueError(
            f"{file}: forces over deflections give a cantilever of {found / unit:.4g} "
            f"N/m, the scene or its header {stiffness / unit:.4g} N/m: correct "
            "cantilever in [path], or what is wrong in the file"
        )
    return stiffness


def _without_units(file: PathName, columns: Sequence[Column]) -> str:
    """Return the message for columns that can't be converted."""
    if all(column.unit in ("V", "mV") for column in columns):
        return (
            f"{file}: {columns[0].head} needs the sensitivity of the instrument: "
            '--sensitivity "50 nm/V"'
        )
    texts = [
        f"{column.head} has "
        + (f"the unknown unit {column.unit!r}" if column.unit else "no unit")
        for column in columns
    ]
    return (
        f"{file}: {', '.join(texts)}. Write it behind the names in the first line, "
        '"Height (nm)", or give names and units of all columns: --columns "height '
        '(nm), deflection (nm)"; lengths may be in nm, um or m, forces in pN, nN or N, '
        "deflections also in V"
    )


def _incomplete(file: PathName, read: _Measurement) -> str:
    """Return the message for a file without a force or a depth."""
    found = read.joined()
    is_complete = "distance" in found and found.keys() & {"force", "deflection"}
    if is_complete and read.stiffness is None:
        return (
            f"{file} does not have the spring constant of the cantilever (deflection = "
            'force/stiffness): give [path] kind = "loop" and cantilever = "5 N/m" in '
            "the scene"
        )
    columns = "distance (nm) or height (nm), and force (nN) or deflection (nm), or "
    return _missing(file, read.table, columns + "depth (nm) and force (nN)")


def _missing(file: PathName, table: CurveTable, columns: str) -> str:
    """Return the message for a table without the necessary columns."""
    heads = ", ".join(column.head for column in table.segments[0].columns)
    return (
        f"{file} needs the columns {columns}, got {heads}: rename them, or give names "
        "and units of all columns: --columns"
    )
