"""Radius and reach of a scan that is a whole tip."""

import numpy as np
import pytest

from ase_roughcontact import HeightMap, RoughSphere, SelfAffine
from ase_roughcontact.windows.footprint import Footprint

X, Y = np.meshgrid(np.arange(-32.0, 32.0), np.arange(-30.0, 34.0), indexing="ij")
TIP = (X**2 + Y**2) / 40.0
ROUGH = SelfAffine(0.1, 0.8, 4.0, 16.0, seed=1).heights((64, 64), 1.0)


@pytest.mark.parametrize("spacing", [1.0, 2.5])
def test_the_radius_of_a_paraboloid_is_exact(spacing):
    tip = HeightMap(TIP, spacing).tip
    assert tip.radius == pytest.approx(20.0 * spacing**2)
    assert tip.share == pytest.approx(1.0)
    assert tip.is_tip


def test_the_radius_of_a_sphere_is_that_of_its_apex():
    sphere = 80.0 - np.sqrt(80.0**2 - X**2 - Y**2)
    assert HeightMap(sphere, 1.0).tip.radius == pytest.approx(80.0, rel=1e-3)


def test_roughness_and_tilt_change_the_radius_little():
    tip = HeightMap(TIP + ROUGH + 0.05 * X, 1.0).tip
    assert tip.is_tip
    assert tip.radius == pytest.approx(20.0, rel=0.15)


@pytest.mark.parametrize("heights", [ROUGH, -TIP, TIP[32:], np.zeros((9, 9))])
def test_roughness_a_reversed_tip_and_an_edge_are_no_tips(heights):
    assert not HeightMap(heights, 1.0).tip.is_tip


def test_the_reach_of_a_map_of_unequal_sides_and_spacings():
    x, y = np.arange(30.0)[:, None], 0.5 * np.arange(50.0)
    heights = ((x - 5.0) ** 2 + 4.0 * (y - 20.0) ** 2) / 40.0
    surface = HeightMap(heights, (1.0, 0.5), center=(12.0, 8.0))
    x, y = np.arange(-12.0, 17.0, 0.25), np.arange(-8.0, 16.5, 0.25)
    low = surface.heights((len(x), len(y)), 0.25, (x[0], y[0])) < 0.8
    farthest = np.hypot(x[:, None], y)[low].max()
    assert farthest <= surface.reach(0.8, 0.25) < farthest + 6.0
    assert surface.reach(-9.0, 0.25) == 0.0


def test_the_reach_has_the_places_between_points():
    heights = np.zeros((40, 40))
    heights[25, 20] = -1.0
    surface = HeightMap(heights, 1.0)
    x = np.arange(-10.0, 10.0, 0.1)
    low = surface.heights((len(x), len(x)), 0.1, (-10.0, -10.0)) < -0.4
    assert 5.3 < np.hypot(x[:, None], x[None, :])[low].max() <= surface.reach(-0.4, 0.1)


def test_windows_of_a_tip_follow_from_its_scan():
    surface = HeightMap(TIP, 1.0, center=(32.0, 30.0))
    whole = Footprint(RoughSphere(np.inf, surface), 0.5)
    assert whole.box_below(1.0) == Footprint(RoughSphere(20.0), 0.5).box_below(1.0)
