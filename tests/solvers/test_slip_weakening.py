"""Friction that weakens by slip, against dense solutions and the nucleation length."""

import numpy as np
import pytest

from ase_roughcontact import FrictionLaw, SlipWeakening, Tresca
from ase_roughcontact.contact.support import LateralSupport
from ase_roughcontact.elasticity import Isotropic, cerruti_kernel
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.interactions import SLIP
from ase_roughcontact.interactions.local_friction import LocalFriction
from ase_roughcontact.solvers.lateral.slip import Drive, follow_slip

POISSON = 0.3
# Total length of the patch that slips at the instability times W/E* (Uenishi & Rice).
NUCLEATION = 1.158
# Weakening of lines of atoms.
RESIDUAL, DISTANCE = 0.2, 1.5


class Uneven(FrictionLaw):
    """Bound with a minimum at the middle of a line, which falls linearly with slip."""

    histories = (SLIP,)

    def __init__(self, weakening, length):
        self.weakening, self.length = weakening, length

    def bound(self, pressure, slip, rate, time, history, x, y):
        peak = 1.1 - 0.1 * np.cos(2.0 * np.pi * x / self.length)
        return peak - self.weakening * slip


def longest_stable_patch(n, length, axis):
    """Atoms of the longest patch that slips on a line under a rising force."""
    half = LateralHalfSpace((n, 2), 1.0, Isotropic(1.0, POISSON), True)
    law, shape = Uneven(NUCLEATION / length, n), (n, 2)
    middle = (-0.5 * (n - 1), 0.0)
    friction = LocalFriction(law, np.ones(shape), np.ones(shape, bool), 1.0, middle)
    tractions, before = np.zeros((2, *shape)), LateralSupport((0.0, 0.0))
    for part in np.linspace(1.0, 1.1, 5):
        force = np.zeros(2)
        force[axis] = part * 2 * n
        after = LateralSupport((force[0], force[1]))
        drive = Drive(np.zeros((2, *shape)), (before, after))
        step = follow_slip(half, friction, tractions, drive)
        friction, tractions = step.friction, step.solution.tractions
        before = after
        if not step.solution.converged:
            assert "after an instability" in step.solution.message
            return np.count_nonzero(friction.history[SLIP.name][:, 0])
    raise AssertionError("no instability")


def stiffness_of_patch(n, atoms, factor):
    """Smallest eigenvalue of the stiffness of a patch on a periodic line."""
    waves = 2.0 * np.pi * abs(np.fft.fftfreq(n))
    rows = np.fft.ifft(0.5 * factor * waves).real
    i = np.arange(atoms)
    return np.linalg.eigvalsh(rows[i[:, None] - i])[0]


@pytest.mark.parametrize("axis, factor", [(0, 1.0), (1, 1.0 - POISSON)])
def test_slip_runs_away_at_the_nucleation_length_along_and_across(axis, factor):
    n, length = 96, 24.0
    found = longest_stable_patch(n, length, axis)
    assert factor * length - 4.0 <= found <= factor * length + 2.0
    weakening = NUCLEATION / length
    # two more atoms at each end are unstable, two fewer stable
    assert stiffness_of_patch(n, found - 4, factor) > weakening
    assert stiffness_of_patch(n, found + 4, factor) < weakening


def lowest_slip(stiffness, peak, moved):
    """Smallest slip in equilibrium, by raising that of one atom after another."""
    slip = np.zeros(peak.size)
    slope = peak * (1.0 - RESIDUAL) / DISTANCE
    diagonal = stiffness.diagonal()
    assert (diagonal > slope).all()
    while True:
        before = slip.copy()
        for i in range(peak.size):
            traction = stiffness[i] @ (moved - slip) + diagonal[i] * slip[i]
            new = (traction - peak[i]) / (diagonal[i] - slope[i])
            if new > DISTANCE:
                new = (traction - RESIDUAL * peak[i]) / diagonal[i]
            slip[i] = max(new, slip[i])
        if abs(slip - before).max() < 1e-13 * DISTANCE:
            return slip


