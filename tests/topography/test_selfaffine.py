"""Self-affine surfaces: spectrum, statistics, sampling on grids, errors."""

import io
import math
import os
import sys
from contextlib import redirect_stdout
from dataclasses import replace
from subprocess import check_output

import numpy as np
import pytest

from ase_roughcontact.topography import SelfAffine
from ase_roughcontact.topography.spectrum import statistics

# Waves of 4 to 32 on a domain of 128.
SURFACE = SelfAffine(0.1, 0.8, 4.0, 32.0, seed=7)


def coefficients(heights):
    """Fourier coefficients and integer wave numbers, independently of the package."""
    n, m = heights.shape
    kx = np.fft.fftfreq(n, 1 / n)[:, None]
    ky = np.fft.fftfreq(m, 1 / m)[None, :]
    return np.fft.fft2(heights) / heights.size, np.hypot(kx, ky)


# Spectrum


@pytest.mark.parametrize("random_amplitudes", [False, True])
def test_a_realisation_has_exactly_the_prescribed_slope(random_amplitudes):
    surface = replace(SURFACE, random_amplitudes=random_amplitudes)
    heights = surface.heights((128, 128), 1.0)
    coefficient, k = coefficients(heights)
    square_slope = np.sum((2 * np.pi / 128 * k * np.abs(coefficient)) ** 2)
    assert np.sqrt(square_slope) == pytest.approx(0.1, rel=1e-12)
    expected = vars(statistics(heights, 1.0))
    assert vars(surface.statistics()) == pytest.approx(expected, rel=1e-12)


def test_ensemble_normalisation_gives_the_slope_on_average_over_seeds():
    random = replace(SURFACE, random_amplitudes=True, normalise="ensemble")
    surfaces = (replace(random, seed=seed) for seed in range(200))
    squares = [each.statistics().rms_slope ** 2 for each in surfaces]
    error_of_mean = np.std(squares) / np.sqrt(len(squares))
    assert np.std(squares) > 0
    assert abs(np.mean(squares) - 0.01) < 4 * error_of_mean


@pytest.mark.parametrize("hurst", [0.01, 0.8, 0.99])
def test_the_spectrum_falls_with_power_minus_two_minus_two_h(hurst):
    heights = replace(SURFACE, hurst=hurst).heights((128, 128), 1.0)
    coefficient, k = coefficients(heights)
    band = (k >= 4) & (k <= 32)
    power = np.abs(coefficient[band]) ** 2
    slope, _ = np.polyfit(np.log(k[band]), np.log(power), 1)
    assert slope == pytest.approx(-2 - 2 * hurst, abs=1e-6)
    assert np.abs(coefficient[~band]).max() < 1e-15


