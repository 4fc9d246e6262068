"""Closed forms of smooth and rough spheres against independent calculations."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from ase_roughcontact import theory

R, E, W = 30.0, 2.0, 0.05
LOADS = np.geomspace(1e-12, 1e12, 49)


# Hertz


def test_hertz_pressure_integrates_to_the_normal_force():
    a = theory.hertz_contact_radius(1.7, R, E)
    force, _ = quad(
        lambda r: 2 * np.pi * r * theory.hertz_pressure(r, a, R, E), 0, a, epsabs=0
    )
    assert_allclose(force, 1.7, rtol=1e-8)


def test_hertz_pressure_lifts_the_centre_by_the_penetration():
    # Displacement at the axis of a pressure p(r) is (2/E*) times its radial integral.
    a = theory.hertz_contact_radius(1.7, R, E)
    integral, _ = quad(theory.hertz_pressure, 0, a, args=(a, R, E))
    assert_allclose(2 * integral / E, theory.hertz_penetration(1.7, R, E), rtol=1e-8)


def test_hertz_pressure_is_zero_outside_the_contact():
    assert_allclose(theory.hertz_pressure([2.0, 2.1, 50.0], 2.0, R, E), 0.0)


def test_hertz_force_and_penetration_are_inverse():
    depth = theory.hertz_penetration(LOADS, R, E)
    assert_allclose(theory.hertz_force(depth, R, E), LOADS, rtol=1e-13)


def test_hertz_radii_from_force_and_from_penetration_agree():
    depth = theory.hertz_penetration(LOADS, R, E)
    assert_allclose(
        theory.hertz_contact_radius_from_penetration(depth, R),
        theory.hertz_contact_radius(LOADS, R, E),
        rtol=1e-13,
    )


# JKR and DMT


@pytest.mark.parametrize("a", [0.8, 2.0, 6.0])
def test_jkr_contact_radius_makes_the_total_energy_stationary(a):
    # Elastic energy of a contact of given radius and penetration, minus w times area.
    def energy(radius, depth):
        cubic = depth**2 * radius - 2 * depth * radius**3 / (3 * R)
        return E * (cubic + radius**5 / (5 * R**2)) - np.pi * W * radius**2

    depth, step = theory.jkr_penetration(a, R, E, W), 1e-4
    slope = (energy(a + step, depth) - energy(a - step, depth)) / (2 * step)
    assert abs(slope) < 1e-6 * 2 * np.pi * W * a
    force = (energy(a, depth + step) - energy(a, depth - step)) / (2 * step)
    assert_allclose(theory.jkr_force(a, R, E, W), force, rtol=1e-7)


def test_jkr_radius_from_force_inverts_force_from_radius_on_stable_branch():
    pull_off = theory.jkr_pull_off_force(R, W)
    forces = pull_off + np.geomspace(1e-6, 1e4, 30)
    radii = theory.jkr_contact_radius(forces, R, E, W)
    assert_allclose(theory.jkr_force(radii, R, E, W), forces, rtol=1e-10, atol=1e-10)
    assert np.all(np.diff(radii) > 0)


def test_jkr_least_force_is_the_pull_off_force_at_the_documented_radius():
    least = minimize_scalar(
        theory.jkr_force, bounds=(0.1, 5.0), args=(R, E, W), options={"xatol": 1e-9}
    )
    assert_allclose(least.fun, theory.jkr_pull_off_force(R, W), rtol=1e-12)
    assert_allclose(least.x**3, 9 * np.pi * W * R**2 / (8 * E), rtol=1e-6)


def test_jkr_least_penetration_lies_at_the_documented_radius():
    least = minimize_scalar(
        theory.jkr_penetration, bounds=(0.1, 5), args=(R, E, W), options={"xatol": 1e-9}
    )
    assert_allclose(least.x**3, np.pi * W * R**2 / (8 * E), rtol=1e-6)


def test_jkr_area_at_zero_load_is_johnsons():
    a0 = np.cbrt(9 * np.pi * W * R**2 / (2 * E))
    assert_allclose(theory.jkr_zero_load_area(R, E, W), np.pi * a0**2, rtol=1e-14)
    assert_allclose(theory.jkr_force(a0, R, E, W), 0.0, atol=1e-13)


@pytest.mark.parametrize("rounding", [0.0, 1e-14])
def test_jkr_and_dmt_accept_their_own_pull_off_force_with_its_rounding(rounding):
    part = 1 + rounding
    jkr = theory.jkr_contact_radius(part * theory.jkr_pull_off_force(R, W), R, E, W)
    dmt = theory.dmt_contact_radius(part * theory.dmt_pull_off_force(R, W), R, E, W)
    assert_allclose(jkr**3, 9 * np.pi * W * R**2 / (8 * E))
    assert dmt == 0.0


def test_dmt_contact_is_hertz_with_the_pull_off_force_added():
    forces = np.array([-9.0, 0.0, 5.0])
    shifted = theory.hertz_contact_radius(forces + 2 * np.pi * W * R, R, E)
    assert_allclose(theory.dmt_contact_radius(forces, R, E, W), shifted, rtol=1e-14)


@pytest.mark.parametrize(
    "contact_radius", [theory.jkr_contact_radius, theory.dmt_contact_radius]
)
def test_force_below_pull_off_is_refused(contact_radius):
    with pytest.raises(ValueError, match="not be below the pull-off force"):
        contact_radius(-2.1 * np.pi * W * R, R, E, W)


# Maugis-Dugdale


@pytest.mark.parametrize("stress", [0.02, 0.1, 0.5])
@pytest.mark.parametrize("ratio", [1.01, 1.5, 10.0])
def test_maugis_state_solves_the_contact_problem_with_a_cohesive_zone(stress, ratio):
    # Sneddon's transform: surface displacement u and force follow from
    # g(t) = int_t^inf r p(r)/sqrt(r^2 - t^2) dr, here built from a, c and sigma0.
    lam = theory.maugis_parameter(R, E, W, stress)
    unit = theory.hertz_contact_radius(np.pi * W * R, R, E)
    a, force, depth = theory.maugis_dugdale(ratio, lam)
    a, force, depth = a * unit, force * np.pi * W * R, depth * unit**2 / R
    c = ratio * a

    def cohesive(t):
        return -stress * np.sqrt(c**2 - t**2)

    def repulsive(t):
        return E / 2 * (depth - t**2 / R)

    assert_allclose(repulsive(a), cohesive(a), rtol=1e-10)  # no stress singularity
    total = quad(repulsive, 0, a)[0] + quad(cohesive, a, c)[0]
    assert_allclose(4 * total, force, rtol=1e-9)
    zone = -stress * (c - a)
    core = quad(lambda t: repulsive(t) / np.sqrt(c**2 - t**2), 0, a)[0]
    gap = c**2 / (2 * R) - depth + 4 / (np.pi * E) * (core + zone)
    assert_allclose(stress * gap, W, rtol=1e-8)


@pytest.mark.parametrize(
    ("parameter", "expected", "rtol"),
    [(1e-4, -2.0, 1e-5), (1e3, -1.5, 1e-5)],
)
def test_maugis_pull_off_goes_from_dmt_to_jkr(parameter, expected, rtol):
    pull_off = theory.maugis_dugdale_pull_off_force(parameter)
    assert_allclose(pull_off, expected, rtol=rtol)


def test_maugis_radius_from_force_lies_on_the_curve():
    stress = 0.7 / theory.maugis_parameter(R, E, W, 1.0)
    ratio = np.array([1.001, 1.1, 1.5])
    a, force, _ = theory.maugis_dugdale(ratio, 0.7)
    radius = theory.maugis_dugdale_contact_radius(
        force * np.pi * W * R, R, E, W, stress
    )
    unit = theory.hertz_contact_radius(np.pi * W * R, R, E)
    assert_allclose(radius / unit, a, rtol=1e-9)


def test_maugis_load_stability_ends_where_the_force_is_least():
    limit = theory.maugis_dugdale_stability_limit(1.0, "load")
    _, force, _ = theory.maugis_dugdale(limit * np.array([0.99, 1.0, 1.01]), 1.0)
    assert np.argmin(force) == 1
    assert_allclose(force[1], theory.maugis_dugdale_pull_off_force(1.0), rtol=1e-12)


def test_maugis_contact_parts_without_a_jump_below_the_known_parameter():
    # Johnson & Greenwood (1997): a jump under displacement control from 0.938 on.
    assert theory.maugis_dugdale_stability_limit(0.937, "displacement") == np.inf
    assert theory.maugis_dugdale_stability_limit(0.939, "displacement") < np.inf


def test_maugis_parameter_is_maugis_own_definition():
    bulk = 4 * E / 3
    own = 2 * 0.3 / np.cbrt(np.pi * W * bulk**2 / R)
    assert_allclose(theory.maugis_parameter(R, E, W, 0.3), own, rtol=1e-14)


def test_maugis_parameter_is_1_16_tabor_for_the_lennard_jones_strength():
    # Largest tension of the surface law (8w/3z0)[(z0/z)^3 - (z0/z)^9] is 1.026 w/z0.
    z0 = 0.4
    strength = 16 * W / (9 * np.sqrt(3) * z0)
    ratio = theory.maugis_parameter(R, E, W, strength) / theory.tabor_parameter(
        R, E, W, z0
    )
    assert_allclose(ratio, 1.157, atol=1e-3)


def test_maugis_refuses_a_force_below_pull_off_in_the_units_given():
    with pytest.raises(ValueError, match="got -20"):
        theory.maugis_dugdale_contact_radius(-20.0, R, E, W, 0.1)


@pytest.mark.parametrize("ratio", [1.0, 0.5, np.nan])
def test_maugis_zone_cannot_be_smaller_than_the_contact(ratio):
    with pytest.raises(ValueError, match="zone_ratio must be above 1"):
        theory.maugis_dugdale(ratio, 1.0)


def test_maugis_stability_refuses_unknown_control():
    with pytest.raises(ValueError, match="'load' or 'displacement'"):
        theory.maugis_dugdale_stability_limit(1.0, "speed")


# Rough spheres

SLOPE, HURST, SHORT, LONG = 0.1, 0.8, 4.0, 512.0


def spectral_average(function, low, high):
    """Integral of function(q) q C(q) dq over log q, C = q^(-2-2H)."""

    def integrand(x):
        q = np.exp(x)
        return function(q) * q ** (-2 * HURST)

    return quad(integrand, np.log(low), np.log(high), limit=200, epsabs=0)[0]


def test_mean_contact_pressure_is_the_slope_at_zero_load_of_the_contact_fraction():
    pressure = theory.mean_contact_pressure(SLOPE, E)
    assert_allclose(pressure, SLOPE * E / 2)
    assert_allclose(theory.contact_fraction(1e-9, pressure), 1e-9 / pressure)


def test_contact_fraction_matches_the_error_function_integral():
    x = np.sqrt(np.pi) * 0.3 / (2 * 0.2)
    integral = quad(lambda t: 2 / np.sqrt(np.pi) * np.exp(-(t**2)), 0, x)[0]
    assert_allclose(theory.contact_fraction(0.3, 0.2), integral, rtol=1e-12)


def test_first_contact_radius_matches_equation_3():
    # Paper's parameters: the brace is 2 * 10000 * 0.1/4 * 0.5 = 250.
    expected = 4 * 250 ** (1 / 1.2)
    assert_allclose(theory.first_contact_radius(1e4, SLOPE, HURST, SHORT), expected)


def test_sphere_rises_by_the_rms_height_at_the_first_contact_radius_from_height():
    a = theory.first_contact_radius_from_height(1e4, SLOPE, HURST, SHORT)
    height = theory.rms_height(a, SLOPE, HURST, SHORT)
    assert_allclose(a**2 / 2e4, height, rtol=1e-13)


def test_printed_first_contact_radius_lacks_two_pi_of_the_rms_height():
    own = theory.first_contact_radius_from_height(1e4, SLOPE, HURST, SHORT)
    printed = theory.first_contact_radius(1e4, SLOPE, HURST, SHORT)
    assert_allclose(printed / own, (2 * np.pi) ** (1 / 1.2))


def test_contact_area_is_hertz_times_fraction():
    area = theory.hertz_contact_area(LOADS, R, E)
    expected = area * theory.contact_fraction(LOADS / area, 0.1)
    assert_allclose(theory.contact_area(LOADS, R, E, 0.1), expected, rtol=1e-13)


@pytest.mark.parametrize("load", [0.0, 1e-300, 1e-30])
def test_contact_area_is_load_over_rough_pressure_at_tiny_load(load):
    area = theory.contact_area(load, R, E, 0.1)
    assert_allclose(area, load / 0.1, rtol=1e-8)


def test_nominal_pressure_at_the_crossover_load_is_the_rough_pressure():
    load = theory.crossover_load(R, E, SLOPE, 2.9)
    pressure = load / theory.hertz_contact_area(load, R, E)
    assert_allclose(pressure, theory.mean_contact_pressure(SLOPE, E, 2.9), rtol=1e-14)


def test_contact_radius_at_the_crossover_load_is_the_crossover_radius():
    load = theory.crossover_load(R, E, SLOPE)
    ratio = theory.hertz_contact_radius(load, R, E) / R
    assert_allclose(theory.crossover_radius_ratio(SLOPE), ratio, rtol=1e-14)


def test_slope_to_curvature_ratio_follows_from_the_spectrum():
    high = 2 * np.pi / SHORT
    slope2 = spectral_average(lambda q: q**2, 1e-9 * high, high)
    curvature2 = spectral_average(lambda q: q**4, 1e-9 * high, high)
    ratio = theory.slope_to_curvature_ratio(HURST, SHORT)
    assert_allclose(ratio, np.sqrt(slope2 / curvature2), rtol=2e-4)


def test_rms_height_follows_from_the_spectrum():
    wavelength = 1e9 * SHORT
    low, high = 2 * np.pi / wavelength, 2 * np.pi / SHORT
    height2 = spectral_average(lambda q: 1.0, low, high)
    slope2 = spectral_average(lambda q: q**2, low, high)
    expected = SLOPE * np.sqrt(height2 / slope2)
    height = theory.rms_height(wavelength, SLOPE, HURST, SHORT)
    assert_allclose(height, expected, rtol=2e-4)


def test_rms_height_with_a_roll_off_follows_from_the_spectrum():
    knee = 1e9 * SHORT
    low, high = 2 * np.pi / knee, 2 * np.pi / SHORT
    height2 = spectral_average(lambda q: 1.0, low, high)
    height2 += low ** (-2 - 2 * HURST) * quad(lambda q: q, low / 5, low)[0]
    slope2 = spectral_average(lambda q: q**2, low, high)
    expected = SLOPE * np.sqrt(height2 / slope2)
    height = theory.rms_height(knee, SLOPE, HURST, SHORT, 5 * knee)
    assert_allclose(height, expected, rtol=2e-4)


def test_asperity_radius_is_equation_6():
    rho = theory.asperity_radius(SLOPE, HURST, SHORT)
    assert_allclose(rho, 4 / (0.2 * np.pi) * np.sqrt(12))


def test_asperity_radius_from_curvature_exceeds_the_printed_one_by_root_two():
    curvature = SLOPE / theory.slope_to_curvature_ratio(HURST, SHORT)
    own = theory.asperity_radius_from_curvature(curvature)
    printed = theory.asperity_radius(SLOPE, HURST, SHORT)
    assert_allclose(own / printed, np.sqrt(2), rtol=1e-14)


def test_asperity_radius_from_curvature_is_that_of_a_paraboloid():
    x = np.array([-1e-3, 0.0, 1e-3])
    heights = (x[:, None] ** 2 + x**2) / (2 * 7.0)
    laplacian = heights[[0, 2], 1].sum() + heights[1, [0, 2]].sum()
    assert_allclose(theory.asperity_radius_from_curvature(laplacian / 1e-6), 7.0)


def test_low_load_plateau_is_the_ratio_of_hertz_areas():
    ratio = theory.hertz_contact_area(1e-3, 2.5, E) / theory.hertz_contact_area(
        1e-3, R, E
    )
    assert_allclose(theory.low_load_plateau(2.5, R), ratio, rtol=1e-14)


@pytest.mark.parametrize("hurst", [0.2, 0.5, 0.8, 0.99])
@pytest.mark.parametrize("stiffness", [1e-3, 0.3, 1.0, 50.0])
def test_compliant_kappa_is_the_ratio_of_spectral_averages(hurst, stiffness):
    low, high = 2 * np.pi / LONG, 2 * np.pi / SHORT
    rigid = quad(lambda q: q ** (1 - 2 * hurst), low, high, epsabs=0)[0]
    compliant = quad(
        lambda q: q ** (1 - 2 * hurst) / (1 + E * q / (2 * stiffness)) ** 2,
        low,
        high,
        epsabs=0,
    )[0]
    kappa = theory.compliant_kappa(stiffness, E, hurst, SHORT, LONG)
    assert_allclose(kappa, 2 * np.sqrt(rigid / compliant), rtol=1e-8)


def test_compliant_kappa_counts_the_waves_of_the_roll_off():
    low, high = 2 * np.pi / 64.0, 2 * np.pi / SHORT

    def mean(weight):
        flat = quad(lambda q: q**3 * weight(q), low / 8, low, epsabs=0)[0]
        affine = spectral_average(lambda q: q**2 * weight(q), low, high)
        return flat * low ** (-2 - 2 * HURST) + affine

    band = SHORT, 64.0
    kappa = theory.compliant_kappa(0.3, E, HURST, *band, longest_wavelength=512.0)
    compliant = mean(lambda q: (1 + E * q / 0.6) ** -2)
    assert_allclose(kappa, 2 * np.sqrt(mean(lambda q: 1.0) / compliant), rtol=1e-8)


def test_long_wavelengths_change_kappa_little_when_the_range_is_wide():
    infinite = theory.compliant_kappa(E, E, HURST, SHORT)
    wide = theory.compliant_kappa(E, E, HURST, SHORT, 1e12)
    assert_allclose(wide, infinite, rtol=1e-4)


def test_compliant_kappa_refuses_an_empty_range_of_wavelengths():
    with pytest.raises(ValueError, match="must exceed short_wavelength"):
        theory.compliant_kappa(E, E, HURST, 4.0, 4.0)


@pytest.mark.parametrize(("work", "expected"), [(0.0005, 0.042), (0.005, 0.28)])
def test_attractive_inverse_kappa_takes_the_known_values(work, expected):
    # Units a0 = E* = 1, wall stiffness k = E*/a0, range sqrt(12 w/k).
    curvature = SLOPE / theory.slope_to_curvature_ratio(HURST, SHORT)
    inverse = theory.inverse_kappa_attractive(
        work, 1.0, np.sqrt(12 * work), SLOPE, curvature
    )
    assert_allclose(inverse, expected, rtol=1.5e-2)


def test_surfaces_stick_where_attraction_outweighs_repulsion():
    inverse = theory.inverse_kappa_adhesive(theory.KAPPA_REPULSIVE, [0.0, 0.28, 0.4])
    assert_allclose(inverse, [1 / 2.9, 1 / 2.9 - 0.28, 1 / 2.9 - 0.4])
    assert theory.is_sticky(inverse).tolist() == [False, False, True]
    assert theory.is_sticky(0.0)


# All


@pytest.mark.parametrize("bad", [-1.0, np.nan, np.inf])
@pytest.mark.parametrize(
    "function",
    [
        lambda bad: theory.hertz_contact_radius(bad, R, E),
        lambda bad: theory.hertz_force(0.1, bad, E),
        lambda bad: theory.jkr_force(0.1, R, E, bad),
        lambda bad: theory.maugis_parameter(R, bad, W, 1.0),
        lambda bad: theory.contact_fraction(bad, 1.0),
        lambda bad: theory.rms_height(100.0, bad, HURST, SHORT),
        lambda bad: theory.asperity_radius(SLOPE, HURST, bad),
    ],
)
def test_unphysical_arguments_are_refused(function, bad):
    with pytest.raises(ValueError, match="must be finite and"):
        function(bad)


@pytest.mark.parametrize("hurst", [0.0, 1.0, -0.2, np.nan])
def test_hurst_exponent_outside_the_open_unit_interval_is_refused(hurst):
    with pytest.raises(ValueError, match="hurst must"):
        theory.asperity_radius(SLOPE, hurst, SHORT)


def test_results_do_not_depend_on_the_system_of_units():
    def dimensionless(length, pressure):
        radius, modulus = R * length, E * pressure
        load, work = 3.0 * length**2 * pressure, W * length * pressure
        short = SHORT * length
        rough = theory.mean_contact_pressure(SLOPE, modulus)
        curvature = SLOPE / theory.slope_to_curvature_ratio(HURST, short)
        return [
            theory.contact_area(load, radius, modulus, rough) / length**2,
            theory.crossover_load(radius, modulus, SLOPE) / (length**2 * pressure),
            theory.first_contact_radius(radius, SLOPE, HURST, short) / length,
            theory.compliant_kappa(modulus / short, modulus, HURST, short),
            theory.inverse_kappa_attractive(work, modulus, length, SLOPE, curvature),
            theory.jkr_contact_radius(load, radius, modulus, work) / length,
            theory.maugis_dugdale_contact_radius(
                load, radius, modulus, work, 0.1 * pressure
            )
            / length,
            theory.tabor_parameter(radius, modulus, work, 0.3 * length),
        ]

    units = dimensionless(2.9e-10, 1.6e11)
    assert_allclose(units, dimensionless(1.0, 1.0), rtol=1e-12)
