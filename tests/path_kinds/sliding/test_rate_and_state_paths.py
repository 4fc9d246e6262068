"""Sliding in time with rate and state friction, from Python and from scenes."""

import math

import numpy as np
import pytest
from sliding_contacts import atoms_on, stepper_of

from ase_roughcontact import (
    Coulomb,
    Output,
    RateAndState,
    Schedule,
    sliding_path,
    stick,
)
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.interactions import STATE
from ase_roughcontact.loading.trajectory import read_frames
from ase_roughcontact.path_kinds.sliding.specification import SlidingSpecification
from ase_roughcontact.path_kinds.sliding.steps import SlidingSteps
from ase_roughcontact.path_kinds.sliding.timed_specification import (
    TimedSlidingSpecification,
)
from ase_roughcontact.path_kinds.sliding.timed_steps import TimedSlidingSteps
from ase_roughcontact.paths import follow as paths
from ase_roughcontact.scene import Scene

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")

SOLID = Isotropic(1.0, 0.3)
MU, A, B, LENGTH, RATE = 0.3, 0.01, 0.015, 0.5, 1.0
LAW = RateAndState(MU, A, B, LENGTH, RATE)


def in_time(schedule, law=LAW, *, target=0.3, tolerance=1e-3, n=8, **options):
    steps = TimedSlidingSteps(
        stepper_of(n, solid=SOLID),
        TimedSlidingSpecification(
            target, law, schedule, tolerance=tolerance, **options
        ),
    )
    return [step for step, _ in paths.follow_states(steps)]


def friction(step):
    return step.lateral_force_x / step.normal_force


def test_friction_follows_a_step_of_the_rate_to_its_steady_value():
    steps = in_time(Schedule(0.0).ramp(4.0, rate=RATE).ramp(9.0, rate=10.0))
    (before,) = (step for step in steps if step.time == 4.0)
    assert friction(before) == pytest.approx(MU, rel=1e-4)
    after = [friction(step) for step in steps if step.time > 4.0]
    # the direct effect, less the evolution during it
    assert 0.8 * A * math.log(10.0) < max(after) - MU < A * math.log(10.0)
    assert after[-1] == pytest.approx(MU + (A - B) * math.log(10.0), rel=1e-4)
    assert steps[-1].slip_rate == pytest.approx(10.0, rel=1e-4)
    assert steps[-1].friction_state == pytest.approx(-math.log(10.0), abs=1e-3)


def test_work_is_stored_or_lost():
    schedule = Schedule(0.0).ramp(3.0, rate=RATE)
    options = {"control": "bases", "spring": 0.5, "tolerance": 1e-4}
    for step in in_time(schedule, **options)[1:]:
        used = step.lateral_energy + step.spring_energy + step.dissipated_energy
        assert used == pytest.approx(step.work, rel=3e-3)
        force = 0.5 * (step.base_x - step.lateral_x)
        assert step.lateral_force_x == pytest.approx(force, rel=1e-4)
    assert used == pytest.approx(step.work, rel=1e-4)


@pytest.mark.slow
def test_static_friction_grows_with_the_logarithm_of_the_hold_time():
    law = RateAndState(MU, A, B, 4.0, RATE)
    peaks = []
    for hold in 400.0, 4000.0:
        slide = Schedule(0.0).ramp(20.0, rate=RATE)
        steps = in_time(slide.hold(hold).ramp(24.0, rate=RATE), law)
        peaks.append(max(friction(step) for step in steps if step.time > 20.0 + hold))
    # less the state that is lost until the peak
    assert peaks[0] - MU == pytest.approx(B * math.log(101.0), rel=0.1)
    assert peaks[1] - peaks[0] == pytest.approx(B * math.log(10.0), rel=0.03)


def test_a_step_takes_about_twice_the_fft_pairs_of_coulomb_friction():
    timed = in_time(Schedule(0.0).ramp(0.2, rate=RATE), tolerance=0.02)[1:]
    moved = [0.0, *(step.lateral_x for step in timed)]
    given = SlidingSpecification(0.3, Coulomb(MU), moved)
    same = SlidingSteps(stepper_of(8, solid=SOLID), given)
    _, *steps = (step for step, _ in paths.follow_states(same))
    pairs, expected = (
        sum(step.friction_pairs for step in path) for path in (timed, steps)
    )
    assert pairs < 2 * 2 * expected


def test_a_contact_ages_before_it_slides():
    steps = in_time(Schedule(0.0).hold(100.0).ramp(0.3, rate=RATE))
    (rested,) = (step for step in steps if step.time == 100.0)
    assert rested.friction_state == pytest.approx(math.log(1.0 + 100.0 * RATE / LENGTH))
    assert max(friction(step) for step in steps) > MU + 0.8 * B * rested.friction_state


def test_without_contact_rate_and_state_are_not_known():
    schedule = Schedule(0.0).ramp(0.1, rate=RATE)
    last = in_time(schedule, target=-1.0)[-1]
    assert last.converged
    assert math.isnan(last.slip_rate)
    assert math.isnan(last.friction_state)
    with pytest.raises(ValueError, match="no atom in contact"):
        in_time(schedule, target=-1.0, control="forces")


