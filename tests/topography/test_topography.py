"""Surfaces and their statistics: what they promise, and what they refuse."""

import copy
import math
import pickle
from dataclasses import replace

import numpy as np
import pytest

from ase_roughcontact.topography import HeightMap, RoughSphere, SelfAffine
from ase_roughcontact.topography.spectrum import power_spectrum, statistics

# A small surface: waves of 4 to 32 on a domain of 128.
SURFACE = SelfAffine(0.1, 0.8, 4.0, 32.0, seed=7)
BUMPS = np.random.default_rng(0).standard_normal((9, 12))


def coefficients(heights):
    """Fourier coefficients and integer wave numbers, independently of the package."""
    n, m = heights.shape
    kx = np.fft.fftfreq(n, 1 / n)[:, None]
    ky = np.fft.fftfreq(m, 1 / m)[None, :]
    return np.fft.fft2(heights) / heights.size, np.hypot(kx, ky)


# Self-affine surfaces: the spectrum


@pytest.mark.parametrize("random_amplitudes", [False, True])
def test_a_realisation_has_exactly_the_slope_asked_for(random_amplitudes):
    surface = replace(SURFACE, random_amplitudes=random_amplitudes)
    heights = surface.heights((128, 128), 1.0)
    coefficient, k = coefficients(heights)
    square_slope = np.sum((2 * np.pi / 128 * k * np.abs(coefficient)) ** 2)
    assert np.sqrt(square_slope) == pytest.approx(0.1, rel=1e-12)


def test_ensemble_normalisation_gives_the_slope_on_average_over_seeds():
    squares = [
        SelfAffine(
            0.1, 0.8, 4.0, 32.0, seed=seed, random_amplitudes=True, normalise="ensemble"
        )
        .statistics()
        .rms_slope
        ** 2
        for seed in range(200)
    ]
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


def test_the_spectrum_is_zero_outside_the_band():
    coefficient, k = coefficients(SURFACE.heights((128, 128), 1.0))
    outside = (k < 4) | (k > 32)
    assert np.abs(coefficient[outside]).max() < 1e-15


# Lengths whose ratios, rounded, lose the shortest or the longest wave.
@pytest.mark.parametrize(
    ("a0", "short", "long", "periods"), [(0.1, 3, 30, 1), (1 / 3, 5, 20, 3)]
)
def test_waves_at_the_very_ends_of_the_band_belong_to_it(a0, short, long, periods):
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
    chance, _ = coefficients(surface.heights((128, 128), 1.0))
    present = np.abs(fixed) > 1e-9
    squares = np.abs(chance[present] / fixed[present]) ** 2
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


def test_phases_are_uniform():
    coefficient, k = coefficients(SURFACE.heights((128, 128), 1.0))
    upper = (k >= 4) & (k <= 32)
    upper[:, 65:] = upper[65:, 0] = False
    directions = np.exp(1j * np.angle(coefficient[upper]))
    assert np.abs(directions.mean()) < 4 / math.sqrt(directions.size)


def test_a_finite_band_has_the_moments_of_its_continuous_spectrum():
    hurst, low, high = 0.8, 2 * np.pi / 512, 2 * np.pi / 4
    got = SelfAffine(0.1, hurst, 4.0, 512.0).statistics()

    def moment(m):
        power = m - 2 * hurst
        return (high**power - low**power) / power

    height, curvature = (0.1 * math.sqrt(moment(m) / moment(2)) for m in (0, 4))
    # The lowest rings hold few waves: they matter little for the slope, which sets
    # the scale, and most for the height.
    assert got.rms_curvature == pytest.approx(curvature, rel=5e-3)
    assert got.rms_height == pytest.approx(height, rel=0.05)


def test_statistics_of_a_realisation_are_those_of_its_heights():
    surface = replace(SURFACE, random_amplitudes=True)
    expected = statistics(surface.heights((128, 128), 1.0), 1.0)
    got = surface.statistics()
    assert got.rms_height == pytest.approx(expected.rms_height, rel=1e-12)
    assert got.rms_slope == pytest.approx(expected.rms_slope, rel=1e-12)
    assert got.rms_curvature == pytest.approx(expected.rms_curvature, rel=1e-12)


# Self-affine surfaces: one realisation, however it is looked at


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
def test_an_origin_off_the_grid_sees_the_same_surface(origin, spacing):
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


