"""Errors of time steps are relative to what the path is about, however shallow."""

import numpy as np
import pytest

from ase_roughcontact import (
    Creep,
    HardWall,
    Problem,
    RoughSphere,
    Schedule,
    StepOptions,
    Stepper,
    Viscoelastic,
)
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.path_kinds.time.specification import TimeSpecification
from ase_roughcontact.path_kinds.time.steps import TimeSteps
from ase_roughcontact.paths import follow as paths

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")

MODULI, TIMES, RAMP = np.array([0.4, 0.4]), np.array([0.02, 20.0]), 0.1


class Flat:
    """Flat punch over the whole window."""

    def heights(self, shape, spacing, origin):
        return np.zeros(shape)


def follow(indenter, n, schedule, tolerance, moduli=MODULI, times=TIMES, **control):
    solid = Viscoelastic(Isotropic(1.0), Creep.of_relaxation(moduli, times))
    problem = Problem(indenter, solid, HardWall(), 1.0)
    window = Box((-(n // 2), -(n // 2)), (n, n))
    options = StepOptions(window="unchecked")
    stepper = Stepper(problem, control.get("control", "penetrations"), window, options)
    return list(
        paths.follow(TimeSteps(stepper, TimeSpecification(schedule, tolerance)))
    )


def unit_ramp(time):
    """Force of a linear contact of unit stiffness that is pressed by a unit depth."""
    time = max(time, 0.0)
    end = min(time, RAMP)
    rest = (1.0 - MODULI.sum()) * end
    decays = np.exp(-(time - end) / TIMES) - np.exp(-time / TIMES)
    return (rest + (MODULI * TIMES * decays).sum()) / RAMP


def punch(depth, tolerance=1e-3, hold=60.0):
    """Return steps and largest error of a flat punch, relative to its largest force."""
    path = Schedule(0.0).ramp(depth, time=RAMP).hold(hold)
    path = path.ramp(1.5 * depth, time=RAMP).hold(hold)
    steps = follow(Flat(), 8, path, tolerance)
    force = [unit_ramp(s.time) + 0.5 * unit_ramp(s.time - RAMP - hold) for s in steps]
    found = np.array([step.normal_force for step in steps])
    # the stiffness is known from the sudden response, which is elastic
    (_, sudden) = follow(Flat(), 8, Schedule(0.0).step(depth), tolerance)
    expected = sudden.normal_force * np.array(force)
    assert all(step.converged for step in steps)
    return steps, float(abs(found - expected).max() / expected.max())


@pytest.mark.parametrize("depth", [1.0, 1e-3, 1e-7])
def test_the_error_of_a_flat_punch_does_not_depend_on_its_depth(depth):
    steps, error = punch(depth)
    assert error < 2e-3
    assert 40 < len(steps) < 170  # 85


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5])
def test_errors_of_many_small_steps_add_up_to_twice_the_tolerance(tolerance):
    _, error = punch(0.01, tolerance, hold=1.0)
    assert error < 2.0 * tolerance


def test_a_long_hold_after_a_kink_begins_with_steps_of_the_shortest_time():
    path = Schedule(0.0).ramp(1e-4, time=0.02).hold(40.0)
    steps = follow(Flat(), 8, path, 1e-3, [0.8], [0.02])
    after = [step.time - 0.02 for step in steps if step.time > 0.02]
    assert after[0] < 0.02
    forces = np.array([s.normal_force for s in steps if s.time >= 0.02])
    held = np.append(0.0, after)
    expected = forces[-1] + (forces[0] - forces[-1]) * np.exp(-held / 0.02)
    assert forces == pytest.approx(expected, abs=2e-3 * forces[0])


@pytest.mark.parametrize("control", ["penetrations", "loads"])
def test_spheres_of_all_radii_have_the_same_time_steps(control):
    """A paraboloid below a hard wall is linear in its curvature."""

    def reduced(radius):
        largest = {"penetrations": 36.0, "loads": 200.0}[control] / radius
        path = Schedule(0.0).ramp(largest, time=0.02).hold(40.0)
        arguments = RoughSphere(radius), 18, path, 1e-3, [0.8], [0.02]
        steps = follow(*arguments, control=control)
        columns = [(s.time, radius * s.normal_force, s.repulsive_atoms) for s in steps]
        return np.array(columns)

    small, large = reduced(300.0), reduced(1e6)
    assert len(small) == len(large) < 120  # 57, 50
    np.testing.assert_allclose(large[:, 0], small[:, 0])
    atol = 1e-3 * small[:, 1].max()
    np.testing.assert_allclose(large[:, 1], small[:, 1], atol=atol)


def test_the_largest_target_includes_the_oscillation_and_has_its_time():
    path = Schedule(1.0).ramp(3.0, time=2.0).oscillate(0.5, 2.0, cycles=4).hold(1.0)
    assert path.largest() == (3.5, 4.0)
    assert Schedule(1.0).ramp(-2.0, time=2.0).hold(1.0).largest(-1.0) == (-2.0, 2.0)
    assert Schedule(1.0).ramp(0.0, time=2.0).largest() == (1.0, 0.0)
