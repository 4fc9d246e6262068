"""Result of the fit to one of many force curves, and its row in a table."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any

from ase_roughcontact._util.checked_rows import CHECKSUM, with_checksum
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.units import UNITS

#: Attributes of `FittedCurve` that are numbers with a unit, and the units in tables.
CURVE_UNITS = {
    "x": "um",
    "y": "um",
    "contact_modulus": "Pa",
    "contact_modulus_error": "Pa",
    "instantaneous_modulus": "Pa",
    "work_of_adhesion": "J/m²",
    "work_of_adhesion_error": "J/m²",
    "contact_height": "nm",
    "contact_height_error": "nm",
    "largest_indentation": "nm",
    "pull_off_force": "nN",
    "force_offset": "nN",
    "residual": "nN",
    "noise": "nN",
}
#: Attributes that are lists of numbers, and their units in tables.
LIST_UNITS = {
    "relaxation_moduli": "",
    "relaxation_times": "s",
    "relaxation_times_errors": "s",
}
#: Text between two doubts.
SEPARATOR = " | "


@dataclass(frozen=True)
class FittedCurve(Summarized):
    """Result of the fit to one of many force curves; NaN stands for what is not known.

    Attributes
    ----------
    file : str
        Path of the file.
    member : str
        Name of the file in an archive; empty without one.
    number : int
        Number of the curve in the file, from 1.
    x, y : float
        Place on the sample, by the coordinates of the scanner (Å).
    column, row : int
        Numbers in the grid of a map, from 0; -1 if the file does not have them.
    points : int
        Number of measured points.
    contact_modulus, contact_modulus_error : float
        E* and its standard error by noise (eV/Å^3).
    instantaneous_modulus : float
        Sum of the relaxed and the relaxing moduli, if relaxation was fitted; then
        `contact_modulus` is the relaxed modulus (eV/Å^3).
    relaxation_moduli, relaxation_times, relaxation_times_errors : tuple of float
        Relaxing moduli over the instantaneous one, relaxation times and their standard
        errors (s), if they were fitted; see `RelaxationFit`.
    work_of_adhesion, work_of_adhesion_error : float
        Work of adhesion, if it was fitted, and its standard error (eV/Å^2).
    contact_height, contact_height_error : float
        Height of the tip at the contact point, the height of the unloaded surface, and
        its standard error (Å).
    largest_indentation : float
        Largest indentation that was fitted (Å).
    pull_off_force : float
        Largest tension on the retraction relative to the free force there; zero if it
        is not above the noise (eV/Å).
    force_offset : float
        Force of a free tip with the base at its highest point (eV/Å).
    residual : float
        Standard deviation of the residuals of the fit (eV/Å).
    noise : float
        Standard deviation of the noise of the force (eV/Å).
    converged : bool
        Whether the fit has converged.
    doubts : str
        Reasons to doubt the curve or the fit, separated by `SEPARATOR`.
    message : str
        Reason why the curve could not be read or fitted; otherwise empty.
    """

    file: str
    member: str = ""
    number: int = 1
    x: float = math.nan
    y: float = math.nan
    column: int = -1
    row: int = -1
    points: int = 0
    contact_modulus: float = math.nan
    contact_modulus_error: float = math.nan
    instantaneous_modulus: float = math.nan
    relaxation_moduli: tuple[float, ...] = ()
    relaxation_times: tuple[float, ...] = ()
    relaxation_times_errors: tuple[float, ...] = ()
    work_of_adhesion: float = math.nan
    work_of_adhesion_error: float = math.nan
    contact_height: float = math.nan
    contact_height_error: float = math.nan
    largest_indentation: float = math.nan
    pull_off_force: float = math.nan
    force_offset: float = math.nan
    residual: float = math.nan
    noise: float = math.nan
    converged: bool = False
    doubts: str = ""
    message: str = ""

    @property
    def relaxation_time(self) -> float:
        """Longest relaxation time that is known (s); NaN without any."""
        known = (time for time in self.relaxation_times if not math.isnan(time))
        return max(known, default=math.nan)

    @property
    def misfit(self) -> float:
        """Standard deviation of the residuals over the noise; one for a good fit."""
        return self.residual / self.noise if self.noise > 0.0 else math.nan


def curve_heads() -> dict[str, str]:
    """Return the heads of a table of curves by the names of its columns."""
    heads = {}
    for each in fields(FittedCurve):
        unit = CURVE_UNITS.get(each.name) or LIST_UNITS.get(each.name)
        heads[each.name] = f"{each.name} ({unit})" if unit else each.name
    return heads | {CHECKSUM: CHECKSUM}


def to_row(curve: FittedCurve) -> dict[str, str]:
    """Return a result as the row of a table, with a checksum."""
    row = {}
    for each in fields(curve):
        value = getattr(curve, each.name)
        if each.name in CURVE_UNITS:
            value = f"{value / UNITS[CURVE_UNITS[each.name]]:.12g}"
        elif each.name in LIST_UNITS:
            value = " ".join(f"{number:.12g}" for number in value)
        row[each.name] = str(value)
    return with_checksum(row)


def from_row(row: Mapping[str, str]) -> FittedCurve:
    """Return the result in the row of a table.

    Raises
    ------
    KeyError, ValueError
        If a column is missing, or a value is not a number.
    """
    values: dict[str, Any] = {
        name: float(row[name]) * UNITS[unit] for name, unit in CURVE_UNITS.items()
    }
    for name in ("number", "column", "row", "points"):
        values[name] = int(row[name])
    for name in LIST_UNITS:
        values[name] = tuple(map(float, row[name].split()))
    for name in ("file", "member", "doubts", "message"):
        values[name] = row[name]
    return FittedCurve(**values, converged=row["converged"] == "True")
