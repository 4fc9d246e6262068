r"""Contact area of the continuum under a hard wall, from the fields at its edge.

At a distance d inside the edge of an elastic contact the reaction of the wall is
:math:`B \sqrt{d}`. At a distance d outside, the gap is :math:`(4 B/3 E^*)\, d^{3/2}`
(K. L. Johnson, Contact Mechanics, 1985, chapter 5). This holds for all hard walls: an
attraction of finite tension acts on both sides of the edge alike, and pressures at the
edge are below a hardness. Between a grid point in contact, with the reaction p, and an
open one at a distance l, with the gap g, the edge is at the place where both give the
same B: the part t^3 of the distance is in contact, with

.. math:: t^3 + \rho^{2/3}\, t = 1, \qquad \rho = \frac{3 E^* g}{4 p\, l}.

The parts of the sides in contact determine the part of a triangle. The area is the mean
for the two ways of cutting the squares of the grid into triangles.

At a corner of the indenter, such as the edge of a flat punch, the pressure rises to the
edge instead. The edge is then taken in the middle between the two points.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ase_roughcontact.theory.counted_area import open_sides

# Overestimate of the area, per perimeter along the grid times spacing, as the sides
# cross the edge at an angle: 0.0144 to 0.0180, mean 0.0158, for smooth spheres at
# contact radii of 90 to 256 spacings.
_EDGE_CORRECTION = 0.0158
# Estimated error, in parts of the change if every other point is left out: chosen on
# the rough spheres and flats of examples/benchmarks/edge_area.py, and tested on other
# spheres by answer_errors.py.
_ERROR_PER_CHANGE = 0.25
# Estimated error, in parts of the perimeter times the spacing, chosen and tested alike.
_ERROR_PER_PERIMETER = 0.006
# Estimated error, in parts of the perimeter times the spacing, of a straight edge along
# the grid, which cuts all sides at the same part: errors of up to 0.15 do not average
# out there.
_ERROR_OF_ALIGNED = 0.08
# Estimated error, in parts of the perimeter times the spacing, of sides at a point
# under the hardness: the rim where the pressure falls to zero may be narrower than the
# spacing.
_ERROR_PER_PLASTIC = 0.02
# Estimated error, in units of the area of a point, of an open point between two points
# in contact: strips are resolved if they are wider. The areas of 400 strips in
# Westergaard's contact, with openings of 0.3 to 1.7 points at six angles to the grid,
# were wrong by less than twice the whole estimate, and by up to 1.2 points per length
# where no point is open.
_ERROR_PER_OPEN = 0.3
# Estimated error, in units of the area of a point, of a point in contact with a low
# pressure, next to which the surface may be open.
_ERROR_PER_CLOSED = 0.5
# Ratio of a pressure to the mean pressure of its two neighbours, below which a parabola
# through the three may be negative between the points.
_LOW_PRESSURE_RATIO = 0.2
# Ratio rho above which the pressure next to an edge is small. If it is nevertheless not
# below the pressure further inside, the point is at a corner of the indenter: 85 to
# 100 % of the sides at edges of punches, 0.01 % or less on the surfaces of
# examples/benchmarks/edge_area.py.
_RATIO_AT_CORNER = 30.0
# Estimated error per length of edges at corners, in units of the spacing: half of the
# largest possible error.
_ERROR_PER_CORNER = 0.25


class EdgeArea(NamedTuple):
    """Contact area of the continuum, and its estimated errors.

    Attributes
    ----------
    area : float
        Contact area (length^2), extrapolated from the areas by all grid points and by
        every other one, if errors are proportional to the square of the spacing.
    error : float
        Estimated error of the area (length^2).
    corner_error : float
        Part of the error at corners of the indenter (length^2).
    plastic_error : float
        Part of the error at points under the hardness (length^2).
    """

    area: float
    error: float
    corner_error: float = 0.0
    plastic_error: float = 0.0


def edge_area(
    pressure: np.ndarray,
    gap: np.ndarray,
    spacing: float,
    contact_modulus: float,
    periodic: bool,
    hardness: float = math.inf,
) -> EdgeArea:
    r"""Return the contact area of the continuum from the fields of one grid.

    The estimated error is

    .. math:: 0.25\, |A - A_2| + [0.006\, S_d + 0.08\, |c|^2 (S_d - S_c)
              + 0.25\, S_c + 0.02\, S_p]\, \Delta x
              + (0.5 + 0.3\, n_o + 0.5\, n_c)\, \Delta x^2

    with the change :math:`A - A_2` if every other point is left out, the perimeter
    :math:`S_d` along the lines of the grid, its parts :math:`S_c` at corners of the
    indenter and :math:`S_p` at points under the hardness, the mean c of
    :math:`e^{2 \pi i t^3}` over the sides that the edge cuts, and, in strips that the
    grid does not resolve, the numbers :math:`n_o` of open points and :math:`n_c` of
    points in contact.

    Parameters
    ----------
    pressure : ndarray, shape (n, m)
        Reaction of the wall: positive in contact, zero elsewhere (pressure).
    gap : ndarray, shape (n, m)
        Gap: zero in contact, or negative in plastic contact (length).
    spacing : float
        Distance of grid points (length).
    contact_modulus : float
        Contact modulus E* of the surface for the shortest waves (pressure).
    periodic : bool
        Whether opposite edges of the window are neighbours; otherwise points beyond the
        edges carry no pressure and have the gap of the nearest point.
    hardness : float
        Largest pressure (pressure).

    Returns
    -------
    EdgeArea
        Area and estimated errors.
    """
    if not periodic:
        box = _box(pressure > 0.0)
        pressure, gap = np.pad(pressure[box], 2), np.pad(gap[box], 2, "edge")
    sides = open_sides(pressure > 0.0, periodic)
    plastic = sides[pressure >= hardness].sum()
    gap = 0.75 * contact_modulus / spacing * gap.clip(0.0)
    corner, corners = _corners(pressure, gap)
    fields = [pressure, gap, corner]
    if periodic:
        fields = [np.pad(field, ((0, 2), (0, 2)), "wrap") for field in fields]
    fine, cut = _covered(fields, 1)
    coarse, _ = _covered(fields, 2)
    perimeter = sides.sum()
    change = fine - coarse + _EDGE_CORRECTION * perimeter
    area = fine - _EDGE_CORRECTION * perimeter + change / 3.0
    corner_error = _ERROR_PER_CORNER * corners
    plastic_error = _ERROR_PER_PLASTIC * plastic
    error = _ERROR_PER_CHANGE * abs(change) + _ERROR_PER_PERIMETER * perimeter
    aligned_error = _ERROR_OF_ALIGNED * _alignment(cut) ** 2 * (perimeter - corners)
    error += aligned_error + (corner_error + plastic_error)
    error += 0.5 + _unresolved(pressure)
    return EdgeArea(
        area=float(spacing**2 * area),
        error=float(spacing**2 * error),
        corner_error=float(spacing**2 * corner_error),
        plastic_error=float(spacing**2 * plastic_error),
    )


def _box(contact: np.ndarray) -> tuple[slice, slice]:
    """Return the bounding box of a contact, padded by up to two points."""
    rows = np.flatnonzero(contact.any(axis=1))
    columns = np.flatnonzero(contact.any(axis=0))
    return (
        slice(max(rows[0] - 2, 0), rows[-1] + 3),
        slice(max(columns[0] - 2, 0), columns[-1] + 3),
    )


def _unresolved(pressure: np.ndarray) -> float:
    """Return the error by strips between points in contact, in units of a point."""
    error, contact = 0.0, pressure > 0.0
    for axis in (0, 1):
        before, after = np.roll(pressure, 1, axis), np.roll(pressure, -1, axis)
        low = pressure < 0.5 * _LOW_PRESSURE_RATIO * (before + after)
        low &= (before > 0.0) & (after > 0.0)
        closed = np.count_nonzero(low & contact)
        error += _ERROR_PER_CLOSED * closed
        error += _ERROR_PER_OPEN * (np.count_nonzero(low) - closed)
    return error


def _corners(pressure: np.ndarray, gap: np.ndarray) -> tuple[np.ndarray, int]:
    """Return which points are at corners of the indenter, and their number of sides.

    Gaps are in units in which rho of two neighbours is g/p.
    """
    contact = pressure > 0.0
    corner, sides = np.zeros(contact.shape, bool), 0
    for axis in (0, 1):
        for step in (1, -1):
            edge = contact & ~np.roll(contact, -step, axis)
            here = np.unravel_index(np.flatnonzero(edge), contact.shape)
            inside = _neighbour(here, -step, axis, pressure)
            outside = _neighbour(here, step, axis, gap)
            found = outside > _RATIO_AT_CORNER * pressure[here]
            found &= (inside > 0.0) & (inside <= pressure[here])
            corner[here] |= found
            sides += int(found.sum())
    return corner, sides


def _neighbour(
    here: tuple[np.ndarray, ...], step: int, axis: int, values: np.ndarray
) -> np.ndarray:
    """Return the values of neighbours of points, periodic, shape (points,)."""
    moved = list(here)
    moved[axis] = (here[axis] + step) % values.shape[axis]
    return values[tuple(moved)]


def _alignment(cut: np.ndarray) -> float:
    """Return one if the edge cuts all sides at the same part, less if the parts differ.

    The argument is the parts of cut sides in contact.
    """
    return float(abs(np.exp(2j * math.pi * cut).mean())) if cut.size else 0.0


def _covered(fields: list[np.ndarray], k: int) -> tuple[float, np.ndarray]:
    """Return the area in contact from squares of k points, and parts of cut sides.

    The fields are pressures, gaps in the units of `_corners`, and corners. The last two
    rows and columns begin no square.
    """
    contact, width = fields[0] > 0.0, fields[0].shape[1]
    n, m = contact.shape[0] - 2, width - 2
    touching = np.zeros((n, m), np.int8)  # number of corners of a square in contact
    for i, j in (0, 0), (k, 0), (0, k), (k, k):
        touching += contact[i : i + n, j : j + m]
    cut_by_edge = (touching > 0) & (touching < 4)
    rows, columns = np.divmod(np.flatnonzero(cut_by_edge), m)
    first, along_x, along_y = rows * width + columns, k * width, k
    values = [contact.ravel(), *(field.ravel() for field in fields)]
    x_sides, y_sides = _parts(values, along_x, k), _parts(values, along_y, k)
    left, right = x_sides[first], x_sides[first + along_y]
    lower, upper = y_sides[first], y_sides[first + along_x]
    diagonal = math.sqrt(2.0) * k
    rising = _parts(values, along_x + along_y, diagonal)[first]
    falling = _parts(values, along_x - along_y, diagonal)[first + along_y]
    area = np.count_nonzero(touching == 4) + 0.25 * (
        _triangles(left, upper, rising)
        + _triangles(lower, right, rising)
        + _triangles(left, lower, falling)
        + _triangles(right, upper, falling)
    )
    sides = np.concatenate([left, lower])
    return area, sides[(sides > 0.0) & (sides < 1.0)]


def _parts(values: list[np.ndarray], step: int, length: float) -> np.ndarray:
    """Return the parts in contact of the sides from all points to points further on.

    Parameters
    ----------
    values : list of ndarray, shape (points,)
        Contact, pressure, gap and corners of the points in rows.
    step : int
        Number of points from one end of a side to the other.
    length : float
        Length of a side (spacings).

    Returns
    -------
    ndarray, shape (points - step,)
        The last sides of a row may end in the next one.
    """
    contact, pressure, gap, corners = values
    part = (contact[:-step] & contact[step:]).astype(float)
    cut = np.flatnonzero(contact[:-step] != contact[step:])
    # pressure and corner are zero for the open point, the gap is zero for the other one
    p = pressure[cut] + pressure[cut + step]
    g = gap[cut] + gap[cut + step]
    corner = corners[cut] | corners[cut + step]
    # t = u - v with u^3 - v^3 = 1 and 3 u v = rho^(2/3)
    ratio = g / (p * length)
    u = np.cbrt(0.5 + np.sqrt(0.25 + ratio**2 / 27.0))
    uv = np.cbrt(ratio**2) / 3.0
    root = 1.0 / (u**2 + uv + (uv / u) ** 2)
    part[cut] = np.where(corner, 0.5, root**3)
    return part


def _triangles(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> float:
    """Return the sum of the parts of triangles in contact, from parts of the sides."""
    return float(np.sum(x * y + y * z + z * x - 2.0 * x * y * z))
