"""Noise, outliers, filter and edges of scans, and copies that show their errors."""

import math

import numpy as np
import pytest

from ase_roughcontact import HeightMap, SelfAffine
from ase_roughcontact.topography.noise import Noise, outliers
from ase_roughcontact.topography.spectrum import (
    edge_step,
    has_edge_step,
    smooth_component,
)

SURFACE = SelfAffine(0.1, 0.8, 4.0, 64.0, seed=3, domain=256.0)
HEIGHTS = SURFACE.heights((256, 256), 1.0)
SPIKE = HEIGHTS.copy()
SPIKE[100, 50] += 3.0


def scanned(heights, **options):
    return HeightMap.from_topography(heights, "substrate", spacing=1.0, **options)


@pytest.mark.parametrize("points", [0.0, 0.01, 0.1])
@pytest.mark.parametrize("lines", [0.0, 0.1])
def test_noise_of_points_and_of_lines_is_found_on_a_rough_surface(points, lines):
    scan = HEIGHTS + Noise(points, lines).sample(HEIGHTS.shape, 1)
    scan[10:20, 5] = np.nan
    noise = Noise.of(scan)
    assert noise.points == pytest.approx(points, rel=0.03, abs=5e-4)
    assert noise.lines == pytest.approx(lines, rel=0.25, abs=0.01)


@pytest.mark.parametrize("shape", [(32, 512), (512, 32)])
def test_noise_of_points_of_an_oblong_scan_is_not_one_of_lines(shape):
    found = [Noise.of(Noise(1.0, 0.0).sample(shape, seed)).lines for seed in range(8)]
    assert np.mean(found) < 0.1
    lines = Noise(0.0, 1.0).sample(shape, 0)
    assert np.ptp(lines, axis=0).max() == 0.0
    assert lines[0].std() == pytest.approx(1.0, rel=0.3)


def test_a_filtered_scan_that_is_made_periodic_has_no_noise_at_its_edges():
    options = {"noise": 0.0, "cutoff_wavelength": 8.0}
    flat = scanned(HEIGHTS[:100, :90], **options).made_periodic()
    assert flat.edge_change > 0.0
    assert flat.measurement.noise_slope == 0.0
    assert flat.copies()["noisy"] == []


def test_a_given_noise_replaces_the_estimate():
    assert scanned(HEIGHTS, noise="0.002 nm").measurement.noise.points == 0.02
    assert scanned(HEIGHTS, noise=0.0).measurement.noise == Noise()
    with pytest.raises(ValueError, match="noise"):
        scanned(HEIGHTS, noise=-1.0)


def test_the_slope_of_noise_adds_in_squares():
    other = Noise(0.05, 0.03).sample(HEIGHTS.shape, 9)  # than in copies
    noisy = scanned(HEIGHTS + other)
    square, more = noisy.statistics().rms_slope ** 2, noisy.measurement.noise_slope**2
    expected = scanned(HEIGHTS).statistics().rms_slope
    assert math.sqrt(square - more) == pytest.approx(expected, rel=0.03)
    copies = [each.statistics().rms_slope ** 2 for each in noisy.copies()["noisy"]]
    assert copies == pytest.approx(4 * [square + more], rel=0.03)


def test_single_points_that_stick_out_are_outliers_and_rough_surfaces_have_none():
    assert not outliers(HEIGHTS).any()
    assert np.argwhere(outliers(SPIKE)).tolist() == [[100, 50]]
    assert scanned(SPIKE).measurement.outliers == 1


def test_a_removed_outlier_is_interpolated():
    kept, removed = (scanned(SPIKE, remove_outliers=flag) for flag in (False, True))
    for surface, height in ((kept, 3.0), (removed, 0.0)):
        at = surface.heights((1, 1), 1.0, (100.0 - 128.0, 50.0 - 128.0))[0, 0]
        before = HEIGHTS[100, 50] - HEIGHTS.mean()
        assert -at == pytest.approx(before + height, abs=0.2)


