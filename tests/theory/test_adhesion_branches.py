"""Stable and unstable branches of the laws of adhesion."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq

from ase_roughcontact import theory

R, E, W = 30.0, 2.0, 0.05
BRANCHES = "stable", "unstable"
JKR, DMT = theory.JKR(R, E, W), theory.DMT(R, E, W)


def maugis(parameter):
    """Theory of Maugis and Dugdale for the sphere with a given parameter."""
    tension = parameter / np.cbrt(9 * R / (2 * np.pi * W * E**2))
    return theory.MaugisDugdale(R, E, W, W / tension)


@pytest.mark.parametrize("branch", BRANCHES)
def test_jkr_radius_from_force_inverts_the_force_on_both_branches(branch):
    forces = JKR.pull_off_force * np.array([1 - 1e-9, 0.9, 0.5, 1e-3, 1e-9])
    radii = JKR.contact_radius(forces, branch)
    assert_allclose(JKR.force(radii), forces, rtol=1e-7, atol=1e-13)


def test_jkr_stiffness_has_opposite_signs_on_the_two_branches():
    force = 0.6 * JKR.pull_off_force
    for branch, sign in zip(BRANCHES, (1, -1), strict=True):
        a = JKR.contact_radius(force, branch)
        step = 1e-6 * a
        change = JKR.force(a + step) - JKR.force(a - step)
        assert np.sign(change) == sign


@pytest.mark.parametrize("fraction", [0.999, 0.7, 0.2, 1e-3, 1e-8])
def test_jkr_radii_from_penetration_are_roots_on_both_sides_of_the_minimum(
    fraction,
):
    depth = fraction * JKR.pull_off_penetration
    least = np.cbrt(np.pi * W * R**2 / (8 * E))

    def excess(a):
        return float(JKR.penetration(a)) - depth

    for branch, end in zip(BRANCHES, (10 * least, 0.0), strict=True):
        root = brentq(excess, *sorted((least, end)), xtol=1e-300, rtol=1e-14)
        radius = JKR.contact_radius_from_penetration(depth, branch)
        assert_allclose(radius, root, rtol=1e-10)


@pytest.mark.parametrize("rounding", [0.0, 1e-14])
def test_jkr_branches_meet_at_the_least_penetration_and_its_rounding(rounding):
    depth = (1 + rounding) * JKR.pull_off_penetration
    for branch in BRANCHES:
        radius = JKR.contact_radius_from_penetration(depth, branch)
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
def test_maugis_unstable_branch_lies_on_the_curve(parameter):
    sphere = maugis(parameter)
    ratio = sphere.stability_limit("load") * np.array([1.001, 1.2, 3.0, 50.0])
    a, force, _ = sphere.state(ratio)
    assert_allclose(sphere.contact_radius(force, "unstable"), a, rtol=1e-6)


def test_maugis_branches_become_those_of_jkr_for_large_parameters():
    force = -0.8 * np.pi * W * R
    for branch in BRANCHES:
        own = maugis(1e3).contact_radius(force, branch)
        jkr = JKR.contact_radius(force, branch)
        assert_allclose(own, jkr, rtol=1e-2)


def test_maugis_unstable_contact_is_a_point_at_the_end_of_its_branch():
    _, end, _ = maugis(1.0).state(np.inf)
    assert maugis(1.0).contact_radius(end, "unstable") < 1e-6


@pytest.mark.parametrize(
    "radius_of",
    [
        JKR.contact_radius,
        JKR.contact_radius_from_penetration,
        maugis(1.0).contact_radius,
    ],
)
def test_unstable_branch_ends_and_unknown_branches_are_refused(radius_of):
    with pytest.raises(ValueError, match="on the unstable branch, got"):
        radius_of(0.1, "unstable")
    with pytest.raises(ValueError, match="'stable' or 'unstable', got 'upper'"):
        radius_of(0.0, "upper")


def test_penetration_below_that_of_pull_off_is_refused():
    with pytest.raises(ValueError, match="must not be below that of pull-off"):
        JKR.contact_radius_from_penetration(-100.0)
