"""Measured force curves from CSV files."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

import numpy as np

from ase_roughcontact._util.units import FORCES, LENGTHS
from ase_roughcontact._util.validation import FloatArray, lookup
from ase_roughcontact.scene.force_curve import ForceCurve

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
        (nm)``, or ``distance (nm)`` of the base and ``deflection (nm)`` of the
        cantilever, and ``force (nN)``, which may be left out beside a deflection if the
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
        If a column is missing, or a value is not a number.
    """
    text = file.read_text(encoding="utf-8-sig", errors="replace")
    lines = [line for line in text.splitlines() if line.strip() and line[0] != "#"]
    separator = max(",;\t", key=lines[0].count) if lines else ","
    rows = list(csv.DictReader(lines, delimiter=separator))
    if not rows:
        raise ValueError(f"{file} contains no rows")
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
    if depth is None and bend is not None and "distance" in columns:
        depth = -(columns["distance"] + bend)
    if force is None and bend is not None and stiffness is not None:
        force = stiffness * bend
    if force is None or depth is None:
        raise ValueError(
            f"{file} needs the columns force (nN) and depth (nm), or distance (nm) and "
            f"deflection (nm), got {', '.join(map(str, rows[0]))}; without a force the "
            'scene needs cantilever in [path] of kind = "loop"'
        )
    if stiffness is None:
        stiffness = math.inf
        if bend is not None and np.ptp(bend) > 0.0:  # either may have another zero
            stiffness = float(np.polyfit(bend, force, 1)[0])
    return ForceCurve(depth, force, stiffness)


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
    try:
        return np.array([float(row[head].replace(",", ".")) for row in rows])
    except (AttributeError, ValueError) as error:
        raise ValueError(f"{file}: column {head!r} must be numbers: {error}") from error
