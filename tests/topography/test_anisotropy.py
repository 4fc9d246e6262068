"""Anisotropic self-affine surfaces: lengths along a direction and across."""

from dataclasses import replace

import numpy as np
import pytest

from ase_roughcontact.theory.self_affine import rms_curvature, rms_height
from ase_roughcontact.topography import SelfAffine

# long waves of 24 to 96 along x, of 8 to 32 across
ROUGH = SelfAffine(
    0.1, 0.7, 8.0, 32.0, longest_wavelength=64.0, anisotropy=3.0, domain=768.0, seed=3
)


def correlation_lengths(surface):
    """Return where the autocorrelation along x and y falls to one half, by an FFT."""
    heights = surface.heights((384, 384), 2.0)
    power = abs(np.fft.fft2(heights)) ** 2
    correlation = np.fft.ifft2(power).real
    correlation /= correlation[0, 0]
    lines = correlation[:96, 0], correlation[0, :96]
    # the first crossing, by linear interpolation
    found = []
    for line in lines:
        i = int(np.argmax(line < 0.5))
        found.append(2.0 * (i - (0.5 - line[i]) / (line[i - 1] - line[i])))
    return np.array(found)


def test_correlation_lengths_have_the_ratio():
    seeds = [correlation_lengths(replace(ROUGH, seed=seed)) for seed in range(8)]
    along, across = np.mean(seeds, axis=0)
    assert along / across == pytest.approx(3.0, rel=0.03)


def test_the_direction_counts_from_x_to_y():
    along, across = correlation_lengths(replace(ROUGH, direction=90.0))
    assert across / along == pytest.approx(3.0, rel=0.1)
    turned = replace(ROUGH, direction=30.0).heights((384, 384), 2.0)
    x, y = np.gradient(turned)
    # structure tensor: the direction of the smallest mean square slope
    tensor = np.array(
        [[np.mean(x * x), np.mean(x * y)], [np.mean(x * y), np.mean(y**2)]]
    )
    angle = np.degrees(np.arctan2(*np.linalg.eigh(tensor)[1][::-1, 0])) % 180.0
    assert angle == pytest.approx(30.0, abs=3.0)


def test_heights_have_the_rms_slope_and_a_spectrum_that_is_stretched():
    heights = ROUGH.heights((384, 384), 2.0)
    coefficient = np.fft.fft2(heights, norm="forward")
    k = np.fft.fftfreq(384, 1.0 / 384)
    kx, ky = k[:, None], k[None, :]
    slope = (
        2.0 * np.pi / 768.0 * np.sqrt(((kx**2 + ky**2) * abs(coefficient) ** 2).sum())
    )
    assert slope == pytest.approx(0.1, rel=1e-12)
    number = np.hypot(3.0 * kx, ky)
    power = abs(coefficient) ** 2
    band = (number >= 24) & (number <= 96)
    fitted, _ = np.polyfit(np.log(number[band]), np.log(power[band]), 1)
    assert fitted == pytest.approx(-3.4, abs=1e-6)
    assert power[(number < 12) | (number > 96)].max() < 1e-30


def test_theory_has_the_height_and_the_curvature_of_the_stretched_spectrum():
    surface = replace(ROUGH, anisotropy=2.5, direction=20.0, domain=3200.0)
    got = surface.statistics()
    assert rms_height(surface) == pytest.approx(got.rms_height, rel=0.01)
    assert rms_curvature(surface) == pytest.approx(got.rms_curvature, rel=0.01)


def test_an_anisotropy_of_one_is_the_isotropic_surface():
    isotropic = SelfAffine(0.1, 0.7, 8.0, 32.0, seed=3)
    same = replace(isotropic, anisotropy=1.0, direction=40.0)
    heights = (each.heights((64, 64), 2.0) for each in (isotropic, same))
    assert np.array_equal(*heights)
    assert same.todict() == isotropic.todict()


def test_a_smoothed_surface_keeps_its_long_waves():
    smooth = ROUGH.band_limited(16.0)
    power = abs(np.fft.fft2(smooth.heights((384, 384), 2.0) / 384**2)) ** 2
    whole = abs(np.fft.fft2(ROUGH.heights((384, 384), 2.0) / 384**2)) ** 2
    k = np.fft.fftfreq(384, 1.0 / 384)
    kept = np.hypot(3.0 * k[:, None], k) <= 48
    assert power[kept] == pytest.approx(whole[kept], rel=1e-9, abs=1e-20)
    assert power[~kept].max() < 1e-25


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"anisotropy": 0.25}, r"90 degrees and give 4"),
        ({"anisotropy": -1.0}, "anisotropy"),
        ({"direction": np.nan}, "direction"),
        ({"domain": 100.0}, "domain must be at least"),
    ],
)
def test_wrong_parameters_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        replace(ROUGH, **change)


@pytest.mark.slow
def test_lengths_and_roll_off_of_twenty_seeds_by_surface_topography():
    """Autocorrelation along x and y, and the spectrum, by the package."""
    peer = pytest.importorskip("SurfaceTopography", reason="the extra topography")
    lengths, slopes, areas = [], [], []
    isotropic = replace(ROUGH, anisotropy=1.0, domain=512.0)
    for seed in range(20):
        heights = replace(ROUGH, seed=seed).heights((384, 384), 2.0)
        for each in (heights, heights.T):
            topography = peer.Topography(each.copy(), (768.0, 768.0), periodic=True)
            options = {"resampling_method": None, "reliable": False}
            r, structure = topography.autocorrelation_from_profile(**options)
            # half of the mean square difference, which becomes the variance
            lengths.append(r[np.argmax(structure > 0.5 * each.var())])
        rough = replace(isotropic, seed=seed)
        topography = peer.Topography(
            rough.heights((256, 256), 2.0), (512.0, 512.0), periodic=True
        )
        q, density = topography.power_spectrum_from_area(reliable=False)
        areas.append(density / rough.statistics().rms_height ** 2)
        slopes.append(topography.rms_gradient() / rough.rms_slope)
    ratio = np.mean(lengths[::2]) / np.mean(lengths[1::2])
    assert ratio == pytest.approx(3.0, rel=0.05)
    # differences of neighbours reduce the slope of waves of four to 32 steps
    assert 0.85 < np.mean(slopes) < 1.0
    flat = (q > 1.1 * 2 * np.pi / 64.0) & (q < 0.9 * 2 * np.pi / 32.0)
    steep = (q > 1.1 * 2 * np.pi / 32.0) & (q < 0.9 * 2 * np.pi / 8.0)
    mean = np.mean(areas, axis=0)
    assert mean[flat].std() / mean[flat].mean() < 0.05
    fitted, _ = np.polyfit(np.log(q[steep]), np.log(mean[steep]), 1)
    assert fitted == pytest.approx(-3.4, abs=0.05)