def test_rounding_in_the_origin_does_not_matter():
    a0 = 3.6 / math.sqrt(2)
    surface = SelfAffine(0.1, 0.8, 4 * a0, 32 * a0)
    np.testing.assert_array_equal(
        surface.heights((4, 4), a0, (-41 * a0, 0.3 * a0 - 0.1 * a0 - 0.2 * a0)),
        surface.heights((4, 4), a0, (87 * a0, 0.0)),
    )


def test_the_unit_of_length_does_not_matter():
    other = SelfAffine(0.1, 0.8, 4e-10, 32e-10, seed=7)
    np.testing.assert_allclose(
        1e10 * other.heights((128, 128), 1e-10),
        SURFACE.heights((128, 128), 1.0),
        rtol=0,
        atol=1e-12,
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


def test_seeds_make_different_surfaces():
    first = SURFACE.heights((128, 128), 1.0)
    second = replace(SURFACE, seed=8).heights((128, 128), 1.0)
    correlation = np.mean(first * second) / (first.std() * second.std())
    assert abs(correlation) < 0.2


def test_a_seed_makes_the_same_surface_for_ever():
    # Recorded: a change here would make published seeds mean other surfaces.
    assert SURFACE.heights((1, 2), 1.0, (3.0, 4.0))[0] == pytest.approx(
        [0.25195443050543476, 0.31579336558552507], rel=1e-9
    )


def test_todict_states_the_domain_and_rebuilds_the_surface():
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
        ({"rms_slope": math.nan}, "rms_slope must be a finite number > 0"),
        ({"rms_slope": "0.1"}, "rms_slope must be a finite number > 0"),
        ({"hurst": 1.0}, "between 0 and 1, got 1.0"),
        ({"short_wavelength": -4.0}, "short_wavelength must be a finite number > 0"),
        ({"short_wavelength": 33.0}, "long_wavelength must be at least"),
        ({"longest_wavelength": 31.0}, "longest_wavelength must be at least"),
        ({"domain": 31.0}, "domain must be at least long_wavelength = 32"),
        ({"longest_wavelength": 64.0, "domain": 63.0}, "least longest_wavelength"),
        ({"seed": -1}, "seed must be an integer >= 0, got -1"),
        ({"seed": 1.5}, "seed must be an integer"),
        ({"normalise": "both"}, "'realisation' or 'ensemble', got 'both'"),
        ({"random_amplitudes": "no"}, "random_amplitudes must be a bool"),
    ],
)
def test_wrong_parameters_of_a_self_affine_surface_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        replace(SURFACE, **change)


def test_a_window_larger_than_the_domain_is_refused():
    with pytest.raises(ValueError, match="choose a domain of at least 129"):
        SURFACE.heights((4, 129), 1.0)


def test_a_spacing_that_does_not_divide_the_domain_is_refused_with_a_remedy():
    with pytest.raises(ValueError, match=r"choose domain=128\.7"):
        SURFACE.heights((4, 4), 1.1)
    assert replace(SURFACE, domain=128.7).heights((4, 4), 1.1).shape == (4, 4)


def test_a_grid_too_coarse_for_the_short_waves_is_refused():
    with pytest.raises(ValueError, match=r"half of short_wavelength = 4, got 2\.1"):
        SURFACE.heights((4, 4), 2.1)


def test_a_band_without_waves_is_refused():
    surface = SelfAffine(0.1, 0.8, 7.9, 7.9, domain=32.0)
    with pytest.raises(ValueError, match="choose a larger domain"):
        surface.heights((4, 4), 1.0)


# Any surface


SURFACES = [SURFACE, RoughSphere(10.0, SURFACE), HeightMap(BUMPS, 1.0)]


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize(
    "copied", [copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))]
)
def test_copies_are_the_same_surface(surface, copied):
    twin = copied(surface)
    assert twin == surface
    assert hash(twin) == hash(surface)


@pytest.mark.parametrize("surface", SURFACES)
def test_heights_handed_out_can_be_changed_without_harm(surface):
    first = surface.heights((4, 4), 1.0)
    expected = first.copy()
    first += 1.0
    np.testing.assert_array_equal(surface.heights((4, 4), 1.0), expected)


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize(
    ("window", "message"),
    [
        ({"shape": (0, 4)}, "shape must be two whole numbers >= 1"),
        ({"shape": (4.5, 4)}, "shape must be two whole numbers"),
        ({"shape": 4}, "shape must be two whole numbers"),
        ({"spacing": 0.0}, "spacing must be a finite number > 0"),
        ({"spacing": math.nan}, "spacing must be a finite number > 0"),
        ({"origin": (0.0, math.inf)}, "origin_y must be a finite number, got inf"),
        ({"origin": 0.0}, "origin must be two numbers"),
        ({"origin": ("a", 0.0)}, "origin_x must be a finite number"),
    ],
)
def test_windows_that_make_no_sense_are_refused(surface, window, message):
    window = {"shape": (4, 4), "spacing": 1.0} | window
    with pytest.raises(ValueError, match=message):
        surface.heights(**window)


