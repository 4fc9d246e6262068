"""Troubles of measured force curves that are said by name."""

import numpy as np
import pytest

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.curve_checks import (
    contact_point,
    curve_checks,
    deflection_slope,
)
from ase_roughcontact.fitting.force_curve import ForceCurve

NM, NN, N_M = (UNITS[unit] for unit in ("nm", "nN", "N/m"))
# Base (nm) of approach and retraction, force (nN) of a stiff sample below 0.
BASE = np.append(np.linspace(200.0, -20.0, 1101), np.linspace(-20.0, 200.0, 1101))
NOISE = np.random.default_rng(0).normal(0.0, 0.02, BASE.size)
CONTACT = np.where(BASE < 0.0, -0.5 * BASE, 0.0)


def curve(force, stiffness=1.0):
    depth = (-BASE - force / stiffness) * NM
    return ForceCurve(depth, force * NN, stiffness * N_M)


def test_an_ordinary_curve_has_no_troubles():
    assert curve_checks(curve(CONTACT + NOISE)) == []


def test_equal_forces_in_a_row_are_saturated():
    (check,) = curve_checks(curve(np.minimum(CONTACT + NOISE, 6.0)))
    assert "the force is 6 nN on" in check


def test_fewer_equal_forces_or_free_ones_are_not_saturated():
    force = CONTACT + NOISE
    most = np.sort(force)[-9]  # a limit at nine points
    assert not curve(np.minimum(force, most)).saturated.any()
    assert not curve(CONTACT).saturated.any()


def test_a_deflection_that_changes_more_than_the_base_has_a_wrong_sensitivity():
    # the slope is 0.5 nN/nm in contact, at most 0.4 with a cantilever of 0.4 N/m
    first, second = curve_checks(curve(CONTACT + NOISE, 0.4))
    assert "on the approach the deflection changes by 1.2" in first
    assert "sensitivity is too large" in second


@pytest.mark.parametrize("limit", [-0.02, 0.01, 0.1])
def test_a_clipped_baseline_is_named(limit):
    checks = curve_checks(curve(np.maximum(CONTACT + NOISE, limit)))
    named = [check for check in checks if "baseline seems clipped" in check]
    assert len(named) == (0 if limit == -0.02 else 2)  # a sixth of the points is not


def test_steps_of_a_digital_signal_and_curves_without_noise_are_not_clipped():
    step = 0.05
    digital = step * np.round((CONTACT + 0.5 * NOISE) / step)
    for force in (digital, CONTACT, 0.01 * np.maximum(-BASE, 0.0) ** 1.5):
        checks = curve_checks(curve(force))
        assert not any("clipped" in check for check in checks)


def test_the_slope_of_the_deflection_on_a_rigid_sample_is_one():
    rigid = curve(np.where(BASE < 0.0, -BASE, 0.0) + NOISE)
    assert deflection_slope(rigid, rigid.branches[0]) == pytest.approx(1.0, abs=0.01)
    soft = curve(CONTACT + NOISE)
    assert deflection_slope(soft, soft.branches[0]) == pytest.approx(0.5, abs=0.01)


def test_a_drift_is_named():
    drift = 0.01 * (BASE - BASE.max())
    checks = curve_checks(curve(CONTACT + NOISE + drift))
    assert len(checks) == 2
    assert "of the approach changes by 2.2" in checks[0]


def test_free_forces_that_differ_are_named():
    shift = np.where(np.arange(BASE.size) < 1101, 0.0, 1.5)
    (check,) = curve_checks(curve(CONTACT + NOISE + shift))
    assert "0.00" in check and "1.5 nN on the retraction" in check


def test_a_curve_without_a_free_part_is_named():
    inside = BASE < -1.0
    force = (CONTACT + NOISE)[inside]
    depth = (-BASE[inside] - force) * NM
    checks = curve_checks(ForceCurve(depth, force * NN, N_M))
    assert sum("has no free part" in check for check in checks) == 2


def test_the_contact_point_is_where_the_force_leaves_the_baseline():
    point = contact_point(curve(CONTACT + NOISE))
    assert BASE[point] == pytest.approx(0.0, abs=0.6)
    assert contact_point(curve(NOISE)) is None
