"""Units of scene files, printed output and figures."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from ase.units import GPa, J, m

from ase_roughcontact._util.validation import lookup

#: Value of each unit of length, as written in files and scenes, in Å.
LENGTHS: dict[str, float] = {
    **{"m": 1e10, "cm": 1e8, "mm": 1e7, "nm": 10.0, "pm": 0.01},
    **dict.fromkeys(("um", "\u00b5m", "\u03bcm"), 1e4),  # micro sign, Greek letter mu
    # letter A with ring, Angstrom sign
    **dict.fromkeys(("A", "Angstrom", "\u00c5", "\u212b"), 1.0),
}

_NANO = 1e-9 * J / m
#: Units of force in ASE's unit, eV/Å.
FORCES: dict[str, float] = {
    **{"nN": _NANO, "pN": 1e-3 * _NANO, "N": 1e9 * _NANO, "eV/Å": 1.0},
    **dict.fromkeys(("uN", "\u00b5N", "\u03bcN"), 1e3 * _NANO),
}

#: Units of pressure in ASE's unit, eV/Å^3.
PRESSURES: dict[str, float] = {
    "Pa": 1e-9 * GPa,
    "kPa": 1e-6 * GPa,
    "MPa": 1e-3 * GPa,
    "GPa": GPa,
    "TPa": 1e3 * GPa,
    **dict.fromkeys(("eV/Å^3", "eV/Å³"), 1.0),
}

#: Units of works of adhesion and of stiffnesses in ASE's unit, eV/Å^2.
WORKS: dict[str, float] = {
    **dict.fromkeys(("J/m^2", "J/m²", "N/m", "nN/nm"), J / m**2),
    **dict.fromkeys(("mJ/m^2", "mJ/m²", "mN/m", "pN/nm"), 1e-3 * J / m**2),
    **dict.fromkeys(("eV/Å^2", "eV/Å²"), 1.0),
}

#: Units of times in seconds.
TIMES: dict[str, float] = {
    **{"s": 1.0, "ms": 1e-3, "ns": 1e-9, "min": 60.0, "h": 3600.0},
    **dict.fromkeys(("us", "\u00b5s", "\u03bcs"), 1e-6),
}

#: Units of frequencies in hertz.
FREQUENCIES: dict[str, float] = {"Hz": 1.0, "mHz": 1e-3, "kHz": 1e3, "MHz": 1e6}

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
    **ANGLES,
    **dict.fromkeys(("", "Å^2", "eV", "eV/s", "bytes"), 1.0),
    "nm²": 100.0,
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
        Such as ``"3 nm"``.
    units : mapping
        Values of the units, such as `LENGTHS`.
    example : str
        Unit that an error gives as an example; by default a usual one.

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
    tables = LENGTHS, FORCES, PRESSURES, WORKS, TIMES, FREQUENCIES, ANGLES
    return next((table for table in tables if unit in table), {})


def per_time(units: Mapping[str, float]) -> dict[str, float]:
    """Return the units of rates, such as "nm/s", of a quantity with some units."""
    return {
        f"{unit}/{time}": value / seconds
        for unit, value in units.items()
        for time, seconds in TIMES.items()
    }


def with_unit(value: float, unit: str) -> str:
    """Return a value in ASE's units as text in one of `UNITS`: ``"3.2 nN"``."""
    return f"{value / UNITS[unit]:.4g} {unit}"


# Units in which columns are printed, by their unit.
_PRINTED = {"eV/Å^2": "N/m", "eV/Å": "nN", "Å^2": "nm²", "bytes": "GB"}


# Typical pressure in a contact, relative to the modulus, and least value in its unit.
_PRESSURE, _LEAST = 0.01, 0.1


def pressure_unit(value: float) -> str:
    """Return GPa, MPa, kPa or Pa for a pressure (eV/Å^3)."""
    units = ("GPa", "MPa", "kPa", "Pa")
    return next((each for each in units if value >= _LEAST * PRESSURES[each]), "kPa")


def printed_unit(unit: str, modulus: float = math.inf) -> str:
    """Return the unit in which values of a column are printed.

    That of pressures is GPa, or less for a solid of small contact modulus (eV/Å^3).
    """
    if unit == "eV/Å^3":
        return pressure_unit(_PRESSURE * modulus)
    return _PRINTED.get(unit, unit)
