"""Lowest point of a surface between the points of a grid."""

import numpy as np
import pytest

from ase_roughcontact.topography.lowest_point import lowest_point_error

LINE = np.arange(-8.0, 9.0)


def axial(exponent, x, y):
    """Return the heights r^n about an axis, with the lowest point zero."""
    return np.hypot(LINE[:, None] - x, LINE - y) ** exponent


@pytest.mark.parametrize("x, y", [(0.0, 0.0), (0.37, 0.0), (0.5, -0.5), (-0.2, 0.4)])
def test_paraboloid_is_exact(x, y):
    heights = axial(2.0, x, y)
    found = lowest_point_error(heights)
    assert found == pytest.approx(heights.min(), abs=1e-12)


@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize("x, y", [(0.37, 0.0), (0.37, 0.13), (0.5, 0.5), (-0.2, 0.4)])
def test_apex_between_points_is_within_twice_the_estimate(exponent, x, y):
    heights = axial(exponent, x, y)
    assert 0.5 * heights.min() < lowest_point_error(heights) < 2.0 * heights.min()


def test_apex_at_a_point_is_known():
    assert lowest_point_error(axial(1.0, 0.0, 0.0)) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("high", [2.0, 1e3])
def test_flat_punch_has_no_point_below_its_face(high):
    heights = high * (np.hypot(LINE[:, None], LINE) > 4.3)
    assert lowest_point_error(heights) == 0.0
    assert lowest_point_error(np.zeros((4, 4))) == 0.0


def test_surface_continues_periodically_or_flat():
    heights = axial(2.0, 0.3, 0.1)
    inside = lowest_point_error(heights)
    rolled = np.roll(heights, (9, 9), (0, 1))  # the lowest point in a corner
    assert rolled.argmin() == 0
    assert lowest_point_error(rolled, periodic=True) == pytest.approx(inside)
    assert lowest_point_error(heights[8:, 8:]) < inside
