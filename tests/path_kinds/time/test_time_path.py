"""Paths in time on viscoelastic solids, against exact results and elastic limits."""

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from ase_roughcontact import (
    Creep,
    HardWall,
    LennardJones93,
    PlasticWall,
    Problem,
    RoughSphere,
    Schedule,
    SelfAffine,
    StepOptions,
    Stepper,
    Viscoelastic,
)
from ase_roughcontact.elasticity import Isotropic, Layer
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.path_kinds.time.specification import TimeSpecification
from ase_roughcontact.path_kinds.time.steps import TimeSteps
from ase_roughcontact.paths import follow as paths
from ase_roughcontact.paths.path_steps import NumberedSteps

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")

CREEP = Creep.standard_solid(relaxed=0.2, time=1.0)


def problem_of(n, wall=None, creep=CREEP, radius=None, solid=1.0, **options):
    solid = Isotropic(solid) if creep is None else Viscoelastic(solid, creep)
    indenter = options.pop("indenter", None) or RoughSphere(radius or 10.0 * n)
    offset = (0.0, 0.0) if options.get("periodic") else (0.5, 0.5)
    return Problem(indenter, solid, wall or HardWall(), 1.0, offset=offset, **options)


def stepper_of(problem, n, control="penetrations", **options):
    return Stepper(
        problem, control, Box((-n // 2, -n // 2), (n, n)), StepOptions(**options)
    )


def follow(problem, n, schedule, control="penetrations", tolerance=1e-3, **options):
    stepper = stepper_of(problem, n, control, **options)
    return list(
        paths.follow(TimeSteps(stepper, TimeSpecification(schedule, tolerance)))
    )


class Cone:
    """Lower surface that rises with a slope."""

    def __init__(self, slope):
        self.slope = slope

    def heights(self, shape, spacing, origin):
        x, y = (o + spacing * np.arange(n) for o, n in zip(origin, shape, strict=True))
        return self.slope * np.hypot(x[:, None], y)


def ting_force(time, half, rate, factor, power, creep):
    """Return the force of an indenter that moves down and up at a rate (Ting 1966).

    On an elastic solid of unit modulus it is ``factor depth**power``.
    """
    turned = min(time, half)
    if time > half:

        def unbalanced(t1):
            down = quad(lambda s: creep.relaxation(time - s), t1, half)[0]
            return down - quad(lambda s: creep.relaxation(time - s), half, time)[0]

        if unbalanced(0.0) < 0.0:
            return 0.0
        turned = brentq(unbalanced, 0.0, half)
    memory, _ = quad(
        lambda s: creep.relaxation(time - s) * s ** (power - 1.0), 0.0, turned
    )
    return factor * power * rate**power * memory


def error_of_a_cycle(shape, n, duration, tolerance):
    """Return the largest relative error of the force of an approach and a retraction.

    The indenter has the same contact, relative to the window, on grids of all sizes.
    """
    indenter, factor, power = {
        # Hertz, with R = 640 on a grid of 64
        "sphere": (RoughSphere(n * n / 6.4), math.sqrt(n * n / 3.6), 1.5),
        # Sneddon, with the slope 0.05 on a grid of 64; the grid cuts off the apex
        "cone": (Cone(3.2 / n), n / (1.6 * math.pi), 2.0),
    }[shape]
    path = Schedule(0.0).ramp(-1.0, time=duration).ramp(0.0, time=duration)
    problem, options = problem_of(n, indenter=indenter), {"tolerance": tolerance}
    steps = follow(problem, n, path, "heights", window="unchecked", **options)
    law = 1.0 / duration, factor, power, CREEP
    expected = np.array([ting_force(s.time, duration, *law) for s in steps])
    found = np.array([s.normal_force for s in steps])
    assert all(s.converged for s in steps)
    return abs(found - expected).max() / expected.max()


@pytest.mark.parametrize(
    "duration", [0.05, 4.0, pytest.param(30.0, marks=pytest.mark.slow)]
)
@pytest.mark.parametrize(("shape", "error"), [("sphere", 1e-3), ("cone", 5e-3)])
def test_approach_and_retraction(shape, error, duration):
    assert error_of_a_cycle(shape, 64, duration, tolerance=1e-3) < error


@pytest.mark.slow
@pytest.mark.parametrize(("shape", "n"), [("sphere", 128), ("cone", 320)])
def test_approach_and_retraction_on_a_fine_grid(shape, n):
    assert error_of_a_cycle(shape, n, 4.0, tolerance=1e-4) < 1e-4


def test_contact_creeps_under_a_constant_load():
    n, creep = 96, Creep([1.5, 2.0], [0.3, 5.0])
    steps = follow(
        problem_of(n, creep=creep), n, Schedule(20.0).hold(30.0), control="loads"
    )
    times = np.array([s.time for s in steps])
    depth = np.array([s.penetration for s in steps])
    assert steps[0].time == 0.0
    # Hertz: the penetration to the power of 3/2 is proportional to the compliance
    growth = (depth / depth[0]) ** 1.5
    assert growth == pytest.approx(creep.compliance(times), rel=2e-3)


@pytest.mark.parametrize(("duration", "relaxed"), [(1e-9, 1.0), (1e9, 0.2)])
@pytest.mark.parametrize("wall", ["hard", "soft"])
def test_limits_of_fast_and_slow_rates_are_elastic(duration, relaxed, wall):
    n = 32
    wall = {"hard": HardWall(), "soft": LennardJones93.repulsive(1.0, 1.0)}[wall]
    options = {"accuracy": 1e-8}
    path = Schedule(0.0).ramp(0.5, time=duration)
    last = follow(problem_of(n, wall), n, path, **options)[-1]
    elastic = problem_of(n, wall, creep=Creep([1e-12], [1.0]), solid=relaxed)
    expected = follow(elastic, n, Schedule(0.0).step(0.5), **options)[-1]
    assert last.normal_force == pytest.approx(expected.normal_force, rel=1e-6)
    assert last.contact_area == expected.contact_area


@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("wall", ["hard", "plastic", "soft", "adhesive"])
@pytest.mark.parametrize("creep", ["three terms", "fluid"])
def test_gaps_agree_with_the_whole_history(creep, wall, periodic):
    """The integral over all pressures, with another formula than the time steps."""
    n = 24
    creep = {
        "three terms": Creep([0.5, 1.0, 2.0], [0.1, 1.0, 7.0]),
        "fluid": Creep([0.5], [0.3], flow=0.4),
    }[creep]
    wall = {
        "hard": HardWall(),
        "plastic": PlasticWall(0.15),
        "soft": LennardJones93.repulsive(1.0, 1.0),
        "adhesive": LennardJones93.adhesive(1.0, 1.0, 0.02),
    }[wall]
    rough = SelfAffine(0.1, 0.8, 4.0, 24.0, domain=24.0, seed=3)
    problem = problem_of(
        n,
        wall,
        creep,
        indenter=RoughSphere(200.0, rough) if not periodic else rough,
        periodic=periodic,
    )
    stepper = Stepper(
        problem,
        "penetrations",
        Box((-n // 2, -n // 2), (n, n)),
        StepOptions(window="unchecked", accuracy=1e-7),
    )
    path = Schedule(0.2).ramp(0.6, time=1.0).hold(0.5).ramp(-0.3, time=0.8)
    steps = list(paths.follow_states(TimeSteps(stepper, TimeSpecification(path, 1e-2))))
    times, heights = (
        np.array([getattr(step, name) for step, _ in steps])
        for name in ("time", "height")
    )
    fields = [left.fields for _, left in steps]
    pressures = np.array([each.pressure for each in fields])
    gaps = np.array([each.gap for each in fields])

    def integral(time):  # of the creep compliance from zero to a time
        parts = time + np.array(creep.times) * np.expm1(-time / np.array(creep.times))
        return time + parts @ np.array(creep.compliances) + 0.5 * creep.flow * time**2

    now = len(times) - 1
    effective = pressures[0] * creep.compliance(times[now] - times[0])
    for k in range(now):
        rate = (pressures[k + 1] - pressures[k]) / (times[k + 1] - times[k])
        effective = effective + rate * (
            integral(times[now] - times[k]) - integral(times[now] - times[k + 1])
        )
    displacement = problem.halfspace((n, n)).displacement(effective)
    box = Box((-n // 2, -n // 2), (n, n))
    gap = problem.heights(box) + heights[now] - displacement
    assert gaps[now] == pytest.approx(gap, abs=2e-6)


def test_automatic_windows_keep_the_past():
    n = 64
    path = Schedule(0.0).ramp(1.0, time=1.0).ramp(-0.5, time=0.5).ramp(0.5, time=5.0)
    fixed, automatic = (
        follow(problem_of(n, radius=300.0), n, path, window=window)
        for window in ("fixed", "auto")
    )
    forces = [[s.normal_force for s in steps] for steps in (fixed, automatic)]
    assert forces[1] == pytest.approx(forces[0], abs=1e-3 * max(forces[0]))
    assert {s.window for s in automatic} != {s.window for s in fixed}


ADHESIVE = LennardJones93.adhesive(1.0, 1.0, 0.02)


def energies(steps):
    """Return work on the indenter, and dissipated and lost energy of each step."""
    work = [
        0.5 * (a.normal_force + b.normal_force) * (a.height - b.height)
        for a, b in itertools.pairwise(steps)
    ]
    columns = ("dissipated_energy", "lost_energy")
    others = ([getattr(s, name) for s in steps[1:]] for name in columns)
    return np.array(work), *map(np.array, others)


@pytest.mark.parametrize(
    "duration",
    [
        *(0.01, 1.0),
        *(
            pytest.param(time, marks=pytest.mark.slow)
            for time in (0.1, 10.0, 100.0, 1000.0)
        ),
    ],
)
@pytest.mark.parametrize("sphere", ["smooth", "rough"])
def test_work_is_stored_dissipated_or_lost(sphere, duration):
    rough = SelfAffine(0.1, 0.8, 4.0, 32.0, domain=32.0, seed=2)
    indenter = RoughSphere(40.0, rough if sphere == "rough" else None)
    problem = problem_of(32, ADHESIVE, indenter=indenter)
    path = Schedule(-1.5).ramp(0.4, time=duration).ramp(-4.0, time=2.0 * duration)
    steps = follow(problem, 32, path, window="auto")
    work, dissipated, lost = energies(steps)
    stored = steps[-1].energy - steps[0].energy
    exchanged = abs(work).sum() + dissipated.sum()
    left = work.sum() - stored - dissipated.sum() - lost.sum()
    assert left == pytest.approx(0.0, abs=1e-3 * exchanged)


def test_jumps_at_the_instantaneous_modulus_are_reported():
    path = Schedule(-1.0).ramp(0.8, time=0.5).hold(0.5).ramp(-4.0, time=1.0)
    steps = follow(problem_of(48, ADHESIVE, radius=80.0), 48, path)
    _, dissipated, lost = energies(steps)
    assert np.count_nonzero(lost) == 2  # into contact, and out of it
    assert lost.sum() > 0.1 * dissipated.sum()


@pytest.mark.slow
def test_a_slow_loop_agrees_with_the_relaxed_solid():
    forces, losses = [], []
    for creep, modulus, time in ((CREEP, 1.0, 1e5), (Creep([1e-12], [1.0]), 0.2, 1.0)):
        problem = problem_of(32, ADHESIVE, creep, radius=20.0, solid=modulus)
        path = Schedule(-1.5).ramp(0.2, time=time).ramp(-2.0, time=time)
        steps = follow(problem, 32, path)
        _, dissipated, lost = energies(steps)
        losses.append((dissipated.sum(), lost.sum()))
        forces.append(min(s.normal_force for s in steps))
    (creeping, sudden), (_, elastic) = losses
    assert creeping > 0.5 * elastic  # jumps are motions of the solid
    assert creeping + sudden == pytest.approx(elastic, rel=0.01)
    assert forces[0] == pytest.approx(forces[1], rel=5e-3)


class Flat:
    """Flat surface."""

    def heights(self, shape, spacing, origin):
        return np.zeros(shape)


def test_steps_on_a_fluid_are_as_short_as_the_tolerance_requires():
    # flat punch on a solid with J = 1 + flow t, under ramps and holds
    n, rise, flow, tolerance = 8, 0.01, 10.0, 1e-4
    problem = problem_of(n, creep=Creep((), (), flow), indenter=Flat())
    schedule = Schedule(0.0).ramp(rise, time=1.0).hold(1.0).ramp(2.0 * rise, time=1.0)
    path = {"tolerance": tolerance, "window": "unchecked"}
    steps = follow(problem, n, schedule, **path)
    time, force = np.transpose([(s.time, s.normal_force) for s in steps])
    expected = np.zeros(len(steps))
    for begin in (0.0, 2.0):
        rising, after = (
            np.clip(time - begin, 0.0, 1.0),
            np.maximum(time - begin - 1, 0.0),
        )
        expected += (1.0 - np.exp(-flow * rising)) * np.exp(-flow * after) / flow
    (elastic,) = follow(problem, n, Schedule(rise), window="unchecked")
    error = abs(force / elastic.normal_force - expected).max() / expected.max()
    assert error < 3.0 * tolerance


def test_a_plastic_shape_is_kept_while_the_solid_has_no_time_to_creep():
    # as on the elastic solid; without the shape the unloaded contact is much larger
    n, depths, wall = 32, (0.5, 0.15, 0.5), PlasticWall(0.015, permanent=True)
    schedule = Schedule(0.0)
    for depth in depths:
        schedule = schedule.ramp(depth, time=1.0)
    slow = Creep.standard_solid(relaxed=0.5, time=1e6)
    steps = follow(problem_of(n, wall, slow), n, schedule, window="unchecked")
    elastic = stepper_of(problem_of(n, wall, None), n, window="unchecked")
    expected_steps = paths.follow(NumberedSteps(elastic, np.array(depths)))
    for number, expected in enumerate(expected_steps):
        assert expected.plastic_atoms > 0 or number == 1
        step = min(steps, key=lambda step: abs(step.time - (number + 1.0)))
        assert step.normal_force == pytest.approx(expected.normal_force, rel=1e-3)


def test_error_decreases_with_the_tolerance():
    n = 32
    depth = (0.4 * n) ** 2 / (10.0 * n)
    path = Schedule(0.0).ramp(depth, time=20.0).ramp(0.0, time=20.0)
    reference = follow(problem_of(n), n, path, tolerance=1e-5)
    known = {s.time: s.normal_force for s in reference}

    def error(tolerance):
        steps = follow(problem_of(n), n, path, tolerance=tolerance)
        same = [(s.normal_force, known[s.time]) for s in steps if s.time in known]
        assert len(same) > 10
        return max(abs(a - b) for a, b in same) / max(known.values())

    errors = [error(tolerance) for tolerance in (1e-2, 1e-4)]
    assert errors[0] < 1e-2
    assert errors[1] < 0.25 * errors[0]


@pytest.mark.parametrize("window", ["fixed", "auto"])
def test_base_of_a_cantilever_over_a_hard_wall(window):
    n, radius, stiffness, base = 48, 480.0, 20.0, -0.8
    path = Schedule(0.5).step(base).hold(100.0).ramp(0.5, time=1.0)
    problem = problem_of(n, radius=radius)
    held = {"cantilever": stiffness, "window": window}
    steps = follow(problem, n, path, "bases", **held)
    bases = np.array([path.at(step.time) for step in steps])
    forces = np.array([step.normal_force for step in steps])
    deflections = np.array([step.height for step in steps]) - bases
    assert all(step.converged for step in steps)
    assert forces[1:] == pytest.approx(stiffness * deflections[1:], abs=1e-9)
    assert forces[0] == forces[-1] == 0.0
    assert deflections[-1] == pytest.approx(0.0, abs=1e-12)

    def hertz(modulus):
        def excess(depth):
            force = 4.0 / 3.0 * modulus * math.sqrt(radius * depth**3)
            return force + stiffness * (base + depth)

        return -stiffness * (base + brentq(excess, 0.0, -base))

    held = [s.normal_force for s in steps if 0.0 < s.time <= 100.0]
    assert forces[1] == pytest.approx(hertz(1.0), rel=3e-3)
    assert held[-1] == pytest.approx(hertz(CREEP.relaxed), rel=3e-3)


def test_layer_on_a_rigid_base_creeps():
    creep = Creep([1.0], [1.0])
    problem = problem_of(48, creep=creep, solid=Layer(1.0, 3.0, poisson=0.3))
    steps = follow(problem, 48, Schedule(0.0).step(0.5).hold(50.0))
    assert steps[-1].normal_force == pytest.approx(
        0.5 * steps[1].normal_force, rel=1e-3
    )


def test_a_path_without_time_says_what_is_needed():
    stepper = stepper_of(problem_of(16), 16)
    with pytest.raises(ValueError, match="use time_path"):
        stepper.relax(stepper.start, 0.1)


def test_an_elastic_solid_says_what_is_needed():
    stepper = stepper_of(problem_of(16, creep=None), 16)
    with pytest.raises(ValueError, match="Viscoelastic"):
        TimeSteps(stepper, TimeSpecification(Schedule(0.0).hold(1.0)))


@pytest.mark.parametrize("relaxed", [0.2, 0.001])
def test_steps_of_a_long_hold_converge(relaxed):
    creep = Creep.standard_solid(relaxed, 1.0)
    path = Schedule(0.0).step(1.0).hold(60.0 / relaxed)
    steps = follow(problem_of(64, creep=creep), 64, path, window="auto")
    assert [s.message for s in steps if not s.converged] == []


def test_the_past_of_another_series_is_refused():
    stepper = stepper_of(problem_of(32), 32)
    path = TimeSteps(stepper, TimeSpecification(Schedule(0.0).ramp(0.5, time=1.0)))
    *_, (_, left) = paths.follow_states(path)
    other = stepper_of(problem_of(32, creep=Creep([1.0, 1.0], [1.0, 2.0])), 32)
    with pytest.raises(
        ValueError, match=r"has crept in a solid with Creep\(comp.* but"
    ):
        held = TimeSteps(other, TimeSpecification(Schedule(0.5).hold(1.0)))
        list(paths.follow_states(held, first=lambda: left.state))


@pytest.mark.parametrize("window", ["fixed", "auto"])
@pytest.mark.parametrize("sudden", [False, True])
def test_a_path_ends_where_the_contact_is_lost_under_a_tension(window, sudden):
    wall = LennardJones93.adhesive(1.0, 1.0, 0.05)
    stepper = stepper_of(problem_of(32, wall, radius=20.0), 32, "loads", window=window)
    path = Schedule(1.0)
    path = path.step(-50.0) if sudden else path.ramp(-50.0, time=50.0)
    steps = []
    with pytest.raises(RuntimeError, match="lost at the time"):
        for step in paths.follow(
            TimeSteps(stepper, TimeSpecification(path.hold(1.0), 0.1))
        ):
            steps.append(step)
    assert all(step.converged for step in steps)
    # between JKR and the work of adhesion on the glassy solid with a larger contact
    assert sudden or -50.0 < steps[-1].normal_force < -1.5 * math.pi * 20.0 * 0.05
