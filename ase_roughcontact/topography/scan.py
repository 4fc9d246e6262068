"""Scans of surfaces: units, missing points, tilt, and the side that is pressed.

A microscope shows a surface from outside: the high points of a scan z(x, y) stick out
of the body, and touch first. An indenter is described by its lower side h(x, y), whose
low points touch first::

    role            lower side          the scanned body
    "substrate"     h(x, y) = -z(x, y)    stays in place below the tip
    "indenter"      h(x, y) = -z(-x, y)   is turned over around the y axis of the scan

A scanned substrate is not modelled as a body of its own: with small slopes only the sum
of the two shapes matters, so that it is added to the tip. Turning a body over reverses
one direction, which is x.
"""

from __future__ import annotations

import os
import warnings
from dataclasses import replace
from functools import partial
from typing import Any, TypeAlias

import numpy as np
from scipy.sparse import coo_matrix, diags
from scipy.sparse.linalg import spsolve

from ase_roughcontact._util.units import LENGTHS, quantity
from ase_roughcontact._util.validation import (
    LARGEST,
    FloatArray,
    Point,
    Shape,
    finite,
    lookup,
    unknown,
)
from ase_roughcontact.topography.interpolation import ROUNDING
from ase_roughcontact.topography.profile import LineProfile
from ase_roughcontact.topography.raw_scan import RawScan, scan_of
from ase_roughcontact.topography.scan_files import read_scan
from ase_roughcontact.topography.spectrum import axis_spacings

#: A number, or a string of a number and a unit of length.
Length: TypeAlias = float | str

# Relative difference up to which spacings are the same.
_SAME_SPACING = 0.01
# Numbers of points that are not missing, and beyond the edges of a scan.
_KNOWN, _BEYOND = -1, -2

#: Which of the two bodies was scanned.
ROLES = ("indenter", "substrate")


def scan_in_angstrom(
    topography: Any,
    *,
    spacing: Length | tuple[Length, Length] | None = None,
    unit: str | None = None,
    channel: int | str | None = None,
    transpose: bool = False,
) -> tuple[RawScan, Point, float]:
    """Return a scan and its spacing in Å, and the unit of given lengths in Å.

    See `HeightMap.from_topography` for the parameters.
    """
    is_file = isinstance(topography, (str, os.PathLike))
    raw = read_scan(topography, channel) if is_file else scan_of(topography)
    if isinstance(raw, LineProfile):
        raise ValueError(
            f"{os.fspath(topography)!r} is {raw.described(unit)}, and a contact needs "
            "a map: scan an area, or give a random surface with these values "
            "([roughness])"
        )
    if transpose:
        raw = raw.transposed
    if raw.unit is None and unit is None and (is_file or raw.spacing is not None):
        raise ValueError(
            f"the unit of {topography!r} is not known: give unit, for example 'nm'"
        )
    of_scan, given, lateral = (
        lookup(name or "A", LENGTHS, "unit of length")
        for name in (
            raw.unit or unit,
            unit or raw.unit,
            raw.lateral_unit or raw.unit or unit,
        )
    )
    found = raw.spacing and (raw.spacing[0] * lateral, raw.spacing[1] * lateral)
    steps = found
    if spacing is not None:
        steps = axis_spacings(in_angstrom("spacing", spacing, given))
    if steps is None:
        raise ValueError(
            "the distance between the points of the scan is not known: give spacing"
        )
    if found and not np.allclose(steps, found, rtol=_SAME_SPACING):
        sizes = (f"{x / 10:.4g} x {y / 10:.4g}" for x, y in (steps, found))
        warnings.warn(
            "the spacing {} nm is given and used, but the file has {} nm: leave "
            "spacing out, unless the file is wrong".format(*sizes),
            stacklevel=2,
        )
    if (abs(raw.heights) > LARGEST / of_scan).any():
        raise ValueError(
            f"heights of the scan are above {LARGEST:g} Å: are they heights, is the "
            "unit right?"
        )
    return replace(raw, heights=raw.heights * of_scan), steps, given


