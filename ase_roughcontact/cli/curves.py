"""Measured force curves from CSV files."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

import numpy as np

from ase_roughcontact._util.units import FORCES, LENGTHS, UNITS
from ase_roughcontact._util.validation import FloatArray, finite, lookup, shown
from ase_roughcontact.scene.force_curve import ForceCurve

# Key of the number of a line in its row.
_LINE = "line of the file"
# Relative difference up to which stiffnesses of the cantilever are the same.
_SAME_STIFFNESS = 0.02
_HEAD = re.compile(r"\s*([^([]*?)\s*(?:[([](.*)[])])?\s*")


def read_curve(
    file: Path, branch: str | None = None, stiffness: float | None = None
) -> ForceCurve:
    """Read a force curve.

    Parameters
    ----------
    file : path
        CSV with a header, separated by commas, or by semicolons or tabs with decimal
        points or commas; lines that begin with # are left out. Columns are ``depth
        (nm)`` and ``force (nN)``; or ``distance (nm)`` of the base with ``deflection
        (nm)`` of the cantilever and ``force (nN)``, one of which may be left out if the
        stiffness is given; or those of ``curve.csv``. Units are in parentheses or
        brackets.
    branch : str, optional
        Value of the column ``branch``: "approach" or "retraction".
    stiffness : float, optional
        Of the cantilever (eV/Å^2). By default it is that of forces and deflections,
        infinite without the latter.

    Returns
    -------
    ForceCurve

    Raises
    ------
    ValueError
        If a column is missing, a value is not a finite number, or forces over
        deflections are not the stiffness.
    """
    rows = _rows(file)
    if branch is not None:
        rows = [row for row in rows if row.get("branch") == branch]
        if not rows:
            raise ValueError(f"{file} contains no rows of the branch {branch!r}")
    columns: dict[str, FloatArray] = {}
    for head in rows[0]:
        found = _HEAD.fullmatch(head or "")
        name, unit = (found[1].lower(), found[2]) if found else ("", None)
        if name in _COLUMNS:
            default, units = _COLUMNS[name]
            factor = lookup(unit or default, units, f"unit of {name}")
            columns[name] = factor * _numbers(file, head, rows)
    force = columns.get("force", columns.get("normal_force"))
    depth = columns.get("depth", columns.get("penetration"))
    bend = columns.get("deflection")
    if bend is not None and force is not None and np.ptp(bend) > 0.0:
        # a slope, as either may have another zero
        stiffness = _checked(file, float(np.polyfit(bend, force, 1)[0]), stiffness)
    if stiffness is not None:
        if force is None and bend is not None:
            force = stiffness * bend
        if bend is None and force is not None:
            bend = force / stiffness
    if depth is None and bend is not None and "distance" in columns:
        depth = -(columns["distance"] + bend)
    if force is None or depth is None:
        raise ValueError(_missing(file, list(rows[0]), stiffness))
    return ForceCurve(depth, force, math.inf if stiffness is None else stiffness)


def _rows(file: Path) -> list[dict]:
    """Return the rows by the heads of the columns, with their lines under `_LINE`."""
    text = file.read_text(encoding="utf-8-sig", errors="replace")
    lines = {
        number: line
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and line[0] != "#"
    }
    head = next(iter(lines.values()), "")
    rows = csv.DictReader(lines.values(), delimiter=max(",;\t", key=head.count))
    numbered = [
        {**row, _LINE: number}
        for row, number in zip(rows, list(lines)[1:], strict=False)
    ]
    if not numbered:
        raise ValueError(f"{file} contains no rows")
    return numbered


def _checked(file: Path, slope: float, stiffness: float | None) -> float:
    """Return the stiffness of a cantilever, which a table must not contradict."""
    if stiffness is None:
        return slope
    if not math.isclose(slope, stiffness, rel_tol=_SAME_STIFFNESS):
        unit = UNITS["N/m"]
        raise ValueError(
            f"{file}: forces over deflections give a cantilever of {slope / unit:.4g} "
            f"N/m, the scene {stiffness / unit:.4g} N/m: correct cantilever in [path], "
            "or leave out the column that is wrong"
        )
    return stiffness


def _missing(file: Path, heads: list, stiffness: float | None) -> str:
    """Return the message for a table without the necessary columns."""
    got = ", ".join(str(head) for head in heads if head != _LINE)
    message = (
        f"{file} needs the columns distance (nm) and force (nN), or distance (nm) and "
        f"deflection (nm), or depth (nm) and force (nN), got {got}: rename them, such "
        "as the height of the piezo, positive away from the surface, to distance"
    )
    if stiffness is None:
        message += (
            ". Without deflection or force the scene needs the stiffness of the "
            'cantilever, as deflection = force/stiffness: [path] kind = "loop" and '
            'cantilever = "5 N/m"'
        )
    return message


# Columns with their default unit, that of curve.csv, and the known ones.
_COLUMNS = {
    "depth": ("nm", LENGTHS),
    "distance": ("nm", LENGTHS),
    "deflection": ("nm", LENGTHS),
    "force": ("nN", FORCES),
    "penetration": ("Å", LENGTHS),
    "normal_force": ("eV/Å", FORCES),
}


def _numbers(file: Path, head: str, rows: list[dict]) -> FloatArray:
    numbers = []
    for row in rows:
        try:
            number = float(row[head].replace(",", "."))
            finite(**{head: number})
        except (AttributeError, ValueError) as error:
            raise ValueError(
                f"{file}, line {row[_LINE]}: {head} must be a finite number, got "
                f"{shown(row[head])}: correct the line, or delete it"
            ) from error
        numbers.append(number)
    return np.array(numbers)