def test_the_filter_halves_a_wave_of_its_cutoff_wavelength():
    wave = np.cos(2.0 * np.pi * np.arange(64) / 16.0)[:, None] * np.ones((1, 64))
    for periodic in (True, False):
        options = {"periodic": periodic, "detrend": "mean"}
        filtered = scanned(wave, cutoff_wavelength=16.0, **options)
        whole = scanned(wave, **options)
        ratio = filtered.statistics().rms_height / whole.statistics().rms_height
        assert ratio == pytest.approx(0.5, rel=1e-2 if not periodic else 1e-4)


def test_the_slope_that_a_filter_removed_is_distinguished_from_noise():
    noisy = HEIGHTS + Noise(0.05, 0.0).sample(HEIGHTS.shape, 1)
    slope = scanned(HEIGHTS).statistics().rms_slope
    for cutoff in (4.0, 8.0):
        filtered = scanned(noisy, cutoff_wavelength=cutoff)
        left = scanned(HEIGHTS, cutoff_wavelength=cutoff).statistics().rms_slope
        assert filtered.measurement.lost_slope == pytest.approx(
            1.0 - left / slope, abs=0.05
        )
    assert scanned(noisy).measurement.lost_slope == 0.0


def test_waves_below_the_advised_cutoff_are_noise():
    noisy = HEIGHTS + Noise(0.05, 0.0).sample(HEIGHTS.shape, 1)
    least = scanned(noisy).measurement.least_wavelength
    assert 3.0 < least < 6.0
    assert scanned(noisy, cutoff_wavelength=least).statistics().rms_slope < 0.11


@pytest.mark.parametrize("shape", [(256, 256), (255, 200)])
@pytest.mark.parametrize("periodic", [False, True])
def test_copies_with_fewer_pixels_are_samples_of_the_same_surface(shape, periodic):
    n, m = shape
    x, y = np.arange(n)[:, None] / n, np.arange(m) / m
    wave = np.sin(4.0 * np.pi * (x + y) + 0.3)
    surface = scanned(wave, periodic=periodic, detrend="none")
    half, quarter = surface.copies()["coarser"]
    place = (11, 9), 1.37, (-7.3, -4.1)
    expected = surface.heights(*place)
    for each, pixels in ((half, 2), (quarter, 4)):
        assert each.shape[0] == pytest.approx(n / pixels, abs=1.0)
        np.testing.assert_allclose(each.heights(*place), expected, atol=1e-3)


def test_edges_of_a_part_of_a_scan_do_not_fit_and_edges_of_its_period_do():
    assert not has_edge_step(HEIGHTS)
    part = HEIGHTS[:100, :100]
    across, beside = edge_step(part)
    assert has_edge_step(part)
    sides = part[0] - part[-1], part[:, 0] - part[:, -1]
    steps = [math.sqrt(np.mean(side**2)) for side in sides]
    assert any(across == pytest.approx(step) for step in steps)
    assert beside < 0.1


@pytest.mark.parametrize("cutoff", [0.0, 2.0])
def test_a_copy_of_a_part_declared_periodic_has_edges_that_fit(cutoff):
    part = scanned(HEIGHTS[:100, :60], periodic=True, cutoff_wavelength=cutoff)
    (copy,) = part.copies()["seamless"]
    place = (100, 60), 1.0, (-50.0, -30.0)
    heights = part.heights(*place)
    assert has_edge_step(heights)
    np.testing.assert_allclose(
        copy.heights(*place), heights - smooth_component(heights), atol=1e-12
    )
    assert not has_edge_step(copy.heights(*place))
    assert not scanned(HEIGHTS, periodic=True).copies()["seamless"]


def test_a_part_of_a_scan_declared_periodic_keeps_slope_and_curvature():
    part = HEIGHTS[:128, :128]
    for heights, tolerance in ((part, 1e-12), (HEIGHTS, 0.01)):
        once, periodic = (
            vars(scanned(heights, periodic=flag, detrend="mean").statistics())
            for flag in (False, True)
        )
        assert periodic == pytest.approx(once, rel=tolerance)
