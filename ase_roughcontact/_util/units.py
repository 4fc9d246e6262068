"""Units of scene files, printed output and figures."""

from __future__ import annotations

from ase.units import GPa, J, m

#: Value of each unit in ASE's units (Å, eV, s).
UNITS: dict[str, float] = {
    "": 1.0,
    "Å": 1.0,
    "nm": 10.0,
    "Å^2": 1.0,
    "nm²": 100.0,
    "eV": 1.0,
    "eV/Å": 1.0,
    "nN": 1e-9 * J / m,
    "GPa": GPa,
    "J/m^2": J / m**2,
    "J/m²": J / m**2,
    "N/m": J / m**2,
    "s": 1.0,
    "bytes": 1.0,
    "GB": 1e9,
}

#: Value of each unit of length, as written in files and scenes, in Å.
LENGTHS: dict[str, float] = {
    "m": 1e10,
    "cm": 1e8,
    "mm": 1e7,
    "um": 1e4,
    "\u00b5m": 1e4,  # micro sign
    "\u03bcm": 1e4,  # Greek letter mu
    "nm": 10.0,
    "pm": 0.01,
    "A": 1.0,
    "Angstrom": 1.0,
    "\u00c5": 1.0,  # letter A with ring
    "\u212b": 1.0,  # Angstrom sign
}

# Units in which columns are printed, by their unit.
_PRINTED = {"eV/Å^2": "N/m", "eV/Å^3": "GPa", "eV/Å": "nN", "Å^2": "nm²", "bytes": "GB"}


def printed_unit(unit: str) -> str:
    """Return the unit in which values of a column are printed."""
    return _PRINTED.get(unit, unit)
