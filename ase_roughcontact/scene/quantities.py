"""Quantities with a unit in scene files: ``"30 nm"``, ``"2.5 Å"``, ``"50 nN"``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

from ase_roughcontact._util.units import LENGTHS, quantity
from ase_roughcontact._util.validation import lookup
from ase_roughcontact.scene.section import Section

AnySection = TypeVar("AnySection", bound=Section)


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
            return quantity(key, value, units) / units[target]
        if isinstance(value, tuple):
            return tuple(number(key, each) for each in value)
        return value if scale == 1.0 or value is None else value * scale

    return replace(section, **{key: number(key, getattr(section, key)) for key in keys})


def lengths(a0: float) -> dict[str, float]:
    """Return the units of length of scene files, with the spacing a0 (Å)."""
    return {"a0": a0, **LENGTHS}
