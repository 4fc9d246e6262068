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


def test_the_radius_of_a_sphere_is_fitted_at_its_apex():
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


def test_a_bump_on_a_tilted_flat_is_no_tip():
    bump = ROUGH + 0.1 * X - 8.0 * np.exp(-(X**2 + Y**2) / 50.0)
    tip = HeightMap(bump, 1.0).tip
    assert tip.radius < np.inf
    assert not tip.is_tip
    assert tip.share == pytest.approx(
        HeightMap(bump - 0.1 * X, 1.0).tip.share, abs=1e-12
    )


@pytest.mark.parametrize("seed", range(4))
def test_a_rough_flat_with_the_bow_of_a_scanner_is_no_tip(seed):
    rough = SelfAffine(0.1, 0.8, 4.0, 64.0, seed=seed).heights((64, 64), 1.0)
    for bow in ((X**2 + Y**2) / 1000.0, X**2 / 400.0):
        tip = HeightMap(rough + bow, 1.0).tip
        assert not tip.is_tip
        assert tip.may_be_bow


def test_a_lens_is_a_tip_that_may_be_a_bow():
    lens = 2000.0 - np.sqrt(2000.0**2 - X**2 - Y**2)
    tip = HeightMap(lens + 0.05 * ROUGH, 1.0).tip
    assert tip.is_tip
    assert tip.may_be_bow
    assert not HeightMap(TIP, 1.0).tip.may_be_bow
    # of a paraboloid z = r^2/2R on a square of side L: L/4R
    assert HeightMap(TIP, 1.0).tip.rise == pytest.approx(64.0 / (4.0 * 20.0))


def test_the_error_of_the_radius_agrees_with_many_rough_tips():
    radii, errors = [], []
    for seed in range(20):
        rough = SelfAffine(0.1, 0.8, 4.0, 16.0, seed=seed, domain=64.0)
        tip = HeightMap(TIP + rough.heights((64, 64), 1.0), 1.0).tip
        radii.append(tip.radius)
        errors.append(tip.error * tip.radius)
    scatter = np.sqrt(np.mean((np.array(radii) - 20.0) ** 2))
    assert np.sqrt(np.mean(np.square(errors))) == pytest.approx(scatter, rel=0.6)


def test_unequal_curvatures_are_in_the_error():
    ridge = X**2 / 40.0 + Y**2 / 160.0
    assert HeightMap(ridge, 1.0).tip.error > 0.15
    assert HeightMap(TIP, 1.0).tip.error < 1e-9


def test_a_tip_is_sought_inside_the_margin_of_a_scan():
    tip = TIP + 0.05 * ROUGH
    tip[2, 3] = -50.0  # debris on the edge
    scan = {"role": "indenter", "spacing": 1.0, "detrend": "none"}
    whole = HeightMap.from_topography(-tip, **scan)
    assert whole.tip.at_edge
    assert not whole.tip.is_tip
    inside = HeightMap.from_topography(-tip, **scan, margin=6.0)
    assert inside.tip.is_tip
    assert inside.tip.radius == pytest.approx(20.0, rel=0.05)