# Lengths with ratios that, rounded, lose the shortest or the longest wave.
@pytest.mark.parametrize(
    ("a0", "short", "long", "periods"), [(0.1, 3, 30, 1), (1 / 3, 5, 20, 3)]
)
def test_waves_at_the_ends_of_the_band_belong_to_it(a0, short, long, periods):
    n = periods * long
    surface = SelfAffine(0.1, 0.8, short * a0, long * a0, domain=periods * (long * a0))
    coefficient, _ = coefficients(surface.heights((n, n), a0))
    ends = [periods, n // short]
    assert np.abs(coefficient[ends, 0]).min() > 1e-6
    assert np.abs(coefficient[0, ends]).min() > 1e-6


def test_the_spectrum_is_constant_in_the_roll_off():
    surface = SelfAffine(0.1, 0.8, 4.0, 16.0, longest_wavelength=64.0, domain=128.0)
    coefficient, k = coefficients(surface.heights((128, 128), 1.0))
    power = np.abs(coefficient) ** 2
    plateau = power[(k >= 2) & (k <= 8)]
    assert plateau.max() == pytest.approx(plateau.min(), rel=1e-9)
    assert power[k < 2].max() < 1e-30
    assert power[16, 0] / power[8, 0] == pytest.approx(2.0**-3.6, rel=1e-9)


def test_random_amplitudes_are_rayleigh_distributed():
    fixed, _ = coefficients(SURFACE.heights((128, 128), 1.0))
    surface = replace(SURFACE, random_amplitudes=True, normalise="ensemble")
    random, _ = coefficients(surface.heights((128, 128), 1.0))
    present = np.abs(fixed) > 1e-9
    squares = np.abs(random[present] / fixed[present]) ** 2
    # Squares of a Rayleigh variable are exponential: mean 1, variance 1.
    assert squares.mean() == pytest.approx(1, abs=0.1)
    assert squares.var() == pytest.approx(1, abs=0.25)


def test_amplitudes_of_waves_are_independent_of_their_phases():
    surface = replace(SURFACE, random_amplitudes=True)
    coefficient, k = coefficients(surface.heights((128, 128), 1.0))
    half = (k >= 4) & (k <= 32)
    half[:, 65:] = half[65:, 0] = False  # mirror images
    power = np.abs(coefficient[half]) ** 2 * k[half] ** (2 + 2 * surface.hurst)
    phase = np.angle(coefficient[half])
    # of independent exponential powers the mean square is 2/n
    for harmonic in (1, 2, 3):
        mean = (power * np.exp(1j * harmonic * phase)).mean() / power.mean()
        assert np.abs(mean) < 4 * math.sqrt(2 / power.size)


def test_a_finite_band_has_the_moments_of_its_continuous_spectrum():
    hurst, low, high = 0.8, 2 * np.pi / 512, 2 * np.pi / 4
    got = SelfAffine(0.1, hurst, 4.0, 512.0).statistics()

    def moment(m):
        power = m - 2 * hurst
        return (high**power - low**power) / power

    height, curvature = (0.1 * math.sqrt(moment(m) / moment(2)) for m in (0, 4))
    # The sum over the few longest waves differs from the integral.
    assert got.rms_curvature == pytest.approx(curvature, rel=5e-3)
    assert got.rms_height == pytest.approx(height, rel=0.05)


# Sampling on grids


@pytest.mark.parametrize(
    ("points", "factor"),
    [(128, 2), pytest.param(64, 2, id="coarsest"), pytest.param(129, 3, id="odd")],
)
def test_a_finer_grid_keeps_the_heights_at_common_points(points, factor):
    n = points * factor
    coarse = SURFACE.heights((points, points), 128 / points)
    fine = SURFACE.heights((n, n), 128 / n)
    np.testing.assert_allclose(fine[::factor, ::factor], coarse, rtol=0, atol=1e-12)


@pytest.mark.parametrize("spacing", [1.0, 2.0])
@pytest.mark.parametrize("origin", [(0.5, -7.25), (-63.5, -63.5), (1 / 3, 0.0)])
def test_an_origin_off_the_grid_samples_the_same_surface(origin, spacing):
    window = SURFACE.heights((6, 5), spacing, origin)
    # Sum the waves of the domain one by one.
    coefficient, _ = coefficients(SURFACE.heights((128, 128), 1.0))
    k = 2 * np.pi / 128 * np.fft.fftfreq(128, 1 / 128)
    x = np.exp(1j * np.outer(origin[0] + spacing * np.arange(6), k))
    y = np.exp(1j * np.outer(k, origin[1] + spacing * np.arange(5)))
    expected = (x @ coefficient @ y).real
    np.testing.assert_allclose(window, expected, rtol=0, atol=1e-12)


def test_windows_wrap_around_the_domain():
    whole = SURFACE.heights((128, 128), 1.0)
    window = SURFACE.heights((10, 10), 1.0, origin=(-5.0, 123.0 + 128.0))
    np.testing.assert_array_equal(window, np.roll(whole, (5, 5), (0, 1))[:10, :10])


@pytest.mark.parametrize("index", [-41, 87 + 128 * 100, -41 - 128 * 1000])
def test_rounding_in_the_origin_does_not_matter(index):
    a0 = 3.6 / math.sqrt(2)
    surface = SelfAffine(0.1, 0.8, 4 * a0, 32 * a0)
    origin = index * a0 + 0.3 * a0 - 0.1 * a0 - 0.2 * a0
    np.testing.assert_array_equal(
        surface.heights((4, 4), a0, (origin, 0.3 * a0 - 0.1 * a0 - 0.2 * a0)),
        surface.heights((4, 4), a0, (87 * a0, 0.0)),
    )


def test_short_waves_are_added_to_the_same_long_waves():
    _, k = coefficients(np.zeros((128, 128)))
    band = (k >= 4) & (k <= 16)
    smooth, rough = (
        coefficients(replace(SURFACE, short_wavelength=short).heights((128, 128), 1.0))
        for short in (8.0, 4.0)
    )
    ratio = smooth[0][band] / rough[0][band]
    np.testing.assert_allclose(ratio, ratio[0].real, rtol=1e-9)


def test_a_seed_always_gives_the_same_surface():
    other = replace(SURFACE, seed=8).heights((1, 2), 1.0, (3.0, 4.0))[0]
    assert other[0] != pytest.approx(0.25195443050543476, rel=0.1)
    # recorded values: published seeds must keep their surfaces
    assert SURFACE.heights((1, 2), 1.0, (3.0, 4.0))[0] == pytest.approx(
        [0.25195443050543476, 0.31579336558552507], rel=1e-9
    )


def test_todict_contains_the_domain_and_rebuilds_the_surface():
    description = SURFACE.todict()
    assert description.pop("name") == "SelfAffine"
    assert description["domain"] == 128.0
    np.testing.assert_array_equal(
        SelfAffine(**description).heights((4, 4), 1.0), SURFACE.heights((4, 4), 1.0)
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"rms_slope": 0.0}, "rms_slope must be a finite number > 0"),
        ({"hurst": 1.0}, "between 0 and 1, got 1.0"),
        ({"short_wavelength": -4.0}, "short_wavelength must be a finite number > 0"),
        ({"short_wavelength": 33.0}, "long_wavelength must be at least"),
        ({"longest_wavelength": 31.0}, "longest_wavelength must be at least"),
        ({"domain": 31.0}, "domain must be at least long_wavelength = 32"),
        ({"longest_wavelength": 64.0, "domain": 63.0}, "least longest_wavelength"),
        ({"seed": -1}, "seed must be an integer >= 0, got -1"),
        ({"seed": 1.5}, "seed must be an integer"),
        ({"normalise": "both"}, "'realisation' or 'ensemble', got 'both'"),
        ({"random_amplitudes": "no"}, "random_amplitudes must be"),
    ],
)
def test_wrong_parameters_of_a_self_affine_surface_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        replace(SURFACE, **change)


