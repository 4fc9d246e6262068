"""Units of scene files, printed output and figures."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from ase.units import GPa, J, m

from ase_roughcontact._util.validation import lookup

#: Value of each unit of length, as written in files and scenes, in Å.
LENGTHS: dict[str, float] = {
    "m": 1e10,
    "cm": 1e8,
    "mm": 1e7,
    "nm": 10.0,
    "pm": 0.01,
    "um": 1e4,
    "\u00b5m": 1e4,  # micro sign
    "\u03bcm": 1e4,  # Greek letter mu
    "A": 1.0,
    "Angstrom": 1.0,
    "\u00c5": 1.0,  # letter A with ring
    "\u212b": 1.0,  # Angstrom sign
}

#: One nanometre in ASE's unit of length (Å).
nm = LENGTHS["nm"]
#: One nanonewton in ASE's unit of force (eV/Å).
nN = 1e-9 * J / m  # noqa: N816
#: Units of force in ASE's unit, eV/Å.
FORCES: dict[str, float] = {
    "nN": nN,
    "pN": 1e-3 * nN,
    "N": 1e9 * nN,
    "eV/Å": 1.0,
    "uN": 1e3 * nN,
    "\u00b5N": 1e3 * nN,  # micro sign
    "\u03bcN": 1e3 * nN,  # Greek letter mu
}

#: Units of speed in Å/s.
SPEEDS: dict[str, float] = {f"{length}/s": value for length, value in LENGTHS.items()}

#: Units of pressure in ASE's unit, eV/Å^3.
PRESSURES: dict[str, float] = {
    "Pa": 1e-9 * GPa,
    "kPa": 1e-6 * GPa,
    "MPa": 1e-3 * GPa,
    "GPa": GPa,
    "TPa": 1e3 * GPa,
    "eV/Å^3": 1.0,
    "eV/Å³": 1.0,
}

#: Units of works of adhesion and of stiffnesses in ASE's unit, eV/Å^2.
WORKS: dict[str, float] = {
    "J/m^2": J / m**2,
    "J/m²": J / m**2,
    "N/m": J / m**2,
    "nN/nm": J / m**2,
    "mJ/m^2": 1e-3 * J / m**2,
    "mJ/m²": 1e-3 * J / m**2,
    "mN/m": 1e-3 * J / m**2,
    "pN/nm": 1e-3 * J / m**2,
    "eV/Å^2": 1.0,
    "eV/Å²": 1.0,
}

#: Units of times in seconds.
TIMES: dict[str, float] = {
    "s": 1.0,
    "ms": 1e-3,
    "ns": 1e-9,
    "min": 60.0,
    "h": 3600.0,
    "us": 1e-6,
    "\u00b5s": 1e-6,  # micro sign
    "\u03bcs": 1e-6,  # Greek letter mu
}

#: Units of frequencies in hertz.
FREQUENCIES: dict[str, float] = {"Hz": 1.0, "mHz": 1e-3, "kHz": 1e3, "MHz": 1e6}

#: Units of damping per area in ASE's unit, eV s/Å^4.
DAMPINGS: dict[str, float] = {"Pa s/m": 1e-19 * GPa, "MPa s/m": 1e-13 * GPa}

#: Units of densities in ASE's unit with seconds, eV s^2/Å^5.
DENSITIES: dict[str, float] = {"kg/m^3": J / m**5, "g/cm^3": 1e3 * J / m**5}

#: Units of angles in degrees.
ANGLES: dict[str, float] = {"deg": 1.0, "°": 1.0}

#: Value of each unit in ASE's units (Å, eV, s), and of angles in degrees.
UNITS: dict[str, float] = {
    **LENGTHS,
    **FORCES,
    **PRESSURES,
    **WORKS,
    **TIMES,
    **FREQUENCIES,
    **SPEEDS,
    **DAMPINGS,
    **DENSITIES,
    **ANGLES,
    "": 1.0,
    "Å^2": 1.0,
    "eV": 1.0,
    "eV/s": 1.0,
    "bytes": 1.0,
    "nm²": 100.0,
    "\u00b5m²": 1e8,  # micro sign
    "GB": 1e9,
}

#: A number with a unit.
QUANTITY = re.compile(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*([^\s\d.]\S*)\s*")


def quantity(
    name: str, text: str, units: Mapping[str, float], example: str = ""
) -> float:
    """Return the value, in ASE's units, of a number with a unit.

    Parameters
    ----------
    name : str
        Name of the quantity, for errors.
    text : str
        Text, such as ``"3 nm"``.
    units : mapping
        Values of the units, such as `LENGTHS`.
    example : str
        Unit of the example in an error; by default a common unit.

    Raises
    ------
    ValueError
        If the text is not a number and a unit, or the unit is unknown.
    """
    found = QUANTITY.fullmatch(text)
    if not units:
        raise ValueError(f"{name} must be a number without a unit, got {text!r}")
    if not found:
        known = ("nm", "nN", "GPa", "J/m^2", "s", "Hz", "nm/s", "nN/s")
        unit = example or next((k for k in known if k in units), next(iter(units)))
        raise ValueError(
            f"{name} must be a number, or a string of a number and a unit such as "
            f'"3 {unit}", got {text!r}'
        )
    return float(found[1]) * lookup(found[2], units, f"unit of {name}")


def units_like(unit: str) -> Mapping[str, float]:
    """Return the units of the same dimension as one of `UNITS`; none for ""."""
    tables = (
        LENGTHS,
        FORCES,
        PRESSURES,
        WORKS,
        TIMES,
        FREQUENCIES,
        SPEEDS,
        DAMPINGS,
        DENSITIES,
        ANGLES,
    )
    return next((table for table in tables if unit in table), {})


def per_time(units: Mapping[str, float]) -> dict[str, float]:
    """Return the units of rates, such as "nm/s", of a quantity with some units."""
    return {
        f"{unit}/{time}": value / seconds
        for unit, value in units.items()
        for time, seconds in TIMES.items()
    }


# Units of each dimension that printed values have by their size, in ascending order.
_UNITS_BY_SIZE = (
    ("pm", "nm", "\u00b5m", "mm"),
    ("pN", "nN", "\u00b5N"),
    ("Pa", "kPa", "MPa", "GPa"),
    ("nm²", "\u00b5m²"),
    ("mN/m", "N/m"),
    ("\u00b5s", "ms", "s"),
)
# Smallest and largest value that is printed in the usual unit.
_MIN_USUAL, _MAX_USUAL = 0.01, 1e4


def with_unit(value: float, unit: str) -> str:
    """Return a value in ASE's units as text: ``"3.2 nN"``.

    Values that are very small or large in the unit have another one by their size.

    Parameters
    ----------
    value : float
        Value in ASE's units.
    unit : str
        The usual unit, one of `UNITS`.
    """
    unit = _unit_by_size(value, unit)
    return f"{value / UNITS[unit]:.4g} {unit}"


def _unit_by_size(value: float, unit: str) -> str:
    """Return the usual unit, or the largest one in which a value is not below 0.1."""
    size = abs(value)
    ladder = next((units for units in _UNITS_BY_SIZE if unit in units), (unit,))
    usual = _MIN_USUAL <= size / UNITS[unit] < _MAX_USUAL
    if usual or not 0.0 < size < math.inf:
        return unit
    found = [each for each in ladder if size >= 0.1 * UNITS[each]]
    return found[-1] if found else ladder[0]


# Units in which columns are printed, by the unit of the column.
_PRINTED_UNITS = {"eV/Å^2": "N/m", "eV/Å": "nN", "Å^2": "nm²", "bytes": "GB"}
# Typical pressure in a contact, relative to the contact modulus.
_TYPICAL_PRESSURE = 0.01
# Smallest value of a pressure in its printed unit.
_MIN_PRINTED_PRESSURE = 0.1


def pressure_unit(value: float) -> str:
    """Return GPa, MPa, kPa or Pa for a pressure (eV/Å^3)."""
    for unit in ("GPa", "MPa", "kPa", "Pa"):
        if value >= _MIN_PRINTED_PRESSURE * PRESSURES[unit]:
            return unit
    return "Pa" if value > 0.0 else "kPa"


def printed_unit(unit: str, modulus: float = math.inf) -> str:
    """Return the unit in which values of a column are printed.

    Pressures are printed in GPa, or in a smaller unit for a solid with a small contact
    modulus (eV/Å^3).
    """
    if unit == "eV/Å^3":
        return pressure_unit(_TYPICAL_PRESSURE * modulus)
    return _PRINTED_UNITS.get(unit, unit)
