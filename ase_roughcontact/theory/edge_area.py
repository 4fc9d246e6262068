r"""Contact area of the continuum under a hard wall, from the fields at its edge.

At a distance d inside the edge of an elastic contact the reaction of the wall is
:math:`B \sqrt{d}`, and outside the gap is :math:`(4 B/3 E^*)\, d^{3/2}` (K. L. Johnson,
Contact Mechanics, 1985, chapter 5). An attraction of finite tension acts on both sides
of the edge alike, and pressures are below a hardness there, so that this holds for all
hard walls. Between a grid point in contact, with the reaction p, and an open one at a
distance l, with the gap g, the edge is where both have the same B: the part t^3 of the
distance is in contact, with

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

from ase_roughcontact.theory.counted_area import open_sides

# Area by which edges are too far out, per perimeter along the grid and spacing, as the
# sides cross them at an angle: 0.0144 to 0.0180, mean 0.0158, for smooth spheres at
# contact radii of 90 to 256 spacings.
_EDGE_CORRECTION = 0.0158
# Estimated error, in parts of the change by every other point and of the perimeter
# times the spacing: chosen on the rough spheres and flats of
# examples/benchmarks/edge_area.py, and tested on other spheres by answer_errors.py.
_ERROR_PER_CHANGE, _ERROR_PER_PERIMETER = 0.25, 0.006
# The same of a straight edge along the grid, where all sides are cut at the same part:
# there the errors, of up to 0.15, do not average out.
_ERROR_OF_ALIGNED = 0.08
# The same of sides at a point under the hardness: the rim in which the pressure falls
# to zero may be narrower than the spacing.
_ERROR_PER_PLASTIC = 0.02
# Estimated errors per point, in units of its area, between two points in contact: of an
# open one, and of one in contact beside which the surface may be open. Strips are
# resolved if they are wider. The areas of 400 strips in Westergaard's contact, with
# openings of 0.3 to 1.7 points at six angles to the grid, were wrong by less than twice
# the whole estimate, and by up to 1.2 points per length where no point is open.
_ERROR_PER_OPEN, _ERROR_PER_CLOSED = 0.3, 0.5
# Ratio of a pressure to the mean of those next to it below which a parabola through the
# three may be negative between the points.
_MAY_OPEN = 0.2
# Ratio rho above which the pressure next to an edge is small. If it is not below that
# further inside, the point is at a corner of the indenter: 85 to 100 % of the sides at
# edges of punches, 0.01 % or less on the surfaces of examples/benchmarks/edge_area.py.
_RATIO_AT_CORNER = 30.0
# Estimated error per length of edges at corners, in units of the spacing: half of the
# largest one.
_ERROR_PER_CORNER = 0.25
# Lower bound of rho^(2/3), which avoids a division by zero.
_TINY = 1e-12


class EdgeArea(NamedTuple):
    """Contact area of the continuum, and its estimated errors.

    Attributes
    ----------
    area : float
        Extrapolated from the areas by the fields at all grid points and at every other
        one, with an error proportional to the square of the spacing (length^2).
    error : float
        Estimated error of the area (length^2).
    corner_error : float
        Part of it at corners of the indenter (length^2).
    plastic_error : float
        Part of it at points under the hardness (length^2).
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
    :math:`S_d` along the lines of the grid, the parts of it at corners of the indenter,
    :math:`S_c`, and at points under the hardness, :math:`S_p`, the mean c of
    :math:`e^{2 \pi i t^3}` over the sides that the edge cuts, and the numbers of open
    points :math:`n_o` and of others :math:`n_c` in strips that the grid does not
    resolve.

    Parameters
    ----------
    pressure : ndarray, shape (n, m)
        Reaction of the wall: positive in contact, zero elsewhere (pressure).
    gap : ndarray, shape (n, m)
        Zero in contact, or negative in plastic contact (length).
    spacing : float
        Distance of grid points (length).
    contact_modulus : float
        E* of the surface, that of the shortest waves (pressure).
    periodic : bool
        Whether opposite edges of the window are neighbours; otherwise points beyond the
        edges carry no pressure and have the gap of the nearest point.
    hardness : float
        Largest pressure.

    Returns
    -------
    EdgeArea
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
    (fine, aligned), (coarse, _) = (_covered(fields, stride) for stride in (1, 2))
    change = fine - coarse + _EDGE_CORRECTION * sides.sum()
    area = fine - _EDGE_CORRECTION * sides.sum() + change / 3.0
    errors = np.array([_ERROR_PER_CORNER * corners, _ERROR_PER_PLASTIC * plastic])
    error = _ERROR_PER_CHANGE * abs(change) + _ERROR_PER_PERIMETER * sides.sum()
    error += _ERROR_OF_ALIGNED * aligned**2 * (sides.sum() - corners) + errors.sum()
    error += 0.5 + _unresolved(pressure)
    return EdgeArea(*(spacing**2 * np.array([area, error, *errors])).tolist())


def _box(contact: np.ndarray) -> tuple[slice, slice]:
    """Return the box of a contact, padded by up to two points."""
    ends = (np.flatnonzero(contact.any(axis)) for axis in (1, 0))
    rows, columns = (slice(max(end[0] - 2, 0), end[-1] + 3) for end in ends)
    return rows, columns


def _unresolved(pressure: np.ndarray) -> float:
    """Return the error by strips between points in contact, in units of a point."""
    found, open_ = 0.0, pressure == 0.0
    for axis in (0, 1):
        before, after = (np.roll(pressure, step, axis) for step in (1, -1))
        low = pressure < 0.5 * _MAY_OPEN * (before + after)
        low &= (before > 0.0) & (after > 0.0)
        found += _ERROR_PER_OPEN * np.count_nonzero(low & open_)
        found += _ERROR_PER_CLOSED * np.count_nonzero(low & ~open_)
    return found


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


def _covered(fields: list[np.ndarray], k: int) -> tuple[float, float]:
    """Return the area in contact by squares of k points, and how aligned its edge is.

    The fields are pressures, gaps in the units of `_corners`, and corners. The last two
    rows and columns begin no square. The second result is one if the edge cuts all
    sides at the same part, and small if the parts differ.
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
    area = 0.25 * float(
        _triangles(left, upper, rising)
        + _triangles(lower, right, rising)
        + _triangles(left, lower, falling)
        + _triangles(right, upper, falling)
    )
    cut = np.concatenate([part[(part > 0.0) & (part < 1.0)] for part in (left, lower)])
    aligned = abs(np.exp(2j * math.pi * cut).mean()) if cut.size else 0.0
    return area, float(aligned)


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
