r"""Lowest point of a surface between the points of a grid.

Along a line of the grid, the heights :math:`h_{-1}, h_0, h_1` at its lowest point and
next to it give the depth of the parabola through them below :math:`h_0`,

.. math:: \frac{(h_1 - h_{-1})^2}{8\, (h_1 - 2 h_0 + h_{-1})}.

It is exact for a smooth surface, and much too small for the apex of a cone. A surface
may be as low as two extrapolations to the same interval from its two sides allow: it is
convex there, and above both if they are straight lines; with parabolas they follow its
curvature, too. Under a flat surface, up to its edge, they leave no depth.
"""

import numpy as np

# Places in an interval at which extrapolations are compared, in units of its length.
_FRACTIONS = np.linspace(0.0, 1.0, 33)
# Points on either side of the lowest one.
_POINTS_PER_SIDE = 3


def lowest_point_error(heights: np.ndarray, periodic: bool = False) -> float:
    """Return an estimate of the lowest point's depth below the grid's (length).

    It is the sum over the two lines of the grid through the lowest point of the depth
    of the parabola, at most the depth of straight extrapolations, or half the depth of
    parabolic ones, if this is more. Unless opposite edges are neighbours (periodic),
    the surface continues flat.
    """
    i, j = divmod(int(heights.argmin()), heights.shape[1])
    lines = ((heights[:, j], i), (heights[i], j))
    return sum(_depth(line, centre, periodic) for line, centre in lines)


def _depth(heights: np.ndarray, centre: int, periodic: bool) -> float:
    """Return the error along a line of the grid, which is lowest at its centre."""
    around = centre + np.arange(-_POINTS_PER_SIDE, _POINTS_PER_SIDE + 1)
    around = around % heights.size if periodic else around.clip(0, heights.size - 1)
    line = heights[around]
    before, lowest, after = line[_POINTS_PER_SIDE - 1 : _POINTS_PER_SIDE + 2]
    bend = before - 2.0 * lowest + after
    parabola = (before - after) ** 2 / (8.0 * bend) if bend > 0.0 else 0.0
    straight = lowest - min(_lower_bound(line[:-1], 1), _lower_bound(line[1:], 1))
    bent = lowest - min(_lower_bound(line[:-1], 2), _lower_bound(line[1:], 2))
    return float(max(min(parabola, straight), 0.5 * bent, 0.0))


def _lower_bound(points: np.ndarray, order: int) -> float:
    """Return the lowest height between the middle two of six points.

    Polynomials of an order, 1 or 2, extrapolate from both sides.
    """
    left, right = _extrapolated(points[:3], order), _extrapolated(points[:2:-1], order)
    return float(np.maximum(left, right[::-1]).min())


def _extrapolated(points: np.ndarray, order: int) -> np.ndarray:
    """Return a polynomial through the last of three points, one spacing beyond them."""
    first, second, last = points
    t = _FRACTIONS
    line = last + t * (last - second)
    if order == 1:
        return line
    return line + 0.5 * t * (t + 1.0) * (last - 2.0 * second + first)