def dense_line(rng):
    """A line of atoms that weaken by an instability, and the dense stiffness."""
    n = 12
    i = np.arange(n)
    xx, _, xy = cerruti_kernel(i[:, None] - i, 0 * i, 1.0, 1.0, 0.0)
    assert not xy.any()
    half = LateralHalfSpace((n, 1), 1.0, Isotropic(1.0, 0.0))
    return half, np.linalg.inv(xx), rng.uniform(0.5, 1.5, n)


class Peaks(FrictionLaw):
    """Given bounds along a line."""

    def __init__(self, peak):
        self.peak = peak

    def bound(self, pressure, slip, rate, time, history, x, y):
        return self.peak[np.rint(x).astype(int)]


def on_line(peak):
    law, shape = SlipWeakening(Peaks(peak), RESIDUAL, DISTANCE), (12, 1)
    return LocalFriction(law, np.ones(shape), np.ones(shape, bool), 1.0, (0.0, 0.0))


def drive_by(distance):
    imposed = np.zeros((2, 12, 1))
    imposed[0] = distance
    return Drive(imposed)


@pytest.mark.parametrize("seed", range(2))
def test_slip_is_the_smallest_of_a_dense_solution_also_beyond_instabilities(seed):
    half, stiffness, peak = dense_line(np.random.default_rng(seed))
    friction, tractions, last = on_line(peak), np.zeros((2, 12, 1)), 0.0
    for moved in np.arange(1.0, 8.0, 1.5):
        step = follow_slip(half, friction, tractions, drive_by(moved - last))
        assert step.solution.converged
        friction, tractions = step.friction, step.solution.tractions
        last = moved
        expected = lowest_slip(stiffness, peak, moved)
        found = friction.history[SLIP.name][:, 0]
        assert found == pytest.approx(expected, abs=1e-4 * DISTANCE)


def energy(stiffness, peak, moved, slip):
    """Elastic energy and work of friction."""
    weak = np.minimum(slip, DISTANCE)
    friction = peak * (
        RESIDUAL * slip + (1.0 - RESIDUAL) * (weak - 0.5 * weak**2 / DISTANCE)
    )
    return 0.5 * (moved - slip) @ stiffness @ (moved - slip) + friction.sum()


def test_an_instability_releases_the_energy_that_a_dense_solution_loses():
    half, stiffness, peak = dense_line(np.random.default_rng(0))
    step = follow_slip(half, on_line(peak), np.zeros((2, 12, 1)), drive_by(8.0))
    assert step.instabilities == 1
    moves = np.arange(0.0, 8.1, 0.5)
    slips = [lowest_slip(stiffness, peak, moved) for moved in moves]
    first = np.diff([slip.sum() for slip in slips]).argmax()
    (below, above), (lower, upper) = moves[first:][:2], slips[first:][:2]
    while above - below > 1e-6:  # towards the larger change
        moved = 0.5 * (below + above)
        slip = lowest_slip(stiffness, peak, moved)
        if (upper - slip).sum() > (slip - lower).sum():
            below, lower = moved, slip
        else:
            above, upper = moved, slip
    ends = [energy(stiffness, peak, below, slip) for slip in (lower, upper)]
    assert step.released == pytest.approx(ends[0] - ends[1], rel=0.02)


@pytest.mark.parametrize("residual", [0.5, 0.9])
def test_a_block_on_a_soft_spring_releases_energy_however_little_friction_falls(
    residual,
):
    half, none = LateralHalfSpace((1, 1), 1.0, Isotropic(1e6, 0.3)), np.zeros((2, 1, 1))
    law, distance, spring = SlipWeakening(Tresca(1.0), residual, 0.1), 0.1, 0.02
    one = np.ones((1, 1))
    friction = LocalFriction(law, one, one > 0.0, 1.0, (0.0, 0.0))
    supports = LateralSupport((0.0, 0.0), spring), LateralSupport((1.02, 0.0), spring)
    step = follow_slip(half, friction, none, Drive(none, supports))
    assert step.instabilities == 1
    # the spring relaxes by the fall of friction
    moved = (1.0 - residual) / spring
    expected = 0.5 * (1.0 - residual) * (moved - distance)
    # located to a thousandth of the step, a hundredth of the smaller slip
    assert step.released == pytest.approx(expected, rel=0.02)
    assert step.solution.shift[0] == pytest.approx((1.02 - residual) / spring, rel=1e-4)
