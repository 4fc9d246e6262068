"""Statistics and power spectra of heights on a grid."""

import math

import numpy as np
import pytest

from ase_roughcontact.topography import HeightMap
from ase_roughcontact.topography.spectrum import (
    power_spectrum,
    smooth_component,
    statistics,
)

BUMPS = np.random.default_rng(0).standard_normal((9, 12))


def wave(shape, spacing, kx, ky):
    """Build a plane wave of amplitude sqrt(2), and its wave number."""
    x, y = np.indices(shape)
    q = 2 * np.pi / spacing * np.hypot(kx / shape[0], ky / shape[1])
    phase = 2 * np.pi * (kx * x / shape[0] + ky * y / shape[1])
    return np.sqrt(2) * np.cos(phase + 0.4), q


@pytest.mark.parametrize("shape", [(16, 24), (15, 21), (16, 21)])
@pytest.mark.parametrize("k", [(3, 0), (0, 2), (-2, 5)])
def test_statistics_of_a_periodic_wave_are_exact(shape, k):
    heights, q = wave(shape, 0.5, *k)
    got = statistics(heights + 3.0, 0.5)
    assert got.rms_height == pytest.approx(1, rel=1e-12)
    assert got.rms_slope == pytest.approx(q, rel=1e-12)
    assert got.rms_curvature == pytest.approx(q**2, rel=1e-12)


def test_statistics_of_a_paraboloid_that_is_not_periodic_are_exact_between_points():
    x = 0.5 * np.arange(-8, 9)
    heights = (x[:, None] ** 2 + x[None, :] ** 2) / 20
    got = statistics(heights, 0.5, periodic=False)
    between = x[:-1] + 0.25
    slope = np.sqrt(np.mean(between[:, None] ** 2 + between[None, :] ** 2)) / 10
    assert got.rms_height == pytest.approx(heights.std(), rel=1e-12)
    assert got.rms_slope == pytest.approx(slope, rel=1e-12)
    assert got.rms_curvature == pytest.approx(0.2, rel=1e-12)


def test_finite_differences_reduce_short_waves_as_stated():
    heights, q = wave((512, 4), 1.0, 64, 0)
    got = statistics(heights, 1.0, periodic=False)
    reduced = np.sin(q / 2) / (q / 2)
    assert got.rms_slope == pytest.approx(q * reduced, rel=1e-2)
    assert got.rms_curvature == pytest.approx((q * reduced) ** 2, rel=1e-2)
    with pytest.raises(ValueError, match=r"at least 3 x 3 points, got shape \(2, 8\)"):
        statistics(np.zeros((2, 8)), 1.0, periodic=False)


@pytest.mark.parametrize("periodic", [False, True])
def test_statistics_of_a_map_agree_with_its_spline(periodic):
    waves, _q = wave((24, 24), 1.0, 2, 1)
    surface = HeightMap(waves, 1.0, periodic, center=(0.0, 0.0))
    points = 24 * 16 if periodic else 23 * 16 + 1
    fine = surface.heights((points, points), 1 / 16)
    expected = statistics(fine, 1 / 16, periodic)
    got = surface.statistics()
    assert got.rms_slope == pytest.approx(expected.rms_slope, rel=2e-3)
    assert got.rms_curvature == pytest.approx(expected.rms_curvature, rel=5e-3)


@pytest.mark.parametrize("shape", [(16, 16), (15, 15), (15, 12)])
def test_the_spectrum_sums_to_the_mean_square_height(shape):
    heights = np.random.default_rng(1).standard_normal(shape)
    spacing = 0.5
    q, density = power_spectrum(heights, spacing)
    # density of the ring of each wave vector
    qx = 2 * np.pi * np.fft.fftfreq(shape[0], spacing)[:, None]
    qy = 2 * np.pi * np.fft.fftfreq(shape[1], spacing)[None, :]
    every = np.hypot(qx, qy).ravel()[1:]
    ring = np.rint(every * min(shape) * spacing / (2 * np.pi)).astype(int) - 1
    cell = (2 * np.pi) ** 2 / (heights.size * spacing**2)
    total = density[ring].sum() * cell / (2 * np.pi) ** 2
    assert total == pytest.approx(heights.var(), rel=1e-12)
    assert len(q) == len(density)


def test_the_spectrum_of_a_wave_has_its_peak_at_the_wave_number():
    heights, wavenumber = wave((32, 32), 0.5, 0, 5)
    q, density = power_spectrum(heights, 0.5)
    peak = np.argmax(density)
    assert q[peak] == pytest.approx(wavenumber, rel=0.05)
    assert np.delete(density, peak).max() < 1e-25


@pytest.mark.parametrize(
    ("heights", "message"),
    [
        (np.zeros(4), r"two-dimensional .* shape \(4,\)"),
        (np.zeros((0, 4)), "two-dimensional"),
        (np.zeros((2, 2), complex), "real numbers, .* complex128"),
        ([["a", "b"]], "real numbers"),
        ([[0.0, math.nan], [math.inf, 0.0]], "finite, got 2 values"),
    ],
)
@pytest.mark.parametrize("function", [HeightMap, statistics, power_spectrum])
def test_heights_that_are_not_a_finite_map_are_refused(function, heights, message):
    with pytest.raises(ValueError, match=message):
        function(heights, 1.0)


@pytest.mark.parametrize("function", [HeightMap, statistics, power_spectrum])
@pytest.mark.parametrize("spacing", [0.0, math.nan, None])
def test_a_wrong_spacing_is_refused(function, spacing):
    with pytest.raises(ValueError, match="spacing must be a finite number > 0"):
        function(BUMPS, spacing)


def test_without_its_smooth_component_a_surface_repeats_without_steps():
    x, y = np.arange(48.0)[:, None], np.arange(32.0)
    waves = np.cos(2.0 * np.pi * x / 24) * np.sin(2.0 * np.pi * y / 16)
    tilted = waves + 0.2 * x - 0.1 * y + 2e-3 * x * y
    smooth = smooth_component(tilted)
    # harmonic between the edges
    around = smooth[2:, 1:-1] + smooth[:-2, 1:-1] + smooth[1:-1, 2:] + smooth[1:-1, :-2]
    np.testing.assert_allclose(around, 4.0 * smooth[1:-1, 1:-1], atol=1e-12)
    left = tilted - smooth
    for heights in (left, left.T):
        steps = abs(heights[-1] - heights[0]).max()
        assert steps <= abs(np.diff(heights, axis=0)).max()
    assert abs(tilted[-1] - tilted[0]).min() > 9.0