def test_nothing_sticks_by_definition():
    for step in in_time(Schedule(0.0).ramp(0.1, rate=RATE)):
        assert math.isnan(step.stick_area)
        assert step.slip_area > 0.0


@pytest.mark.slow
def test_unstable_slip_without_damping_ends_the_path_with_its_reason():
    law = RateAndState(MU, A, 0.05, LENGTH, RATE)
    options = {"control": "bases", "spring": 0.02, "tolerance": 0.02}
    with pytest.raises(RuntimeError, match="give damping"):
        in_time(Schedule(0.0).ramp(80.0, rate=RATE), law, **options)


def test_damping_lets_unstable_slip_go_on():
    law = RateAndState(MU, A, 0.05, LENGTH, RATE, damping=1e-3)
    options = {"control": "bases", "spring": 0.02, "tolerance": 0.02}
    steps = in_time(Schedule(0.0).ramp(52.0, rate=RATE), law, **options)
    assert max(step.slip_rate for step in steps) > 5.0 * RATE
    assert steps[-1].time == pytest.approx(52.0)
    assert all(step.converged for step in steps)


def test_a_force_begins_at_the_force_of_the_contact():
    with pytest.raises(ValueError, match="must begin at the lateral force"):
        in_time(Schedule(0.1).ramp(0.2, rate=1.0), control="forces")
    steps = in_time(Schedule(0.0).ramp(0.05, rate=0.1), control="forces")
    assert steps[-1].lateral_force_x == pytest.approx(0.05, rel=1e-5)


def test_frames_have_state_and_slip_rates(tmp_path):
    file = tmp_path / "p.traj"
    atoms, output = atoms_on(SOLID), Output(trajectory=file)
    schedule = Schedule(0.0).ramp(0.2, rate=RATE)
    (*_, last) = sliding_path(
        atoms,
        LAW,
        penetrations=0.5,
        displacements=schedule,
        tolerance=0.02,
        output=output,
    )
    (*_, frame) = read_frames(file)
    lateral = ContactMap.from_frame(frame).lateral
    slips = lateral["traction_x"] > 0.0
    rates = np.hypot(lateral["slip_rate_x"], lateral["slip_rate_y"])
    assert rates[slips].mean() == pytest.approx(last.slip_rate, rel=1e-4)
    assert lateral[STATE.name][slips].mean() == pytest.approx(
        last.friction_state, rel=1e-4
    )
    assert not lateral[STATE.name][~slips].any()


def test_without_a_schedule_rate_and_state_friction_is_refused():
    atoms = atoms_on(SOLID)
    with pytest.raises(ValueError, match="Schedule"):
        sliding_path(atoms, LAW, penetrations=0.5, displacements=[0.0, 1.0])
    with pytest.raises(ValueError, match="Schedule"):
        stick(atoms, LAW)
    with pytest.raises(TypeError, match="RateAndState"):
        sliding_path(
            atoms, Coulomb(0.3), penetrations=0.5, displacements=Schedule(0.0).hold(1.0)
        )


def test_a_sudden_change_is_refused():
    with pytest.raises(ValueError, match="in a time"):
        in_time(Schedule(0.0).step(1.0))


SCENE = """
substrate = { contact_modulus = 50.0, poisson = 0.5, spacing = 2.5, hardness = inf }
sphere = { radius = "5 nm" }
interaction = { kind = "hard" }
path = { kind = "sliding-in-time", values = ["5 nN"], displacements = [0, "0.1 nm"] }
[friction]
kind = "rate-and-state"
coefficient = 0.4
direct_effect = 0.01
evolution_effect = 0.02
distance = "0.2 nm"
velocity = "1 nm/s"
"""


def scene(**values):
    return Scene.parse(SCENE).with_values(values)


def test_a_scene_slides_in_time():
    moving = scene(**{"path.rate": "1 nm/s", "path.tolerance": 0.01})
    steps = list(moving.relax())
    assert steps[-1].time == pytest.approx(0.1)
    assert steps[-1].lateral_x == pytest.approx(1.0)
    assert 0.0 < friction(steps[-1]) < 0.5
    planned = moving.path.expected_count(moving.bodies)
    assert planned == pytest.approx(len(steps), rel=0.5)


def test_times_of_a_scene_may_hold():
    held = scene(
        **{"path.displacements": (0, "1 nm", "1 nm"), "path.times": (0, 1.0, "1 min")}
    )
    found = held.path.lateral_schedule(held.bodies)
    assert found.duration == pytest.approx(60.0)
    assert found.at(0.5) == pytest.approx(5.0)
    assert found.at(30.0) == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("values", "advice"),
    [
        ({"path.rate": "1 nm/s", "friction.coupling": "solved"}, "leave out coupling"),
        ({"path.rate": "1 nm/s", "path.values": ("5 nN", "6 nN")}, "one of loads"),
        ({}, "either times"),
        ({"path.displacements": (0, 1, 1), "path.rate": "1 nm/s"}, "needs times"),
        ({"path.kind": "sliding"}, "sliding-in-time"),
    ],
)
def test_what_a_scene_in_time_cannot_do_is_refused(values, advice):
    with pytest.raises(ValueError, match=advice):
        scene(**values).check()
