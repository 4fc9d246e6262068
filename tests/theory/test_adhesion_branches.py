"""Stable branches of the laws of adhesion, and the curves that they are part of."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq

from ase_roughcontact import theory

R, E, W = 30.0, 2.0, 0.05
JKR, DMT = theory.JKR(R, E, W), theory.DMT(R, E, W)


def maugis(parameter):
    """Theory of Maugis and Dugdale for the sphere with a given parameter."""
    tension = parameter / np.cbrt(9 * R / (2 * np.pi * W * E**2))
    return theory.MaugisDugdale(R, E, W, W / tension)


def test_jkr_radius_from_force_inverts_the_force():
    forces = -JKR.pull_off_force * np.array([1 - 1e-9, 0.9, 0.5, 1e-3, 1e-9])
    radii = JKR.contact_radius(forces)
    assert_allclose(JKR.force(radii), forces, rtol=1e-7, atol=1e-13)


def test_jkr_stiffness_is_positive():
    a = JKR.contact_radius(-0.6 * JKR.pull_off_force)
    step = 1e-6 * a
    assert JKR.force(a + step) > JKR.force(a - step)


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


def test_jkr_least_penetration_is_that_of_the_least_point_of_the_curve():
    radii = np.linspace(0.05, 5, 20001)
    least = JKR.penetration(radii).min()
    assert_allclose(JKR.pull_off_penetration, least, rtol=1e-6)


def test_jkr_force_at_the_least_penetration_is_five_ninths_of_pull_off():
    # Johnson, Kendall and Roberts: at fixed grips the contact is lost at -(5/6) pi w R.
    depth = JKR.pull_off_penetration
    a = JKR.contact_radius_from_penetration(depth)
    assert_allclose(JKR.force(a), -5 / 6 * np.pi * W * R, rtol=1e-6)


def test_work_along_the_jkr_curve_is_the_change_of_energy():
    a0 = JKR.contact_radius(0.0)

    def power(a):
        step = 1e-6
        ends = JKR.penetration([a + step, a - step])
        return JKR.force(a) * (ends[0] - ends[1]) / (2 * step)

    work = quad(power, 1e-5, a0, limit=200)[0]
    depth = JKR.penetration(a0)
    elastic = E * (depth**2 * a0 - 2 * depth * a0**3 / (3 * R) + a0**5 / (5 * R**2))
    assert_allclose(work, elastic - np.pi * W * a0**2, rtol=1e-4)


def test_dmt_force_inverts_the_radius():
    forces = np.array([-9.0, 0.0, 5.0])
    radii = DMT.contact_radius(forces)
    assert_allclose(DMT.force(radii), forces, rtol=1e-13, atol=1e-13)


def test_dmt_penetration_is_that_of_hertz_with_the_pull_off_force_added():
    depth = DMT.penetration(DMT.contact_radius(1.0))
    hertz = theory.Hertz(R, E)
    expected = hertz.penetration(hertz.contact_radius(1.0 + 2 * np.pi * W * R))
    assert_allclose(depth, expected, rtol=1e-14)


@pytest.mark.parametrize("parameter", [0.3, 1.0, 4.0])
def test_maugis_stable_branch_lies_on_the_curve(parameter):
    sphere = maugis(parameter)
    end = sphere.stability_limit("load") - 1.0
    ratio = 1.0 + end * np.array([0.999, 0.8, 0.1, 1e-3])
    a, force, _ = sphere.state(ratio)
    assert_allclose(sphere.contact_radius(force), a, rtol=1e-6)


def test_maugis_becomes_jkr_for_large_parameters():
    force = -0.8 * np.pi * W * R
    own = maugis(1e3).contact_radius(force)
    assert_allclose(own, JKR.contact_radius(force), rtol=1e-2)


def test_maugis_contact_is_a_point_at_an_infinite_ratio():
    a, _, _ = maugis(1.0).state(np.inf)
    assert a < 1e-6


def test_penetration_below_that_of_pull_off_is_refused():
    with pytest.raises(ValueError, match="must not be below that of pull-off"):
        JKR.contact_radius_from_penetration(-100.0)
