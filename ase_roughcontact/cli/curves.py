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

_HEAD = re.compile(r"\s*([^(]*?)\s*(?:\((.*)\))?\s*")


def read_curve(file: Path, branch: str | None = None) -> ForceCurve:
    """Read a force curve.

    Parameters
    ----------
    file : path
        CSV with a header. Columns are ``depth (nm)``, or ``distance (nm)`` of the base
        and ``deflection (nm)`` of the cantilever, and ``force (nN)``; or those of
        ``curve.csv``. Units are in parentheses.
    branch : str, optional
        Value of the column ``branch``: "approach" or "retraction".

    Returns
    -------
    ForceCurve
        The stiffness of the cantilever is that of forces and deflections, infinite if
        they are not given.

    Raises
    ------
    ValueError
        If a column is missing, or a value is not a number.
    """
    with file.open(newline="", encoding="utf-8-sig") as table:
        rows = list(csv.DictReader(table))
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
    stiffness = math.inf
    if depth is None and {"distance", "deflection"} <= columns.keys():
        bend = columns["deflection"]
        depth = -(columns["distance"] + bend)
        if force is not None and bend.any():
            stiffness = float((force @ bend) / (bend @ bend))
    if force is None or depth is None:
        raise ValueError(
            f"{file} needs the columns force (nN) and depth (nm), or distance (nm) and "
            f"deflection (nm), got {', '.join(map(str, rows[0]))}"
        )
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
        return np.array([float(row[head]) for row in rows])
    except (TypeError, ValueError) as error:
        raise ValueError(f"{file}: column {head!r} must be numbers: {error}") from error
