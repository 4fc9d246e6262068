"""Quantities with a unit in scene files: ``"30 nm"``, ``"2.5 Å"``, ``"50 nN"``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from ase_roughcontact._util.units import LENGTHS, UNITS
from ase_roughcontact._util.validation import lookup
from ase_roughcontact.scene.section import QUANTITY, Section

AnySection = TypeVar("AnySection", bound=Section)

_NANO = UNITS["nN"]
#: Units of force in ASE's unit, eV/Å.
FORCES: dict[str, float] = {
    "nN": _NANO,
    "pN": 1e-3 * _NANO,
    "N": 1e9 * _NANO,
    "eV/Å": 1.0,
    **dict.fromkeys(("uN", "\u00b5N", "\u03bcN"), 1e3 * _NANO),
}


def plain(
    section: AnySection,
    keys: Iterable[str],
    units: Mapping[str, float],
    target: str,
    default: str | None = None,
) -> AnySection:
    """Return a section whose quantities are numbers in one unit.

    Parameters
    ----------
    section : Section
    keys : iterable of str
        Keys of the quantities: numbers, strings of a number and a unit, or lists.
    units : mapping
        Values of the units, such as `lengths` or `FORCES`.
    target : str
        Unit of the result.
    default : str, optional
        Unit of numbers; by default that of the result.

    Returns
    -------
    Section

    Raises
    ------
    ValueError
        If a string is not a number and a unit, or a unit is unknown.
    """
    scale = 1.0
    if default is not None:
        scale = lookup(default, units, "unit") / units[target]

    def number(key: str, value: Any) -> Any:
        if isinstance(value, str):
            return _number(key, value, units) / units[target]
        if isinstance(value, tuple):
            return tuple(number(key, each) for each in value)
        return value if scale == 1.0 or value is None else value * scale

    return replace(section, **{key: number(key, getattr(section, key)) for key in keys})


def lengths(a0: float) -> dict[str, float]:
    """Return the units of length of scene files, with the spacing a0 (Å)."""
    return {"a0": a0, **LENGTHS}


def _number(key: str, text: str, units: Mapping[str, float]) -> float:
    """Return the value of a number with a unit, in ASE's units."""
    found = QUANTITY.fullmatch(text)
    if not found:
        raise ValueError(
            f"{key} must be a number, or a string of a number and a unit such as "
            f'"3 {"nm" if "nm" in units else "nN"}", got {text!r}'
        )
    return float(found[1]) * lookup(found[2], units, f"unit of {key}")