# Spheres


def test_a_paraboloid_rises_with_the_square_of_the_distance():
    heights = RoughSphere(100.0).heights((3, 2), 0.5, origin=(-0.5, 1.0))
    expected = [[1.25, 2.5], [1.0, 2.25], [1.25, 2.5]]
    np.testing.assert_allclose(heights, np.array(expected) / 200, rtol=1e-15)


def test_a_sphere_has_its_radius_everywhere():
    heights = RoughSphere(5.0, profile="sphere").heights((7, 7), 1.0, (-3.0, -3.0))
    x = np.arange(-3.0, 4.0)
    distance = np.sqrt(x[:, None] ** 2 + x[None, :] ** 2 + (heights - 5.0) ** 2)
    np.testing.assert_allclose(distance, 5.0, rtol=1e-15)


def test_a_large_sphere_is_its_paraboloid_without_cancellation():
    sphere, paraboloid = (
        RoughSphere(1e9, profile=profile).heights((4, 4), 1.0)
        for profile in ("sphere", "paraboloid")
    )
    np.testing.assert_allclose(sphere, paraboloid, rtol=1e-15)


@pytest.mark.parametrize("profile", ["paraboloid", "sphere"])
def test_an_infinite_radius_is_flat(profile):
    heights = RoughSphere(math.inf, SURFACE, profile).heights((4, 4), 1.0)
    np.testing.assert_array_equal(heights, SURFACE.heights((4, 4), 1.0))


def test_roughness_is_added_to_the_sphere():
    window = (4, 6), 1.0, (-2.0, 0.5)
    np.testing.assert_array_equal(
        RoughSphere(50.0, SURFACE).heights(*window),
        RoughSphere(50.0).heights(*window) + SURFACE.heights(*window),
    )


def test_a_sphere_describes_its_roughness():
    sphere = RoughSphere(50.0, SURFACE)
    assert sphere.todict()["roughness"] == SURFACE.todict()
    assert RoughSphere(50.0).todict()["roughness"] is None


def test_a_window_beyond_the_sphere_is_refused():
    with pytest.raises(ValueError, match=r"r = 7\.07107 .* sphere of radius 5"):
        RoughSphere(5.0, profile="sphere").heights((6, 6), 1.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((0.0,), "radius must be a finite number > 0"),
        ((-math.inf,), "radius must be a finite number > 0"),
        ((math.nan,), "radius must be a finite number > 0"),
        ((1.0, BUMPS), "roughness must be a surface with a method heights"),
        ((1.0, SelfAffine), "roughness must be a surface with a method heights"),
        ((1.0, None, "cone"), "'paraboloid' or 'sphere', got 'cone'"),
    ],
)
def test_wrong_parameters_of_a_sphere_are_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        RoughSphere(*arguments)


# Height maps


def test_a_map_returns_its_heights_exactly_at_its_own_points():
    window = HeightMap(BUMPS, 0.3).heights((9, 12), 0.3, (-4 * 0.3, -6 * 0.3))
    np.testing.assert_array_equal(window, BUMPS)


def test_a_periodic_map_wraps():
    window = HeightMap(BUMPS, 1.0, periodic=True).heights((9, 12), 1.0)
    np.testing.assert_array_equal(window, np.roll(BUMPS, (-4, -6), (0, 1)))


def test_interpolation_reproduces_cubic_polynomials():
    x, y = np.arange(-4.0, 5.0)[:, None], np.arange(-4.0, 5.0)[None, :]
    window = HeightMap(x**3 * y**2 - 2 * y**3, 1.0).heights((3, 3), 0.7, (-1.2, 0.4))
    x, y = -1.2 + 0.7 * np.arange(3)[:, None], 0.4 + 0.7 * np.arange(3)[None, :]
    np.testing.assert_allclose(window, x**3 * y**2 - 2 * y**3, rtol=0, atol=1e-11)


def test_a_periodic_map_is_smooth_across_its_edge():
    x = 2 * np.pi / 64 * np.arange(64)
    values = np.sin(x[:, None]) * np.cos(2 * x)
    x, y = 31.6 + 0.66 * np.arange(10), -34.4 + 0.66 * np.arange(10)
    window = HeightMap(values, 1.0, periodic=True).heights((10, 10), 0.66, (x[0], y[0]))
    x, y = 2 * np.pi / 64 * (x + 32), 2 * np.pi / 64 * (y + 32)
    exact = np.sin(x[:, None]) * np.cos(2 * y)
    np.testing.assert_allclose(window, exact, rtol=0, atol=1e-4)


