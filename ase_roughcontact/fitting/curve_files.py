"""Measured force curves from files: quantities, units, directions, calibration."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.units import FORCES, LENGTHS, TIMES, UNITS, quantity
from ase_roughcontact._util.validation import FloatArray, positive
from ase_roughcontact.fitting.curve_tables import Column, CurveTable, read_table
from ase_roughcontact.fitting.force_curve import ForceCurve

# Relative difference up to which stiffnesses of the cantilever are the same.
_SAME_STIFFNESS = 0.02
# Part of the points at either end whose slope tells where the contact is: 1/10.
_TENTH = 10
# Names of columns by what they are, the best ones first. Whether a height is positive
# away from the surface or towards it follows from the force.
_NAMES = {
    "depth": ("depth", "penetration", "indentation"),
    "separation": ("separation", "tip-sample separation", "sep"),
    "distance": ("distance",),
    "height": (
        *("height sensor", "height (measured)", "measuredheight"),
        *("capacitivesensorheight", "straingaugeheight", "smoothedmeasuredheight"),
        *("smoothedcapacitivesensorheight", "smoothedstraingaugeheight", "zsnsr"),
        *("lvdt", "z sensor", "height", "height (piezo)", "piezo", "z piezo"),
        *("calc ramp", "ramp", "z"),
    ),
    "deflection": ("deflection", "defl", "vertical deflection", "vdeflection"),
    "force": ("force", "normal_force", "f"),
}
# The same of curves in time; others may have times of day.
_NAMES_IN_TIME = _NAMES | {"time": ("time",)}


def read_curve(
    file: PathName,
    branch: str | None = None,
    stiffness: float | None = None,
    sensitivity: str = "",
    heads: Sequence[str] = (),
) -> ForceCurve:
    """Read a force curve.

    Parameters
    ----------
    file : path
        A table with names of columns, separated by commas, or by semicolons, tabs or
        blanks with decimal points or commas. Columns are ``depth (nm)``, or the
        ``separation (nm)`` of tip and surface, and ``force (nN)``; or ``distance (nm)``
        of the base, or its height, with ``deflection (nm)`` of the cantilever, also in
        V, and ``force (nN)``, one of which may be left out if the stiffness is known;
        or those of ``curve.csv``. Or a text export of NanoScope or JPK, or, with
        afmformats, a file of an instrument, with approach and retraction.
    branch : str, optional
        "approach" or "retraction".
    stiffness : float, optional
        Of the cantilever (eV/Å^2). By default it is that of the file, or of forces and
        deflections, infinite without the latter.
    sensitivity : str, optional
        Deflection per V: ``"50 nm/V"``; by default that of the file.
    heads : sequence of str
        Names and units of the columns in place of those in the file.

    Returns
    -------
    ForceCurve

    Raises
    ------
    ValueError
        If a column or its unit is missing, a value is not a finite number, or forces
        over deflections are not the stiffness.
    """
    table = read_table(file, branch, heads)
    found, stiffness = _found(file, table, stiffness, sensitivity)
    force, depth, bend = (found.get(k) for k in ("force", "depth", "deflection"))
    if bend is not None and force is not None and np.ptp(bend) > 0.0:
        # a slope, as either may have another zero
        slope = float(np.polyfit(bend, force, 1)[0])
        stiffness = _checked(file, slope, stiffness, "forces over deflections give")
    if stiffness is not None:
        if force is None and bend is not None:
            force = stiffness * bend
        if bend is None and force is not None:
            bend = force / stiffness
    if depth is None and bend is not None and "distance" in found:
        depth = -(found["distance"] + bend)
    if force is None or depth is None:
        columns = "distance (nm) or height (nm), and force (nN) or deflection (nm), or "
        message = _missing(file, table, columns + "depth (nm) and force (nN)")
        if stiffness is None:
            message += (
                ". Without deflection or force the scene needs the stiffness of the "
                'cantilever, as deflection = force/stiffness: [path] kind = "loop" and '
                'cantilever = "5 N/m"'
            )
        raise ValueError(message)
    return ForceCurve(depth, force, math.inf if stiffness is None else stiffness)


def read_in_time(
    file: PathName,
    kind: str,
    branch: str | None = None,
    stiffness: float | None = None,
    sensitivity: str = "",
    heads: Sequence[str] = (),
) -> tuple[FloatArray, FloatArray]:
    """Read a force or a depth over time.

    Parameters
    ----------
    file : path
        A table as of `read_curve`, with the column ``time (s)``.
    kind : {"force", "depth"}
        A force may be given by the deflection, if the stiffness is known.
    branch, stiffness, sensitivity, heads
        See `read_curve`.

    Returns
    -------
    time, values : ndarray, shape (k,)
        s, and eV/Å or Å.

    Raises
    ------
    ValueError
        If a column or its unit is missing, or a value is not a finite number.
    """
    table = read_table(file, branch, heads)
    found, stiffness = _found(file, table, stiffness, sensitivity, _NAMES_IN_TIME)
    if stiffness is not None and "deflection" in found:
        found.setdefault("force", stiffness * found["deflection"])
    if not {"time", kind} <= set(found):
        unit = "nN" if kind == "force" else "nm"
        raise ValueError(_missing(file, table, f"time (s) and {kind} ({unit})"))
    return found["time"], found[kind]


def _found(
    file: PathName,
    table: CurveTable,
    stiffness: float | None,
    sensitivity: str,
    known: Mapping[str, tuple[str, ...]] = _NAMES,
) -> tuple[dict[str, FloatArray], float | None]:
    """Return the quantities of all parts of a curve, and the stiffness."""
    stiffness, length = _calibration(file, table, stiffness, sensitivity)
    parts = []
    for way, columns in table.segments:
        part = _quantities(file, columns, length, known)
        if way is not None and "distance" in part:
            falls = part["distance"][0] > part["distance"][-1]
            if falls != (way == "approach"):  # as NanoScope may write it
                part = {name: values[::-1] for name, values in part.items()}
        parts.append(part)
    common = set(parts[0]).intersection(*parts)
    return {k: np.concatenate([part[k] for part in parts]) for k in common}, stiffness


def _calibration(
    file: PathName, table: CurveTable, stiffness: float | None, sensitivity: str
) -> tuple[float | None, float | None]:
    """Return the stiffness of the cantilever, and its deflection per V (Å)."""
    if table.stiffness is not None:
        stiffness = _checked(file, table.stiffness, stiffness, "its header gives")
    if not sensitivity:
        return stiffness, table.sensitivity
    units = {f"{unit}/V": value for unit, value in LENGTHS.items()}
    length = quantity("sensitivity", sensitivity, units, "nm/V")
    positive(sensitivity=length)
    return stiffness, length


def _quantities(
    file: PathName,
    columns: Sequence[Column],
    sensitivity: float | None,
    known: Mapping[str, tuple[str, ...]],
) -> dict[str, FloatArray]:
    """Return depth, distance, deflection and force as far as there are columns.

    Of several columns of a quantity the best one is taken.
    """
    found: dict[str, FloatArray] = {}
    doubts = []  # columns without a unit that is known
    for name in (name for names in known.values() for name in names):
        for column in (each for each in columns if each.name == name):
            kind = next(kind for kind, names in known.items() if name in names)
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
    if "separation" in found:  # of tip and surface
        found.setdefault("depth", -found.pop("separation"))
    if "height" in found:
        found.setdefault("distance", _away(found.pop("height"), found))
    has_force, has_depth = (
        not set(names).isdisjoint(found)
        for names in (("force", "deflection"), ("depth", "distance"))
    )
    if doubts and not (has_force and has_depth):
        raise ValueError(_without_units(file, doubts))
    return found


def _away(height: FloatArray, found: Mapping[str, FloatArray]) -> FloatArray:
    """Return heights that are positive away from the surface.

    In contact, where the force is steepest, it falls with the height of the base.
    """
    force = found.get("force", found.get("deflection"))
    if force is None:
        return height
    order, count = np.argsort(height), max(len(height) // _TENTH, 2)
    slopes = [
        np.polyfit(height[end] - height[end].mean(), force[end], 1)[0]
        for end in (order[:count], order[-count:])
    ]
    return height if max(slopes, key=abs) < 0.0 else -height


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


def _checked(
    file: PathName, found: float, stiffness: float | None, source: str
) -> float:
    """Return the stiffness of a cantilever, which a file must not contradict."""
    if stiffness is None:
        return found
    if not math.isclose(found, stiffness, rel_tol=_SAME_STIFFNESS):
        unit = UNITS["N/m"]
        raise ValueError(
            f"{file}: {source} a cantilever of {found / unit:.4g} N/m, the scene or "
            f"its header {stiffness / unit:.4g} N/m: correct cantilever in [path], or "
            "what is wrong in the file"
        )
    return stiffness


def _missing(file: PathName, table: CurveTable, columns: str) -> str:
    """Return the message for a table without the necessary columns."""
    heads = ", ".join(column.head for column in table.segments[0][1])
    return (
        f"{file} needs the columns {columns}, got {heads}: rename them, or give names "
        "and units of all columns: --columns"
    )
