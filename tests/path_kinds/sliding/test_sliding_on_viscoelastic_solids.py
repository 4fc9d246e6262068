"""Sliding in time on viscoelastic solids: pressures and tractions creep."""

import numpy as np
import pytest
from sliding_contacts import atoms_on, stepper_of

from ase_roughcontact import (
    Creep,
    RateAndState,
    Schedule,
    Tresca,
    Viscoelastic,
    restore,
    sliding_path,
    snapshot,
    stick,
)
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.path_kinds.sliding.timed_specification import (
    TimedSlidingSpecification,
)
from ase_roughcontact.path_kinds.sliding.timed_steps import TimedSlidingSteps
from ase_roughcontact.paths import follow as paths
from ase_roughcontact.scene import Scene

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")

SOLID, SOFTER = Isotropic(1.0, 0.3), 3.0
LAW = RateAndState(0.3, 0.01, 0.015, 0.5, 1.0)
LOAD = 0.05


def creeping(time):
    return Viscoelastic(SOLID, Creep((SOFTER - 1.0,), (time,)))


def slide(solid, schedule, law=LAW, tolerance=1e-3, **options):
    steps = TimedSlidingSteps(
        stepper_of(8, solid=solid, control="loads"),
        TimedSlidingSpecification(LOAD, law, schedule, tolerance=tolerance, **options),
    )
    return [step for step, _ in paths.follow_states(steps)]


@pytest.mark.parametrize(
    ("time", "limit"), [(1e6, SOLID), (1e-6, Isotropic(1.0 / SOFTER, 0.3))]
)
def test_slow_and_fast_creep_are_the_instantaneous_and_the_relaxed_solid(time, limit):
    schedule = Schedule(0.0).ramp(0.03, rate=1.0)
    options = {"tolerance": 1e-2, "control": "bases", "spring": 1.0}
    found = slide(creeping(time), schedule, **options)[-1]
    expected = slide(limit, schedule, **options)[-1]
    assert found.contact_area == expected.contact_area
    for name in "lateral_force_x", "slip_rate", "lateral_energy":
        value = getattr(expected, name)
        assert getattr(found, name) == pytest.approx(value, rel=5e-3), name


def test_work_is_stored_or_lost_by_slip_and_creep():
    schedule = Schedule(0.0).ramp(0.05, rate=0.05)
    (*_, last) = slide(creeping(0.3), schedule, tolerance=5e-3)
    used = last.lateral_energy + last.dissipated_energy + last.creep_loss
    assert used == pytest.approx(last.work, rel=2e-3)
    assert last.creep_loss > 0.02 * last.work


class Strength(RateAndState):
    """Friction of a shear strength, whatever the pressure."""

    strength = 0.05

    def bound(self, pressure, *others):
        return super().bound(self.strength * (np.asarray(pressure) > 0.0), *others)

    def slip_rate(self, traction, pressure, history):
        strength = np.full(np.shape(pressure), self.strength)
        return super().slip_rate(traction, strength, history)


@pytest.mark.parametrize(
    "law", [Strength, pytest.param(RateAndState, marks=pytest.mark.slow)]
)
def test_creep_in_a_hold_lets_friction_grow_with_area_not_at_a_given_load(law):
    law = law(1.0, 1e-3, 0.0, 0.5, 1.0)
    schedule = Schedule(0.0).ramp(0.4, rate=100.0).hold(10.0).ramp(0.8, rate=100.0)
    steps = slide(creeping(1.0), schedule, law, 0.03)
    (before,) = (step for step in steps if step.time == 0.004)
    after = steps[-1]
    assert after.contact_area > 1.2 * before.contact_area
    grown = after.contact_area / before.contact_area
    expected = grown if isinstance(law, Strength) else 1.0
    ratio = after.lateral_force_x / before.lateral_force_x
    assert ratio == pytest.approx(expected, rel=5e-3)


def test_atoms_that_have_slid_go_on_but_do_not_stick():
    solid = creeping(1.0)
    atoms = atoms_on(solid)
    options = {"tolerance": 0.02}
    first = Schedule(0.0).ramp(0.02, time=1.0)
    (*_, before) = sliding_path(
        atoms, LAW, penetrations=0.5, displacements=first, **options
    )
    second = Schedule(0.02).ramp(0.03, time=1.0)
    again, *_ = sliding_path(
        atoms, LAW, penetrations=0.5, displacements=second, **options
    )
    assert again.lateral_force_x == pytest.approx(before.lateral_force_x, rel=1e-4)
    whole = restore(snapshot(atoms), solid)
    whole.calc = atoms.calc
    with pytest.raises(ValueError, match="viscoelastic"):
        stick(whole, Tresca(0.01))


def test_a_scene_slides_on_a_viscoelastic_solid():
    scene = Scene.parse(
        """
        path = { kind = "sliding-in-time", values = [5.0], displacements = [0, 1.0], \
rate = 1.0, tolerance = 0.02 }
        sphere = { radius = "5 nm" }
        interaction = { kind = "hard" }
        [substrate]
        contact_modulus = 50.0
        poisson = 0.5
        spacing = 2.5
        hardness = inf
        relaxation_moduli = [0.5]
        relaxation_times = [0.1]
        [friction]
        kind = "rate-and-state"
        coefficient = 0.4
        direct_effect = 0.01
        evolution_effect = 0.02
        distance = "0.2 nm"
        velocity = "1 nm/s"
        """
    )
    steps = list(scene.relax())
    assert steps[-1].contact_area > 1.2 * steps[0].contact_area
    assert steps[-1].creep_loss > 0.0