def test_a_map_does_not_change_with_the_array_it_came_from():
    values = BUMPS.copy()
    surface = HeightMap(values, 1.0)
    values += 1.0
    assert surface.heights((1, 1), 1.0)[0, 0] == BUMPS[4, 6]


def test_a_map_survives_a_npy_file(tmp_path):
    np.save(tmp_path / "map.npy", BUMPS)
    surface = HeightMap.read(tmp_path / "map.npy", 0.3)
    assert surface == HeightMap(BUMPS, 0.3)


@pytest.mark.parametrize("delimiter", [" ", ",", ", ", "\t"])
def test_a_map_survives_a_text_file(tmp_path, delimiter):
    file = tmp_path / "map.txt"
    np.savetxt(file, BUMPS, fmt="%.17g", delimiter=delimiter, header="one, two")
    surface = HeightMap.read(str(file), 0.3, periodic=True)
    assert surface == HeightMap(BUMPS, 0.3, periodic=True)


def test_a_map_describes_itself_without_its_heights():
    description = HeightMap(BUMPS, 0.3).todict()
    assert description["shape"] == (9, 12)
    assert description["spacing"] == 0.3
    assert description["periodic"] is False
    assert len(description["sha256"]) == 16
    assert description["sha256"] != HeightMap(BUMPS + 1, 0.3).todict()["sha256"]


def test_maps_of_other_spacing_are_not_equal():
    assert HeightMap(BUMPS, 0.3) != HeightMap(BUMPS, 0.4)


def test_a_window_beyond_the_map_is_refused_with_the_numbers():
    with pytest.raises(ValueError, match="x = 0 to 5, but the map only -4 to 4"):
        HeightMap(BUMPS, 1.0).heights((6, 2), 1.0)


def test_a_window_larger_than_a_periodic_map_is_refused():
    with pytest.raises(ValueError, match="10 along x exceeds the period 9 of the map"):
        HeightMap(BUMPS, 1.0, periodic=True).heights((10, 2), 1.0)


def test_a_map_too_small_to_interpolate_is_refused():
    surface = HeightMap(np.zeros((3, 8)), 1.0)
    for look in (lambda: surface.heights((2, 2), 0.3), lambda: surface.lowest(0.3)):
        with pytest.raises(
            ValueError, match="at least 4 x 4 points, got 3 along a side"
        ):
            look()


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
def test_heights_that_are_no_map_are_refused(function, heights, message):
    with pytest.raises(ValueError, match=message):
        function(heights, 1.0)


@pytest.mark.parametrize("function", [HeightMap, statistics, power_spectrum])
@pytest.mark.parametrize("spacing", [0.0, math.nan, None])
def test_a_wrong_spacing_is_refused(function, spacing):
    with pytest.raises(ValueError, match="spacing must be a finite number > 0"):
        function(BUMPS, spacing)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("empty.txt", b""),
        ("words.txt", b"high low\n"),
        ("ragged.txt", b"1 2\n3\n"),
        ("decimal_comma.txt", b"1,5 2,5\n"),
        ("nan.txt", b"1 nan\n"),
        ("binary.dat", b"\x93\xff\xfe\x00"),
        ("not.npy", b"1 2\n3 4\n"),
        ("empty.npy", b""),
        ("absent.npy", None),
    ],
)
def test_an_unreadable_file_is_refused_by_name(tmp_path, name, content):
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(ValueError, match=f"cannot read a height map .*{name}") as error:
        HeightMap.read(tmp_path / name, 1.0)
    assert error.value.__cause__ is not None


# Statistics and spectra of heights


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


def test_statistics_of_a_paraboloid_that_is_not_periodic_are_exact():
    x = 0.5 * np.arange(-8, 9)
    heights = (x[:, None] ** 2 + x[None, :] ** 2) / 20
    got = statistics(heights, 0.5, periodic=False)
    inner = x[1:-1]
    slope = np.sqrt(np.mean(inner[:, None] ** 2 + inner[None, :] ** 2)) / 10
    assert got.rms_height == pytest.approx(heights.std(), rel=1e-12)
    assert got.rms_slope == pytest.approx(slope, rel=1e-12)
    assert got.rms_curvature == pytest.approx(0.2, rel=1e-12)


