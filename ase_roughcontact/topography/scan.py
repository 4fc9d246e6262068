"""Units of scans, and of the lengths that are given with them."""

from __future__ import annotations

import os
import warnings
from typing import Any, TypeAlias

import numpy as np

from ase_roughcontact._util.units import LENGTHS, quantity
from ase_roughcontact._util.validation import (
    LARGEST,
    Point,
    boolean,
    finite,
    lookup,
)
from ase_roughcontact.topography.profile import LineProfile
from ase_roughcontact.topography.raw_scan import RawScan, scan_of
from ase_roughcontact.topography.scan_files import read_scan
from ase_roughcontact.topography.spectrum import axis_spacings

#: A number, or a string of a number and a unit of length.
Length: TypeAlias = float | str

# Relative difference up to which spacings are the same.
_SPACING_TOLERANCE = 0.01


def scan_in_angstrom(
    topography: Any,
    *,
    spacing: Length | tuple[Length, Length] | None = None,
    unit: str | None = None,
    channel: int | str | None = None,
    transpose: bool = False,
    extrude: bool = False,
) -> tuple[RawScan, float]:
    """Return a scan with its spacing in Å, and the unit of given lengths in Å.

    See `HeightMap.from_topography` for the parameters.
    """
    is_file = isinstance(topography, (str, os.PathLike))
    raw = read_scan(topography, channel) if is_file else scan_of(topography)
    boolean(transpose=transpose, extrude=extrude)
    if isinstance(raw, LineProfile):
        if not extrude:
            raise ValueError(
                f"{os.fspath(topography)!r} is {raw.described(unit)}, and a contact "
                "needs a map: scan an area, give these values in [roughness], or give "
                "extrude = true for a contact of long equal ridges"
            )
        raw = raw.extruded()
    elif extrude:
        raise ValueError(
            f"extrude needs a line profile, got {raw.heights.shape[0]} x "
            f"{raw.heights.shape[1]} points: leave it out"
        )
    if transpose:
        raw = raw.transposed
    if raw.unit is None and unit is None and (is_file or raw.spacing is not None):
        raise ValueError(
            f"the unit of {topography!r} is not known: give unit, for example 'nm'"
        )
    height_unit = _unit(raw.unit or unit)
    given_unit = _unit(unit or raw.unit)
    lateral_unit = _unit(raw.lateral_unit or raw.unit or unit)
    file_steps = steps = None
    if raw.spacing is not None:
        x, y = raw.spacing
        file_steps = steps = (x * lateral_unit, y * lateral_unit)
    if spacing is not None:
        steps = axis_spacings(in_angstrom("spacing", spacing, given_unit))
    if steps is None:
        raise ValueError(
            "the distance between the points of the scan is not known: give spacing"
        )
    if file_steps and not np.allclose(steps, file_steps, rtol=_SPACING_TOLERANCE):
        warnings.warn(
            f"the spacing {_in_nm(steps)} is given and used, but the file has "
            f"{_in_nm(file_steps)}: leave spacing out, unless the file is wrong",
            stacklevel=2,
        )
    if (abs(raw.heights) > LARGEST / height_unit).any():
        raise ValueError(
            f"heights of the scan are above {LARGEST:g} Å: are they heights, is the "
            "unit right?"
        )
    heights = raw.heights * height_unit
    return RawScan(heights, steps, "Å", raw.periodic), given_unit


def _unit(name: str | None) -> float:
    """Return a unit of length in Å, by default one."""
    return lookup(name or "A", LENGTHS, "unit of length")


def _in_nm(steps: Point) -> str:
    """Return distances of points (Å) as text in nm."""
    x, y = steps
    return f"{x / 10:.4g} x {y / 10:.4g} nm"


def position(center: Any, unit: float) -> Point:
    """Return a place (x, y) in Å, after checks."""
    try:
        x, y = center
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"center must be 'middle', 'highest' or two numbers (x, y), got {center!r}"
        ) from error
    x, y = in_angstrom("center", (x, y), unit)
    finite(center_x=x, center_y=y)
    return float(x), float(y)


def in_angstrom(name: str, value: Any, unit: float) -> Any:
    """Return a length, or a tuple of them, in Å.

    Strings have a unit, numbers the given one (Å). The name is for errors.

    Raises
    ------
    ValueError
        If a value is no number, or a unit is unknown.
    """
    if isinstance(value, str):
        return quantity(name, value, LENGTHS)
    if np.ndim(value):
        return tuple(in_angstrom(name, each, unit) for each in value)
    finite(**{name: value})
    return value * unit
