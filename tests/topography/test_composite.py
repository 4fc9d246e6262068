"""The roughness of two bodies: sums of heights, statistics and bounds."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ase_roughcontact import (
    CompositeRoughness,
    HeightMap,
    Inverted,
    RoughSphere,
    SelfAffine,
)
from ase_roughcontact.theory.self_affine import rms_curvature, rms_height
from ase_roughcontact.topography.spectrum import statistics

TIP = SelfAffine(0.03, 0.8, 4.0, 16.0, seed=1)
BASE = SelfAffine(0.04, 0.8, 4.0, 16.0, seed=2)
BOTH = CompositeRoughness([TIP, Inverted(BASE)])


def test_heights_are_the_height_of_the_tip_less_the_height_of_the_substrate():
    grid = (20, 12), 1.0, (-3.0, 2.0)
    by_hand = TIP.heights(*grid) - BASE.heights(*grid)
    assert BOTH.heights(*grid) == pytest.approx(by_hand, abs=1e-14)
    sphere = RoughSphere(50.0, BOTH).heights(*grid)
    smooth = RoughSphere(50.0).heights(*grid)
    assert sphere - smooth == pytest.approx(by_hand, abs=1e-12)


def test_mean_squares_are_sums_within_the_scatter_of_realisations():
    # with fine grids and many waves, correlations of two realisations are small
    ratios = []
    for seed in range(8):
        tip = SelfAffine(0.03, 0.8, 4.0, 16.0, seed=seed, domain=128.0)
        base = SelfAffine(0.04, 0.8, 4.0, 16.0, seed=100 + seed, domain=128.0)
        both = CompositeRoughness([tip, Inverted(base)])
        sampled = statistics(both.heights((128, 128), 1.0), 1.0)
        of_sum = both.statistics()
        ratios.append(
            [
                sampled.rms_height / of_sum.rms_height,
                sampled.rms_slope / of_sum.rms_slope,
                sampled.rms_curvature / of_sum.rms_curvature,
            ]
        )
    mean, error = np.mean(ratios, 0), np.std(ratios, 0, ddof=1) / np.sqrt(8)
    assert (abs(mean - 1.0) < 4.0 * error).all()
    assert (error < 0.02).all()


def test_equal_spectra_give_the_spectrum_of_both_to_theory():
    assert BOTH.rms_slope == pytest.approx(0.05)
    assert (BOTH.hurst, BOTH.short_wavelength, BOTH.long_wavelength) == (0.8, 4.0, 16.0)


def test_other_spectra_give_a_range_with_the_statistics_of_the_sum():
    coarse = SelfAffine(0.02, 0.8, 16.0, 400.0, seed=3)
    both = CompositeRoughness([TIP, coarse])
    found = both.statistics()
    assert both.hurst == pytest.approx(0.8)
    assert found.rms_height == pytest.approx(
        np.hypot(TIP.statistics().rms_height, coarse.statistics().rms_height)
    )
    assert rms_height(both) == pytest.approx(found.rms_height, rel=0.01)


def test_bounds_of_the_sum_hold_on_every_grid():
    for origin in (0.0, 0.0), (0.3, -7.6):
        lowest = BOTH.heights((64, 64), 1.0, origin).min()
        assert BOTH.lowest(1.0, origin) <= lowest
        assert BOTH.lowest(1.0, origin) >= 3.0 * lowest
        highest = BASE.heights((64, 64), 1.0, origin).max()
        assert Inverted(BASE).lowest(1.0, origin) == pytest.approx(-highest)


def test_a_window_does_not_exceed_the_smaller_domain():
    larger = SelfAffine(0.03, 0.8, 4.0, 16.0, domain=96.0)
    both = CompositeRoughness([TIP, larger])
    assert both.extent == 32.0
    assert both.periods == (np.inf, np.inf)
    assert both.part_of_period(np.array([48.0, 48.0])) == 0.5
    with pytest.raises(ValueError, match="64"):
        both.heights((80, 80), 1.0)


def test_maps_of_other_pixels_are_each_sampled_on_the_grid():
    x = np.arange(0.0, 41.0, 1.0)
    fine = HeightMap(0.01 * x[:, None] ** 2 + 0.0 * x, 1.0)
    coarse = HeightMap(0.02 * x[None, ::2] ** 2 + 0.0 * x[::2, None], 2.0)
    both = CompositeRoughness([fine, coarse]).heights((5, 7), 0.5)
    i, j = 20.0 + 0.5 * np.arange(5), 20.0 + 0.5 * np.arange(7)
    by_hand = 0.01 * i[:, None] ** 2 + 0.02 * j**2
    assert both == pytest.approx(by_hand, abs=1e-10)


def test_a_scanned_tip_bounds_the_contact_with_a_rough_substrate():
    x = np.arange(-40.0, 41.0)
    tip = HeightMap((x[:, None] ** 2 + x**2) / 40.0, 1.0)
    both = RoughSphere(np.inf, CompositeRoughness([tip, Inverted(BASE)]))
    level = 1.5
    reach = both.reach(level, 1.0)
    heights = both.heights((61, 61), 1.0, (-30.0, -30.0))
    x = np.arange(-30.0, 31.0)
    distance = np.hypot(x[:, None], x)[heights < level]
    assert distance.max() <= reach <= 2.0 * distance.max()


def test_waves_shorter_than_a_grid_are_removed_from_both():
    smooth = BOTH.band_limited(8.0)
    by_hand = TIP.band_limited(8.0).heights((16, 16), 4.0)
    by_hand = by_hand - BASE.band_limited(8.0).heights((16, 16), 4.0)
    assert smooth.heights((16, 16), 4.0) == pytest.approx(by_hand, abs=1e-14)


@pytest.mark.parametrize("directions", [(20.0, 20.0), (0.0, 90.0)])
def test_theory_of_two_anisotropic_bodies_has_their_height_and_curvature(directions):
    of_tip, of_base = directions
    tip = replace(TIP, anisotropy=4.0, direction=of_tip)
    base = replace(BASE, anisotropy=4.0, direction=of_base)
    expected = math.hypot(rms_height(tip), rms_height(base))
    assert rms_height(tip) == pytest.approx(tip.statistics().rms_height, rel=0.05)
    both = CompositeRoughness([tip, Inverted(base)])
    assert rms_height(both) == pytest.approx(expected)
    assert rms_height(Inverted(base)) == rms_height(base)
    curvature = math.hypot(rms_curvature(tip), rms_curvature(base))
    assert rms_curvature(both) == pytest.approx(curvature)


def test_theory_of_an_anisotropic_and_an_isotropic_body_has_their_statistics():
    both = CompositeRoughness([TIP, Inverted(replace(BASE, anisotropy=4.0))])
    statistics_of_both = both.statistics()
    assert rms_curvature(both) == pytest.approx(statistics_of_both.rms_curvature)
    height = statistics_of_both.rms_height
    assert rms_height(both) == pytest.approx(height, rel=0.05)


def test_one_surface_is_no_sum():
    with pytest.raises(ValueError, match="got 1"):
        CompositeRoughness([TIP])
    with pytest.raises(ValueError, match="heights"):
        CompositeRoughness([TIP, 1.0])
