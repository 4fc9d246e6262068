"""Hertz, JKR, DMT and Maugis-Dugdale against independent calculations."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq, minimize_scalar

from ase_roughcontact import theory

R, E, W = 30.0, 2.0, 0.05
LOADS = np.geomspace(1e-12, 1e12, 49)
HERTZ, JKR, DMT = theory.Hertz(R, E), theory.JKR(R, E, W), theory.DMT(R, E, W)


def maugis(parameter):
    """Theory of Maugis and Dugdale for the sphere with a given parameter."""
    tension = parameter / np.cbrt(9 * R / (2 * np.pi * W * E**2))
    return theory.MaugisDugdale(R, E, W, W / tension)


# Hertz


def test_hertz_pressure_integrates_to_the_normal_force():
    a = HERTZ.contact_radius(1.7)
    force, _ = quad(lambda r: 2 * np.pi * r * HERTZ.pressure(r, a), 0, a, epsabs=0)
    assert_allclose(force, 1.7, rtol=1e-8)


def test_hertz_pressure_lifts_the_centre_by_the_penetration():
    # Displacement at the axis of a pressure p(r) is (2/E*) times its radial integral.
    a = HERTZ.contact_radius(1.7)
    integral, _ = quad(HERTZ.pressure, 0, a, args=(a,))
    assert_allclose(2 * integral / E, HERTZ.penetration(a), rtol=1e-8)


def test_hertz_pressure_is_zero_outside_the_contact():
    assert_allclose(HERTZ.pressure([2.0, 2.1, 50.0], 2.0), 0.0)


def test_hertz_force_grows_with_the_penetration_to_the_power_three_halves():
    a = HERTZ.contact_radius(LOADS)
    assert_allclose(HERTZ.force(a), LOADS, rtol=1e-13)
    depth = HERTZ.penetration(a)
    assert_allclose(4 / 3 * E * np.sqrt(R) * depth**1.5, LOADS, rtol=1e-13)
    assert_allclose(HERTZ.contact_radius_from_penetration(depth), a, rtol=1e-13)


# JKR and DMT


@pytest.mark.parametrize("a", [0.8, 2.0, 6.0])
def test_jkr_contact_radius_makes_the_total_energy_stationary(a):
    # Elastic energy of a contact of given radius and penetration, minus w times area.
    def energy(radius, depth):
        cubic = depth**2 * radius - 2 * depth * radius**3 / (3 * R)
        return E * (cubic + radius**5 / (5 * R**2)) - np.pi * W * radius**2

    depth, step = JKR.penetration(a), 1e-4
    slope = (energy(a + step, depth) - energy(a - step, depth)) / (2 * step)
    assert abs(slope) < 1e-6 * 2 * np.pi * W * a
    force = (energy(a, depth + step) - energy(a, depth - step)) / (2 * step)
    assert_allclose(JKR.force(a), force, rtol=1e-7)


def test_jkr_radius_from_force_inverts_force_from_radius_on_stable_branch():
    pulling = -JKR.pull_off_force * np.array([1 - 1e-9, 0.9, 0.5, 1e-3, 1e-9])
    forces = np.append(pulling, np.geomspace(1e-6, 1e4, 30))
    radii = JKR.contact_radius(forces)
    assert_allclose(JKR.force(radii), forces, rtol=1e-7, atol=1e-10)
    assert np.all(np.diff(radii) > 0)


def test_jkr_least_force_is_the_pull_off_force_at_the_documented_radius():
    least = minimize_scalar(JKR.force, bounds=(0.1, 5.0), options={"xatol": 1e-9})
    assert_allclose(least.fun, -JKR.pull_off_force, rtol=1e-12)
    assert_allclose(least.x**3, 9 * np.pi * W * R**2 / (8 * E), rtol=1e-6)


@pytest.mark.parametrize("rounding", [0.0, 1e-14])
def test_jkr_and_dmt_accept_their_own_pull_off_force_with_its_rounding(rounding):
    factor = 1 + rounding
    jkr, dmt = (
        sphere.contact_radius(-factor * sphere.pull_off_force) for sphere in (JKR, DMT)
    )
    assert_allclose(jkr**3, 9 * np.pi * W * R**2 / (8 * E))
    assert dmt == 0.0


def test_dmt_contact_is_hertz_with_the_pull_off_force_added():
    forces = np.array([-9.0, 0.0, 5.0])
    radii = DMT.contact_radius(forces)
    assert_allclose(radii, HERTZ.contact_radius(forces + 2 * np.pi * W * R), rtol=1e-14)
    assert_allclose(DMT.force(radii), forces, rtol=1e-13, atol=1e-13)
    assert_allclose(DMT.penetration(radii), HERTZ.penetration(radii), rtol=1e-14)


# Maugis-Dugdale


@pytest.mark.parametrize("stress", [0.02, 0.1, 0.5])
@pytest.mark.parametrize("ratio", [1.01, 1.5, 10.0])
def test_maugis_state_solves_the_contact_problem_with_a_cohesive_zone(stress, ratio):
    # Sneddon's transform: surface displacement u and force follow from
    # g(t) = int_t^inf r p(r)/sqrt(r^2 - t^2) dr, here built from a, c and sigma0.
    a, force, depth = theory.MaugisDugdale(R, E, W, W / stress).state(ratio)
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
    ("parameter", "expected", "rtol"), [(1e-4, 2.0, 1e-5), (1e3, 1.5, 1e-5)]
)
def test_maugis_pull_off_goes_from_dmt_to_jkr(parameter, expected, rtol):
    pull_off = maugis(parameter).pull_off_force
    assert_allclose(pull_off, expected * np.pi * W * R, rtol=rtol)


def test_maugis_load_stability_ends_where_the_force_is_least():
    limit = maugis(1.0).stability_limit("load")
    _, force, _ = maugis(1.0).state(limit * np.array([0.99, 1.0, 1.01]))
    assert np.argmin(force) == 1
    assert_allclose(force[1], -maugis(1.0).pull_off_force, rtol=1e-12)


def test_maugis_pull_off_is_stable_below_the_known_parameter():
    # Johnson & Greenwood (1997): an instability under displacement control above 0.938.
    assert maugis(0.937).stability_limit("displacement") == np.inf
    assert maugis(0.939).stability_limit("displacement") < np.inf


def test_maugis_parameter_is_1_16_tabor_for_the_lennard_jones_strength():
    # Largest tension of the surface law (8w/3z0)[(z0/z)^3 - (z0/z)^9] is 1.026 w/z0.
    z0 = 0.4
    strength = 16 * W / (9 * np.sqrt(3) * z0)
    maugis = theory.MaugisDugdale(R, E, W, W / strength).parameter
    tabor = theory.MaugisDugdale(R, E, W, z0).tabor_parameter
    assert_allclose(maugis / tabor, 1.157, atol=1e-3)


# Stable branches


@pytest.mark.parametrize("fraction", [0.999, 0.7, 0.2, 1e-3, 1e-8])
def test_jkr_radius_from_penetration_is_the_root_above_the_minimum(fraction):
    depth = fraction * JKR.pull_off_penetration
    least = np.cbrt(np.pi * W * R**2 / (8 * E))

    def excess(a):
        return float(JKR.penetration(a)) - depth

    root = brentq(excess, least, 10 * least, xtol=1e-300, rtol=1e-14)
    assert_allclose(JKR.contact_radius_from_penetration(depth), root, rtol=1e-10)


@pytest.mark.parametrize("rounding", [0.0, 1e-14])
def test_jkr_branch_ends_at_the_least_penetration_and_its_rounding(rounding):
    depth = (1 + rounding) * JKR.pull_off_penetration
    radius = JKR.contact_radius_from_penetration(depth)
    assert_allclose(radius**3, np.pi * W * R**2 / (8 * E), rtol=1e-6)


def test_jkr_radius_from_a_large_penetration_keeps_its_digits():
    depths = np.geomspace(1e-3, 1e15, 19)
    radii = JKR.contact_radius_from_penetration(depths)
    assert_allclose(JKR.penetration(radii), depths, rtol=1e-12)


@pytest.mark.parametrize("parameter", [0.3, 1.0, 4.0])
def test_maugis_stable_branch_lies_on_the_curve(parameter):
    sphere = maugis(parameter)
    end = sphere.stability_limit("load") - 1.0
    ratio = 1.0 + end * np.array([0.999, 0.8, 0.1, 1e-3])
    a, force, _ = sphere.state(ratio)
    assert_allclose(sphere.contact_radius(force), a, rtol=1e-6)


def test_maugis_contact_is_a_point_at_an_infinite_ratio():
    a, _, _ = maugis(1.0).state(np.inf)
    assert a < 1e-6


# The interface of all


@pytest.mark.parametrize("sphere", [HERTZ, JKR, DMT, maugis(0.3), maugis(3.0)])
def test_force_radius_and_penetration_are_inverse_to_each_other(sphere):
    force = np.array([[-0.9], [0.5]]) * max(sphere.pull_off_force, 1.0)
    force = np.maximum(force, -0.9 * sphere.pull_off_force)
    a = sphere.contact_radius(force)
    assert_allclose(sphere.force(a), force, atol=1e-9)
    depth = sphere.penetration(a)
    assert_allclose(sphere.penetration_under(force), depth)
    assert_allclose(sphere.contact_radius_from_penetration(depth), a, atol=1e-9)
    least = sphere.pull_off_penetration
    assert least < depth.min() or sphere is HERTZ
    with pytest.raises(ValueError, match="penetration must be"):
        sphere.contact_radius_from_penetration(least - 0.1)


@pytest.mark.parametrize("parameter, limit", [(1e-6, DMT), (30.0, JKR)])
def test_maugis_dugdale_has_the_forces_of_its_limits_at_a_radius(parameter, limit):
    a, sphere = np.array([2.0, 5.0, 12.0]), maugis(parameter)
    unit = 0.01 * limit.pull_off_force
    assert_allclose(sphere.force(a), limit.force(a), rtol=0.01, atol=unit)
    depth = limit.penetration(a)
    assert_allclose(sphere.penetration(a), depth, rtol=0.01)


@pytest.mark.parametrize("parameter", [0.05, 0.5, 5.0])
def test_maugis_dugdale_at_a_radius_is_the_state_with_this_radius(parameter):
    sphere = maugis(parameter)
    a, force, depth = sphere.state(np.geomspace(1.0001, 20.0, 9))
    assert_allclose(sphere.force(a), force, rtol=1e-9, atol=1e-9)
    assert_allclose(sphere.penetration(a), depth, rtol=1e-9, atol=1e-9)
    ratio = min(sphere.stability_limit("displacement"), 1e6)
    least = sphere.state(ratio)[2]
    assert_allclose(sphere.pull_off_penetration, least, rtol=1e-3)
