"""Stable and unstable branches of the laws of adhesion."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from scipy.optimize import brentq

from ase_roughcontact import theory

R, E, W = 30.0, 2.0, 0.05
BRANCHES = "stable", "unstable"


@pytest.mark.parametrize("branch", BRANCHES)
def test_jkr_radius_from_force_inverts_the_force_on_both_branches(branch):
    pull_off = float(theory.jkr_pull_off_force(R, W))
    forces = pull_off * np.array([1 - 1e-9, 0.9, 0.5, 1e-3, 1e-9])
    radii = theory.jkr_contact_radius(forces, R, E, W, branch)
    assert_allclose(theory.jkr_force(radii, R, E, W), forces, rtol=1e-7, atol=1e-13)


def test_jkr_stiffness_has_opposite_signs_on_the_two_branches():
    force = 0.6 * theory.jkr_pull_off_force(R, W)
    for branch, sign in zip(BRANCHES, (1, -1), strict=True):
        a = theory.jkr_contact_radius(force, R, E, W, branch)
        step = 1e-6 * a
        change = theory.jkr_force(a + step, R, E, W) - theory.jkr_force(
            a - step, R, E, W
        )
        assert np.sign(change) == sign


@pytest.mark.parametrize("fraction", [0.999, 0.7, 0.2, 1e-3, 1e-8])
def test_jkr_radii_from_penetration_are_roots_on_both_sides_of_the_minimum(
    fraction,
):
    depth = fraction * float(theory.jkr_pull_off_penetration(R, E, W))
    least = np.cbrt(np.pi * W * R**2 / (8 * E))

    def excess(a):
        return float(theory.jkr_penetration(a, R, E, W)) - depth

    for branch, end in zip(BRANCHES, (10 * least, 0.0), strict=True):
        root = brentq(excess, *sorted((least, end)), xtol=1e-300, rtol=1e-14)
        radius = theory.jkr_contact_radius_from_penetration(depth, R, E, W, branch)
        assert_allclose(radius, root, rtol=1e-10)


@pytest.mark.parametrize("rounding", [0.0, 1e-14])
def test_jkr_branches_meet_at_the_least_penetration_and_its_rounding(rounding):
    depth = (1 + rounding) * theory.jkr_pull_off_penetration(R, E, W)
    for branch in BRANCHES:
        radius = theory.jkr_contact_radius_from_penetration(depth, R, E, W, branch)
        assert_allclose(radius**3, np.pi * W * R**2 / (8 * E), rtol=1e-6)


def test_jkr_radius_from_a_large_penetration_keeps_its_digits():
    depths = np.geomspace(1e-3, 1e15, 19)
    radii = theory.jkr_contact_radius_from_penetration(depths, R, E, W)
    assert_allclose(theory.jkr_penetration(radii, R, E, W), depths, rtol=1e-12)


def test_jkr_least_penetration_is_that_of_the_least_point_of_the_curve():
    radii = np.linspace(0.05, 5, 20001)
    least = theory.jkr_penetration(radii, R, E, W).min()
    assert_allclose(theory.jkr_pull_off_penetration(R, E, W), least, rtol=1e-6)


def test_jkr_force_at_the_least_penetration_is_five_ninths_of_pull_off():
    # Johnson, Kendall and Roberts: at fixed grips the contact is lost at -(5/6) pi w R.
    depth = theory.jkr_pull_off_penetration(R, E, W)
    a = theory.jkr_contact_radius_from_penetration(depth, R, E, W)
    assert_allclose(theory.jkr_force(a, R, E, W), -5 / 6 * np.pi * W * R, rtol=1e-6)


def test_work_along_the_jkr_curve_is_the_change_of_energy():
    a0 = theory.jkr_contact_radius(0.0, R, E, W)

    def power(a):
        step = 1e-6
        ends = theory.jkr_penetration(np.array([a + step, a - step]), R, E, W)
        return theory.jkr_force(a, R, E, W) * (ends[0] - ends[1]) / (2 * step)

    work = quad(power, 1e-5, a0, limit=200)[0]
    depth = theory.jkr_penetration(a0, R, E, W)
    elastic = E * (depth**2 * a0 - 2 * depth * a0**3 / (3 * R) + a0**5 / (5 * R**2))
    assert_allclose(work, elastic - np.pi * W * a0**2, rtol=1e-4)


def test_dmt_force_inverts_the_radius():
    forces = np.array([-9.0, 0.0, 5.0])
    radii = theory.dmt_contact_radius(forces, R, E, W)
    assert_allclose(theory.dmt_force(radii, R, E, W), forces, rtol=1e-13, atol=1e-13)


def test_dmt_penetration_is_that_of_hertz_with_the_pull_off_force_added():
    a = theory.dmt_contact_radius(1.0, R, E, W)
    expected = theory.hertz_penetration(1.0 + 2 * np.pi * W * R, R, E)
    assert_allclose(theory.dmt_penetration(a, R), expected, rtol=1e-14)


@pytest.mark.parametrize("parameter", [0.3, 1.0, 4.0])
def test_maugis_unstable_branch_lies_on_the_curve(parameter):
    stress = parameter / float(theory.maugis_parameter(R, E, W, 1.0))
    limit = theory.maugis_dugdale_stability_limit(parameter, "load")
    ratio = limit * np.array([1.001, 1.2, 3.0, 50.0])
    a, force, _ = theory.maugis_dugdale(ratio, parameter)
    radius = theory.maugis_dugdale_contact_radius(
        force * np.pi * W * R, R, E, W, stress, "unstable"
    )
    unit = theory.hertz_contact_radius(np.pi * W * R, R, E)
    assert_allclose(radius / unit, a, rtol=1e-6)


def test_maugis_branches_become_those_of_jkr_for_large_parameters():
    stress = 1e3 / float(theory.maugis_parameter(R, E, W, 1.0))
    force = -0.8 * np.pi * W * R
    for branch in BRANCHES:
        own = theory.maugis_dugdale_contact_radius(force, R, E, W, stress, branch)
        jkr = theory.jkr_contact_radius(force, R, E, W, branch)
        assert_allclose(own, jkr, rtol=1e-2)


def test_maugis_unstable_contact_is_a_point_at_the_end_of_its_branch():
    stress = 1.0 / float(theory.maugis_parameter(R, E, W, 1.0))
    _, end, _ = theory.maugis_dugdale(np.inf, 1.0)
    radius = theory.maugis_dugdale_contact_radius(
        end * np.pi * W * R, R, E, W, stress, "unstable"
    )
    assert radius < 1e-6


@pytest.mark.parametrize(
    "radius_of",
    [
        lambda branch, x: theory.jkr_contact_radius(x, R, E, W, branch),
        lambda branch, x: theory.jkr_contact_radius_from_penetration(
            x, R, E, W, branch
        ),
        lambda branch, x: theory.maugis_dugdale_contact_radius(x, R, E, W, 0.1, branch),
    ],
)
def test_unstable_branch_ends_and_unknown_branches_are_refused(radius_of):
    with pytest.raises(ValueError, match="on the unstable branch, got"):
        radius_of("unstable", 0.1)
    with pytest.raises(ValueError, match="'stable' or 'unstable', got 'upper'"):
        radius_of("upper", 0.0)


def test_penetration_below_that_of_pull_off_is_refused():
    with pytest.raises(ValueError, match="must not be below that of pull-off"):
        theory.jkr_contact_radius_from_penetration(-100.0, R, E, W)