def test_finite_differences_reduce_short_waves_as_stated():
    heights, q = wave((512, 4), 1.0, 64, 0)
    got = statistics(heights, 1.0, periodic=False)
    reduced = np.sin(q / 2) / (q / 2)
    assert got.rms_slope == pytest.approx(np.sin(q), rel=1e-2)
    assert got.rms_curvature == pytest.approx((q * reduced) ** 2, rel=1e-2)


def test_statistics_without_period_need_an_interior():
    with pytest.raises(ValueError, match=r"at least 3 x 3 points, got shape \(2, 8\)"):
        statistics(np.zeros((2, 8)), 1.0, periodic=False)


@pytest.mark.parametrize("bins", [0, 2.5])
def test_a_wrong_number_of_bins_is_refused(bins):
    with pytest.raises(ValueError, match="bins must be an integer >= 1"):
        power_spectrum(BUMPS, 1.0, bins)


@pytest.mark.parametrize("shape", [(16, 16), (15, 15), (15, 12)])
@pytest.mark.parametrize("bins", [None, 5])
def test_the_spectrum_sums_to_the_mean_square_height(shape, bins):
    heights = np.random.default_rng(1).standard_normal(shape)
    spacing = 0.5
    q, density = power_spectrum(heights, spacing, bins)
    # Give every wave vector the density of the ring it lies in.
    qx = 2 * np.pi * np.fft.fftfreq(shape[0], spacing)[:, None]
    qy = 2 * np.pi * np.fft.fftfreq(shape[1], spacing)[None, :]
    every = np.hypot(qx, qy).ravel()[1:]
    if bins is None:
        ring = np.rint(every * min(shape) * spacing / (2 * np.pi)).astype(int) - 1
    else:
        ring = np.minimum((every / every.max() * bins).astype(int), bins - 1)
    cell = (2 * np.pi) ** 2 / (heights.size * spacing**2)
    total = density[ring].sum() * cell / (2 * np.pi) ** 2
    assert total == pytest.approx(heights.var(), rel=1e-12)
    assert len(q) == len(density)


def test_the_spectrum_of_a_wave_sits_at_its_wave_number():
    heights, wavenumber = wave((32, 32), 0.5, 0, 5)
    q, density = power_spectrum(heights, 0.5)
    peak = np.argmax(density)
    assert q[peak] == pytest.approx(wavenumber, rel=0.05)
    assert np.delete(density, peak).max() < 1e-25


# How far a surface can lie below a level


@pytest.mark.parametrize("profile", ["paraboloid", "sphere"])
@pytest.mark.parametrize("rough", [False, True], ids=["smooth", "rough"])
def test_no_atom_beyond_the_reach_is_below_the_level(profile, rough):
    roughness = SelfAffine(0.3, 0.8, 4.0, 16.0, domain=64.0) if rough else None
    sphere = RoughSphere(100.0, roughness, profile)
    heights = sphere.heights((64, 64), 1.0, (-32.0, -32.0))
    x = np.arange(-32.0, 32.0)
    distance = np.hypot(x[:, None], x)
    for level in (-0.5, 0.0, 0.1, 1.0, 3.0):
        reach = sphere.reach(level, 1.0)
        assert (heights[distance > reach] >= level).all()
    if not rough:
        edge = sphere.heights((1, 1), 1.0, (reach, 0.0))
        assert edge[0, 0] == pytest.approx(level)


def test_lowest_height_of_the_domain_is_that_on_the_lattice():
    surface = SelfAffine(0.3, 0.8, 4.0, 16.0, domain=64.0)
    for origin in ((0.0, 0.0), (3.0, -2.0), (0.25, 0.5)):
        heights = surface.heights((64, 64), 1.0, origin)
        assert surface.lowest(1.0, origin) == heights.min()
    assert surface.extent == 32.0


@pytest.mark.parametrize("repeats", [False, True], ids=["once", "periodic"])
@pytest.mark.parametrize("spacing", [1.0, 2.0, 0.5, 0.3])
def test_no_height_of_a_map_is_below_its_lowest(repeats, spacing):
    values = np.random.default_rng(4).uniform(-1.0, 1.0, (12, 10))
    surface = HeightMap(values, 1.0, periodic=repeats)
    heights = surface.heights((5, 5), spacing, (-2 * spacing, -2 * spacing))
    assert surface.lowest(spacing) <= heights.min()
    assert (surface.lowest(spacing) == values.min()) == (spacing in (1.0, 2.0))
    assert surface.extent == (5.0 if repeats else 4.0)
