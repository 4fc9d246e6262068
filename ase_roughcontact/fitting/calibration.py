"""Calibration of the cantilever: from the file, or given in place of it.

With the spring constant k and the sensitivity s in the file, and k', s' in their place,
deflections become d s'/s and forces F k' s'/(k s). A depth -(D + d) changes with them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.formats.table import Calibration, CurveTable

# Smallest relative change of a calibration that is reported.
_MIN_REPORTED_CHANGE = 1e-3


@dataclass(frozen=True)
class Recalibration:
    """Factors of the deflections and forces of a file.

    Attributes
    ----------
    stiffness : float or None
        Spring constant (eV/Å^2) of the recalibrated curve, if it is known.
    sensitivity : float or None
        Deflection per V (Å), if it is known.
    deflection_factor, force_factor : float
        Factors by which deflections and forces change.
    remarks : tuple of str
        Remarks on the changes.
    """

    stiffness: float | None
    sensitivity: float | None
    deflection_factor: float
    force_factor: float
    remarks: tuple[str, ...]

    def of(self, found: dict[str, FloatArray]) -> dict[str, FloatArray]:
        """Return recalibrated quantities.

        Parameters
        ----------
        found : dict of ndarray
            Quantities of a segment: "force", "deflection", "depth" and others.
        """
        new = dict(found)
        if "force" in found:
            new["force"] = self.force_factor * found["force"]
        if "deflection" in found:
            new["deflection"] = self.deflection_factor * found["deflection"]
        if "depth" in found and self.deflection_factor != 1.0:
            if "deflection" in found:
                bend = new["deflection"]
            elif "force" in found and self.stiffness is not None:
                bend = new["force"] / self.stiffness
            else:
                return new
            new["depth"] = found["depth"] + bend * (1.0 / self.deflection_factor - 1.0)
        return new


def recalibration(
    file: PathName, table: CurveTable, given: Calibration
) -> Recalibration:
    """Return the factors by which a given calibration changes the curve of a file.

    Parameters
    ----------
    file : path
        Name of the file, for messages.
    table : CurveTable
        Contents of the file.
    given : Calibration
        Calibration given by the user.

    Raises
    ------
    ValueError
        If a sensitivity is given, but the lengths and forces in the file were
        calculated with a sensitivity that is not in the file.
    """
    remarks = []
    deflection_factor, stiffness_factor = 1.0, 1.0
    units = {column.unit for part in table.segments for column in part.columns}
    if given.sensitivity and table.sensitivity:
        deflection_factor = given.sensitivity / table.sensitivity
        remarks += _changed(
            "sensitivity", table.sensitivity, given.sensitivity, "nm", "nm/V"
        )
    elif given.sensitivity and given.per == "V" and not units & {"V", "mV"}:
        raise ValueError(
            f"{file} has deflections and forces by a sensitivity that is not in the "
            "file, so that it can't be replaced: leave out --sensitivity"
        )
    if given.stiffness and table.stiffness:
        stiffness_factor = given.stiffness / table.stiffness
        remarks += _changed(
            "spring constant", table.stiffness, given.stiffness, "N/m", "N/m"
        )
    return Recalibration(
        given.stiffness or table.stiffness,
        given.sensitivity or table.sensitivity,
        deflection_factor,
        deflection_factor * stiffness_factor,
        tuple(remarks),
    )


def _changed(name: str, old: float, new: float, unit: str, shown: str) -> list[str]:
    """Return a remark if a given value differs from the value in the file."""
    if math.isclose(old, new, rel_tol=_MIN_REPORTED_CHANGE):
        return []
    new, old = new / UNITS[unit], old / UNITS[unit]
    return [f"{name} {new:.4g} {shown} in place of {old:.4g} {shown} in the file"]
