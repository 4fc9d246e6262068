"""Scans of surfaces, levelled and mended, and the side that is pressed.

A microscope shows a surface from outside: the high points of a scan z(x, y) stick out
of the body, and touch first. An indenter is described by its lower side h(x, y), and
its low points touch first::

    role            lower side          the scanned body
    "substrate"     h(x, y) = -z(x, y)    stays in place below the tip
    "indenter"      h(x, y) = -z(-x, y)   is turned over around the y axis of the scan

A scanned substrate is not modelled as a body of its own: with small slopes only the sum
of the two shapes matters, so that it is added to the tip. Turning a body over reverses
one direction, which is x.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact._util.validation import (
    FloatArray,
    Point,
    Shape,
    boolean,
    lookup,
    nonnegative,
    unknown,
)
from ase_roughcontact.topography.bad_lines import BadLines, listed, not_recorded
from ase_roughcontact.topography.levelling import filled, levelled
from ase_roughcontact.topography.measurement import Measurement
from ase_roughcontact.topography.noise import Noise, outliers
from ase_roughcontact.topography.raw_scan import RawScan
from ase_roughcontact.topography.scan import Length, in_angstrom, position

#: Names of the two bodies that may have been scanned.
ROLES = ("indenter", "substrate")


def pressed_scan(
    scan: RawScan,
    role: str,
    unit: float,
    *,
    detrend: str | None,
    center: str | tuple[Length, Length],
    margin: Length,
    periodic: bool | None,
    noise: Length | None,
    cutoff_wavelength: Length,
    remove_outliers: bool,
    remove_bad_lines: bool,
) -> tuple[Measurement, Point | None]:
    """Return the lower side of a scan in Å, and a place on it, `None` for the middle.

    `unit` is the unit of given lengths (Å). See `HeightMap.from_topography` for the
    other parameters.
    """
    boolean(remove_outliers=remove_outliers, remove_bad_lines=remove_bad_lines)
    if periodic is None:
        periodic = scan.periodic
    boolean(periodic=periodic)
    assert scan.spacing is not None
    spacing, heights = scan.spacing, scan.heights
    missing = int(np.isnan(heights).sum())
    bad = BadLines.of(heights)
    if remove_bad_lines:
        heights = _without_bad_lines(bad, heights, periodic)
    detrend = detrend or ("mean" if periodic else "plane")
    z = levelled(heights, detrend)
    found = _noise(z, noise, unit)
    cutoff = _length("cutoff_wavelength", cutoff_wavelength, unit)
    if cutoff > max(np.multiply(heights.shape, spacing)):
        raise ValueError(
            "cutoff_wavelength must not exceed the size of the scan, got "
            f"{cutoff_wavelength}"
        )
    z = filled(z, periodic)
    far = outliers(z)
    if remove_outliers:
        z = filled(levelled(np.where(far, np.nan, heights), detrend), periodic)
    place, edge = None, _length("margin", margin, unit)
    if not isinstance(center, str):
        place = position(center, unit)
        check_place(place, z.shape, spacing)
    elif lookup(center, {"middle": False, "highest": True}, "center"):
        place = highest(z, spacing, edge)
    lower, place = lower_side(z, spacing, role, place)
    measured = Measurement(
        lower,
        spacing,
        periodic,
        found,
        cutoff,
        missing=missing,
        outliers=int(far.sum()),
        doubts=(
            *_doubts_about_lines(bad, remove_bad_lines),
            *_doubts_about_axes(scan.heights),
        ),
        margin=edge,
    )
    return measured, place


def _without_bad_lines(
    bad: BadLines, heights: FloatArray, periodic: bool
) -> FloatArray:
    """Return heights with NaN at bad lines, and without the rest of an aborted scan."""
    kept = bad.kept
    if periodic and kept != slice(0, heights.shape[1]):
        raise ValueError(
            "remove_bad_lines cannot complete an aborted scan that is periodic: give "
            "periodic = false"
        )
    return np.where(bad.mask, np.nan, heights)[:, kept]


def _doubts_about_lines(bad: BadLines, removed: bool) -> Iterator[str]:
    """Yield the faults of the lines of a scan that is pressed, each with advice."""
    if not removed:
        for fault in bad.described():
            yield (
                f"{fault}: if that is not the surface, give remove_bad_lines = true, "
                "or scan it again"
            )
    for fault in bad.clipped():
        yield (
            f"{fault}: if these heights were clipped, the contact is wrong there; scan "
            "with a larger range of heights"
        )


def _doubts_about_axes(heights: FloatArray) -> Iterator[str]:
    """Yield a doubt if heights were not recorded along lines of constant x."""
    constant, repeated = not_recorded(heights.T)
    lines = np.flatnonzero(constant | repeated).tolist()
    if lines:
        yield (
            f"{listed(lines)} of constant x have equal heights or repeat the line "
            "before: are x and y exchanged (transpose)?"
        )


def _noise(heights: FloatArray, given: Length | None, unit: float) -> Noise:
    """Return the noise of heights, with a given noise of points, if any (Å)."""
    found = Noise.of(heights)
    if given is None:
        return found
    points = _length("noise", given, unit)
    return Noise(points, found.lines if points else 0.0)


def _length(name: str, value: Length, unit: float) -> float:
    """Return a length >= 0 in Å."""
    length = float(in_angstrom(name, value, unit))
    nonnegative(**{name: length})
    return length


def highest(heights: FloatArray, spacing: Point, margin: float) -> Point:
    """Return the position (x, y) of the highest point inside a margin (Å).

    Raises
    ------
    ValueError
        If no point is that far from the edges.
    """
    edges = np.ceil(np.divide(margin, spacing) - LENGTH_ROUNDING).astype(int)
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
    if (abs(place - size / 2) > size / 2 + LENGTH_ROUNDING * np.array(spacing)).any():
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