@pytest.mark.parametrize(
    ("change", "shape", "spacing", "message"),
    [
        ({}, (4, 129), 1.0, "choose a domain of at least 129 spacings"),
        ({}, (4, 4), 1.1, r"choose domain=128\.7"),
        ({}, (4, 4), 2.1, r"half of .*= 4, got 2\.1"),
        (
            {"short_wavelength": 7.9, "long_wavelength": 7.9, "domain": 32.0},
            (4, 4),
            1.0,
            "choose a larger domain",
        ),
    ],
)
def test_grids_that_do_not_fit_are_refused(change, shape, spacing, message):
    with pytest.raises(ValueError, match=message):
        replace(SURFACE, **change).heights(shape, spacing)
    assert replace(SURFACE, domain=128.7).heights((4, 4), 1.1).shape == (4, 4)


def test_lowest_height_agrees_with_a_grid_over_the_domain():
    surface = SelfAffine(0.3, 0.8, 4.0, 16.0, domain=64.0)
    for origin in ((0.0, 0.0), (3.0, -2.0), (0.25, 0.5)):
        heights = surface.heights((64, 64), 1.0, origin)
        assert surface.lowest(1.0, origin) == heights.min()
    assert surface.extent == 32.0


def test_a_surface_without_any_of_its_waves_is_refused():
    with pytest.raises(ValueError, match=r"shorter than 300: choose at most 64$"):
        SelfAffine(0.1, 0.8, 4.0, 64.0).band_limited(300.0)


def test_roughness_does_not_depend_on_the_threads_of_blas():
    code = (
        "from ase_roughcontact import SelfAffine; from hashlib import sha256;"
        "rough = SelfAffine(0.1, 0.8, 4.0, 256.0, seed=1);"
        "print(rough.band_limited(8.0).rms_slope.hex(), rough.statistics());"
        "print(sha256(rough.heights((64, 64), 2.0)).hexdigest())"
    )
    with redirect_stdout(io.StringIO()) as with_one:  # as all tests
        exec(code)
    two = os.environ | {"OPENBLAS_NUM_THREADS": "2"}
    found = check_output((sys.executable, "-c", code), env=two, text=True)
    assert found == with_one.getvalue()
