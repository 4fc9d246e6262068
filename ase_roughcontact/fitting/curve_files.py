"""Force curves, and forces over time, from files of measurements."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.fitting.formats.table import CurveTable
from ase_roughcontact.fitting.measurement import (
    NAMES,
    NAMES_IN_TIME,
    Measurement,
    checked_stiffness,
    given_calibration,
    read_measurement,
    without_holds,
)


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
    given = given_calibration(stiffness, sensitivity)
    read = without_holds(read_measurement(file, given, heads, curve, NAMES))
    turn = None
    if all(part.kind is not None for part in read.parts):
        turn = sum(part.count for part in read.parts if part.kind == "approach")
    whole = _force_curve(file, read, turn)
    try:
        return whole if branch is None else whole.only(branch)
    except ValueError as error:
        raise ValueError(f"{file}: {error}") from error


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
    given = given_calibration(stiffness, sensitivity)
    read = read_measurement(file, given, heads, curve, NAMES_IN_TIME)
    if branch is not None:
        kept = [part for part in read.parts if part.kind == branch]
        if not kept:
            raise ValueError(
                f"{file}: there are no points of the {branch}: leave out --branch"
            )
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
    given = given_calibration(stiffness, sensitivity)
    read = read_measurement(file, given, heads, curve, NAMES_IN_TIME)
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


def _force_curve(file: PathName, read: Measurement, turn: int | None) -> ForceCurve:
    """Return the force curve of a measurement, from the quantities that it has."""
    found, known = read.joined(), read.stiffness
    force, depth, bend = (found.get(k) for k in ("force", "depth", "deflection"))
    if bend is not None and force is not None and np.ptp(bend) > 0.0:
        # a slope, as either may have another zero
        slope = float(np.polyfit(bend, force, 1)[0])
        known = checked_stiffness(file, slope, known)
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
    position = read.table.position
    curve = ForceCurve(depth, force, stiffness, turn, read.remarks, position)
    return curve.approach_first


def _incomplete(file: PathName, read: Measurement) -> str:
    """Return the message for a file without a force or a depth."""
    found = read.joined()
    is_complete = "distance" in found and found.keys() & {"force", "deflection"}
    if is_complete and read.stiffness is None:
        return (
            f"{file} does not have the spring constant of the cantilever (deflection = "
            'force/stiffness): give --cantilever "5 N/m", or for a scene '
            "cantilever_stiffness in [path]"
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
