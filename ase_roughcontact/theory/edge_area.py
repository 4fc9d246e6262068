r"""Contact area of the continuum under a hard wall, from the fields at its edge.

At a distance d inside the edge of a contact without attraction the pressure is
:math:`B \sqrt{d}`, and outside the gap is :math:`(4 B/3 E^*)\, d^{3/2}` (K. L. Johnson,
Contact Mechanics, 1985, chapter 5). Between a grid point in contact, with the pressure
p, and an open one at a distance l, with the gap g, the edge is where both have the
same B: the part t^3 of the distance is in contact, with

.. math:: t^3 + \rho^{2/3}\, t = 1, \qquad \rho = \frac{3 E^* g}{4 p\, l}.

The part of a triangle in contact follows from those of its sides. The area is the mean
for the two ways of cutting the squares of the grid into triangles.

At a corner of the indenter, such as the edge of a flat punch, the pressure rises to the
edge instead. The edge is then somewhere between the two points, taken in the middle.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

# Area by which edges are too far out, per perimeter along the grid and spacing, as the
# sides cross them at an angle: 0.0144 to 0.0180, mean 0.0158, for smooth spheres at
# contact radii of 90 to 256 spacings.
_EDGE_CORRECTION = 0.0158
# Estimated error, in parts of the change by every other point and of the perimeter
# times the spacing: chosen on the rough spheres and flats of
# examples/benchmarks/edge_area.py, and tested on other spheres by answer_errors.py.
_ERROR_PER_CHANGE, _ERROR_PER_PERIMETER = 0.25, 0.006
# The same of the perimeter with fewer than 4 points on the shortest wave: with 2 points
# 96 % of 72 areas were within twice the estimate, 82 % without it.
_ERROR_UNRESOLVED = 0.036
# Ratio rho from which on the pressure next to an edge is small. If it is not below that
# further inside, the point is at a corner of the indenter: 85 to 100 % of the sides at
# edges of punches, 0.01 % or less on the surfaces of examples/benchmarks/edge_area.py.
_RATIO_AT_CORNER = 30.0
# Estimated error per length of edges at corners, in units of the spacing: half of the
# largest one.
_ERROR_PER_CORNER = 0.25
# Lower bound of rho^(2/3), which avoids a division by zero.
_TINY = 1e-12


class EdgeArea(NamedTuple):
    """Contact area of the continuum, and what its error is estimated from.

    Attributes
    ----------
    area : float
        Extrapolated from the areas by the fields at all grid points and at every other
        one, with an error proportional to the square of the spacing (length^2).
    change : float
        Difference of these two areas (length^2).
    corners: float
        Length of the boundary of the contact, along the lines of the grid, at corners
        of the indenter (length).
    """

    area: float
    change: float
    corners: float = 0.0


def edge_area(
    pressure: np.ndarray,
    gap: np.ndarray,
    perimeter: float,
    spacing: float,
    contact_modulus: float,
    periodic: bool,
) -> EdgeArea:
    """Return the contact area of the continuum from the fields of one grid.

    Parameters
    ----------
    pressure : ndarray, shape (n, m)
        Positive in contact, zero elsewhere (pressure).
    gap : ndarray, shape (n, m)
        Zero in contact (length).
    perimeter : float
        Boundary of the contact along the lines of the grid (length).
    spacing : float
        Distance of grid points (length).
    contact_modulus : float
        E* of the surface, that of the shortest waves (pressure).
    periodic : bool
        Whether opposite edges of the window are neighbours; otherwise points beyond the
        edges carry no pressure and have the gap of the nearest point.

    Returns
    -------
    EdgeArea
    """
    if not periodic:
        box = _box(pressure > 0.0)
        pressure, gap = np.pad(pressure[box], 2), np.pad(gap[box], 2, "edge")
    gap = 0.75 * contact_modulus / spacing * gap.clip(0.0)
    corner, sides = _corners(pressure, gap)
    fields = [pressure, gap, corner]
    if periodic:
        fields = [np.pad(field, ((0, 2), (0, 2)), "wrap") for field in fields]
    fine, coarse = (
        spacing**2 * _covered(fields, stride)
        - stride * _EDGE_CORRECTION * perimeter * spacing
        for stride in (1, 2)
    )
    return EdgeArea(fine + (fine - coarse) / 3.0, fine - coarse, sides * spacing)


def edge_error(
    found: EdgeArea, perimeter: float, spacing: float, shortest_wave: float = math.inf
) -> float:
    r"""Return the estimated error of the area by `edge_area`.

    .. math:: 0.25\, |A - A_2| + 0.006\, S_d \Delta x + 0.25\, S_c \Delta x
              + 0.5\, \Delta x^2

    with the part S_c of the boundary at corners of the indenter, and another
    :math:`0.036\, S_d \Delta x` if the shortest wave of the surface has fewer than 4
    points.

    Parameters
    ----------
    found : EdgeArea
    perimeter : float
        Boundary S_d of the contact along the lines of the grid (length).
    spacing : float
        Distance of grid points (length).
    shortest_wave : float
        Of the surface (length); infinity for a smooth one.

    Returns
    -------
    float
        Length^2.
    """
    per_perimeter = _ERROR_PER_PERIMETER
    if shortest_wave < (4.0 - 1e-6) * spacing:
        per_perimeter += _ERROR_UNRESOLVED
    of_edge = per_perimeter * perimeter * spacing + corner_error(found, spacing)
    return _ERROR_PER_CHANGE * abs(found.change) + of_edge + 0.5 * spacing**2


def corner_error(found: EdgeArea, spacing: float) -> float:
    """Return the part of `edge_error` at corners of the indenter (length^2)."""
    return _ERROR_PER_CORNER * found.corners * spacing


def _box(contact: np.ndarray) -> tuple[slice, slice]:
    """Return the box of a contact with a frame of two points, as far as there are."""
    ends = (np.flatnonzero(contact.any(axis)) for axis in (1, 0))
    rows, columns = (slice(max(end[0] - 2, 0), end[-1] + 3) for end in ends)
    return rows, columns


def _corners(pressure: np.ndarray, gap: np.ndarray) -> tuple[np.ndarray, int]:
    """Return which points are at corners of the indenter, and how many sides.

    Gaps are in units in which rho of two neighbours is g/p.
    """
    contact = pressure > 0.0
    corner, sides = np.zeros(contact.shape, bool), 0
    for step in np.array([(1, 0), (-1, 0), (0, 1), (0, -1)]):
        points = np.argwhere(contact & ~np.roll(contact, -step, (0, 1)))
        at, outside, inside = (
            tuple(((points + way) % contact.shape).T) for way in (0 * step, step, -step)
        )
        found = gap[outside] > _RATIO_AT_CORNER * pressure[at]
        found &= contact[inside] & (pressure[inside] <= pressure[at])
        corner[at] |= found
        sides += int(found.sum())
    return corner, sides


def _covered(fields: list[np.ndarray], k: int) -> float:
    """Return the mean number of squares of k points that are in contact, times k^2.

    The fields are pressures, gaps in the units of `_corners`, and corners. The last two
    rows and columns begin no square.
    """
    n, m = fields[0].shape[0] - 2, fields[0].shape[1] - 2

    def side(i: int, j: int, a: int, b: int) -> np.ndarray:
        ends = np.s_[i : i + n, j : j + m], np.s_[a : a + n, b : b + m]
        return _part(fields, ends, math.hypot(a - i, b - j))

    left, right, lower, upper, rising, falling = (
        side(0, 0, k, 0),
        side(0, k, k, k),
        side(0, 0, 0, k),
        side(k, 0, k, k),
        side(0, 0, k, k),
        side(k, 0, 0, k),
    )
    return 0.25 * float(
        _triangles(left, upper, rising)
        + _triangles(lower, right, rising)
        + _triangles(left, lower, falling)
        + _triangles(right, upper, falling)
    )


def _part(fields: list[np.ndarray], ends: tuple[Any, Any], length: float) -> np.ndarray:
    """Return the part in contact of the sides between two points each."""
    first, second = (fields[0][end] > 0.0 for end in ends)
    part = (first & second).astype(float)
    mixed = first != second
    # pressure and corner of the open point and the gap of the other one are zero
    p, g, corner = (sum(values[end][mixed] for end in ends) for values in fields)
    ratio = np.maximum((g / (p * length)) ** (2.0 / 3.0), _TINY) / 3.0
    root = 2.0 * np.sqrt(ratio) * np.sinh(np.arcsinh(0.5 * ratio**-1.5) / 3.0)
    part[mixed] = np.where(corner, 0.5, root**3)
    return part


def _triangles(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> float:
    """Return the sum of the parts of triangles in contact, from those of sides."""
    return float(np.sum(x * y + y * z + z * x - 2.0 * x * y * z))