def filled(heights: FloatArray, periodic: bool) -> FloatArray:
    """Return heights with missing points, which are NaN, interpolated.

    The heights there solve Laplace's equation, with the known heights around them as
    boundary values, which leaves no artificial peaks: each is the mean of its
    neighbours.

    Raises
    ------
    ValueError
        If all points are missing.
    """
    missing = np.isnan(heights)
    if missing.all():
        raise ValueError("all points of the scan are missing")
    if not missing.any():
        return heights
    i, j = missing.nonzero()
    size = len(i)
    number = np.full(heights.shape, _KNOWN)
    number[i, j] = np.arange(size)
    beyond: Any = {"mode": "wrap"} if periodic else {"constant_values": _BEYOND}
    number, padded = np.pad(number, 1, **beyond), np.pad(heights, 1, **beyond)
    around = np.array([i, i + 2, i + 1, i + 1]), np.array([j + 1, j + 1, j, j + 2])
    neighbour = number[around]
    right = np.where(neighbour == _KNOWN, padded[around], 0.0).sum(axis=0)
    linked = neighbour >= 0
    row = linked.nonzero()[1]
    links = coo_matrix((np.ones(row.size), (row, neighbour[linked])), (size, size))
    count = diags((neighbour != _BEYOND).sum(axis=0, dtype=float))
    heights = heights.copy()
    heights[i, j] = spsolve((count - links).tocsc(), right)
    return heights


def levelled(heights: FloatArray, detrend: str) -> FloatArray:
    """Return heights without tilt, curvature or offsets of lines.

    See `HeightMap.from_topography`. Missing points are not taken into account.
    """
    degrees = {"mean": 0, "plane": 1, "curvature": 2}
    trends: dict[str, Any] = {"lines": _lines, "none": np.zeros_like}
    trends |= {k: partial(polynomial, degree=n) for k, n in degrees.items()}
    return heights - lookup(detrend, trends, "way to detrend")(heights)


def highest(heights: FloatArray, spacing: Point, margin: float) -> Point:
    """Return the position (x, y) of the highest point inside a margin (Å).

    Raises
    ------
    ValueError
        If no point is that far from the edges.
    """
    edges = np.ceil(np.divide(margin, spacing) - ROUNDING).astype(int)
    (n, m), (left, lower) = heights.shape, edges
    inner = heights[left : n - left, lower : m - lower]
    if not inner.size:
        x, y = np.multiply(heights.shape, spacing) / 10
        raise ValueError(
            f"no point of the scan, {x:g} x {y:g} nm, is {margin / 10:g} nm from all "
            "edges: give a smaller margin"
        )
    x, y = (edges + np.unravel_index(inner.argmax(), inner.shape)) * spacing
    return float(x), float(y)


def check_place(place: Point, shape: Shape, spacing: Point) -> None:
    """Raise `ValueError` if a place (x, y) is not on a scan of a shape (Å)."""
    size = (np.array(shape) - 1) * spacing
    if (abs(place - size / 2) > size / 2 + ROUNDING * np.array(spacing)).any():
        (x, y), (width, height) = place, size
        raise ValueError(
            f"center must be on the scan, which spans {width / 10:.4g} x "
            f"{height / 10:.4g} nm, got ({x / 10:.4g}, {y / 10:.4g}) nm"
        )


def lower_side(
    heights: FloatArray, spacing: Point, role: str, place: Point | None
) -> tuple[FloatArray, Point | None]:
    """Return the heights of the indenter's lower side, and a place on it.

    Heights are positive upward, away from the substrate. The place, if any, is given on
    the scan and returned on the lower side (Å).

    Raises
    ------
    ValueError
        If the role is unknown.
    """
    if role not in ROLES:
        raise ValueError(unknown(str(role), ROLES, "role"))
    if role == "substrate":
        return -heights, place
    if place is not None:
        place = (len(heights) - 1) * spacing[0] - place[0], place[1]
    return -heights[::-1], place


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


def polynomial(heights: FloatArray, degree: int) -> FloatArray:
    """Return the polynomial in x and y that fits the known heights, at all points."""
    x, y = (np.linspace(-1.0, 1.0, n) for n in heights.shape)
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    terms = np.array([x[:, None] ** i * y**j for i, j in powers])
    known = ~np.isnan(heights)
    fit, *_ = np.linalg.lstsq(terms[:, known].T, heights[known], rcond=None)
    return np.tensordot(fit, terms, 1)


def _lines(heights: FloatArray) -> FloatArray:
    """Return the straight lines that fit the scan lines (along x) best."""
    places = np.linspace(-1.0, 1.0, len(heights))[:, None] + np.zeros_like(heights)
    known, x = (np.ma.array(each, mask=np.isnan(heights)) for each in (heights, places))
    distance, middle = x - x.mean(axis=0), known.mean(axis=0)
    slope = (distance * (known - middle)).sum(axis=0) / (distance**2).sum(axis=0)
    lines = middle + np.ma.filled(slope, 0.0) * (places - x.mean(axis=0))
    return np.ma.filled(lines, 0.0)
