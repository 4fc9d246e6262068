"""Paths with friction that weakens by slip, and laws with histories of one's own."""

import math
from unittest.mock import patch

import numpy as np
import pytest
from sliding_contacts import atoms_on, follow, followed, stepper_of

from ase_roughcontact import (
    Coulomb,
    FrictionLaw,
    Output,
    SlipWeakening,
    Tresca,
    sliding_path,
    stick,
)
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.atoms.sticking import SlipError
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.interactions import LAWS, SLIP, HistoryEntry
from ase_roughcontact.loading.trajectory import read_frames
from ase_roughcontact.scene import Scene

LAW = SlipWeakening(Coulomb(0.5), 0.4, 0.2)
SOLID = Isotropic(1.0, 0.3)
# Base of a soft spring at which the contact slides, and bases around it.
BASES = [0.0, 4.0, 5.0]


def pulled(**options):
    return follow(
        stepper_of(12, solid=SOLID), 0.5, LAW, BASES, "bases", spring=0.5, **options
    )


@pytest.mark.parametrize("count", [5, 40])
def test_friction_falls_from_its_peak_to_the_residual_in_any_steps(count):
    path = np.linspace(0.0, 1.0, count + 1)
    steps = follow(stepper_of(24), 0.5, LAW, path)
    load = steps[0].normal_force
    assert steps[0].largest_friction == pytest.approx(0.5 * load, rel=1e-9)
    assert steps[-1].lateral_force_x == pytest.approx(0.2 * load, rel=1e-6)
    assert max(step.lateral_force_x for step in steps) > 0.3 * load
    # all atoms slip: as far as the indenter, less the displacement of the surface
    slips = steps[-1].largest_slip - steps[-2].largest_slip
    assert slips == pytest.approx(1.0 / count)


def test_exponential_weakening_has_the_bound_of_its_slip():
    law = SlipWeakening(Tresca(2.0), 0.25, 0.5, exponential=True)
    slip = np.array([0.0, 0.5, 1.0])
    found = law.bound(np.ones(3), slip, slip, math.nan, {}, slip, slip)
    assert found == pytest.approx(2.0 * (0.25 + 0.75 * np.exp(-2.0 * slip)))


def test_a_soft_spring_pulls_through_an_instability_to_the_next_equilibrium():
    steps = pulled()
    (jump,) = (step for step in steps if step.instabilities)
    assert jump.instabilities == 1
    before = steps[jump.step - 1]
    assert before.released_energy == 0.0 < jump.released_energy
    assert jump.converged
    for step in steps:
        force = 0.5 * (step.base_x - step.lateral_x)
        assert step.lateral_force_x == pytest.approx(force, rel=1e-6, abs=1e-9)
    assert jump.lateral_force_x < before.lateral_force_x


@pytest.mark.slow
def test_energies_of_a_path_with_an_instability_close():
    bases = [*np.linspace(0.0, 4.4, 8), 4.45, 4.5, 4.55, 4.6, 6.0]
    steps = follow(stepper_of(12, solid=SOLID), 0.5, LAW, bases, "bases", spring=0.5)
    forces = [step.lateral_force_x for step in steps]
    work = np.trapezoid(forces, bases)
    last = steps[-1]
    stored = last.lateral_energy + 0.5 * forces[-1] ** 2 / 0.5
    used = stored + last.dissipated_energy + last.released_energy
    assert last.released_energy > 0.05 * work
    assert used == pytest.approx(work, rel=0.01)


def test_partial_slip_that_weakens_costs_at_most_twice_coulomb_friction():
    def pairs(law):
        steps = follow(stepper_of(24), 0.5, law, [0.0, 0.05, 0.1, 0.15])
        assert all(step.converged for step in steps)
        return sum(step.friction_pairs for step in steps)

    coulomb = pairs(Coulomb(0.5))
    assert pairs(SlipWeakening(Coulomb(0.5), 0.4, 1.0)) < 2.0 * coulomb
    assert pairs(SlipWeakening(Coulomb(0.5), 0.4, 1.0, True)) < 2.0 * coulomb


def test_a_force_above_the_weakened_friction_has_no_further_equilibrium():
    load = follow(stepper_of(24), 0.5, LAW, [0.0])[0].normal_force
    forces = np.array([0.0, 0.35, 0.45]) * load
    steps = follow(stepper_of(24), 0.5, LAW, forces, "forces")
    assert steps[1].converged
    assert not steps[2].converged
    assert "no further equilibrium" in steps[2].message
    # what is known before the instability
    assert steps[2].lateral_x > steps[1].lateral_x


def test_slip_is_added_up_there_and_back_and_starts_anew_without_contact():
    stepper = stepper_of(24)
    path = [0.0, 0.5, 0.0, 0.5]
    found = followed(stepper, [0.5, 0.5, 0.5, 0.2], LAW, path)
    slips = [left.state.history[SLIP.name] for _, left in found]
    assert (slips[2] >= slips[1]).all()
    assert slips[2].max() > slips[1].max() + 0.2
    contact = found[-1][1].fields.contact
    assert slips[2][~contact].any()
    assert not slips[3][~contact].any()


@pytest.mark.parametrize("law", [LAW, Coulomb(0.5)])
def test_a_spring_pulls_an_indenter_without_contact_to_its_base(law):
    lifted = follow(stepper_of(8), [0.2, 0.2, -1.0], law, BASES, "bases", spring=0.5)
    assert lifted[2].converged
    assert lifted[2].lateral_x == pytest.approx(BASES[2])
    assert lifted[2].lateral_force_x == pytest.approx(0.0, abs=1e-9)


def test_coupled_motion_weakens_too():
    steps = follow(
        stepper_of(16, solid=SOLID), 0.5, LAW, [0.0, 0.5, 1.0], coupling="solved"
    )
    assert all(step.converged for step in steps)
    last = steps[-1]
    assert last.lateral_force_x == pytest.approx(0.2 * last.normal_force, rel=1e-4)


def test_frames_and_maps_have_the_slip(tmp_path):
    file = tmp_path / "p.traj"
    atoms, output = atoms_on(SOLID), Output(trajectory=file)
    path = [0.0, 0.4, 1.2]
    (*_, last) = sliding_path(
        atoms, LAW, penetrations=1.0, displacements=path, output=output
    )
    (*_, frame) = read_frames(file)
    found = ContactMap.from_frame(frame).lateral[SLIP.name]
    assert found.max() == pytest.approx(last.largest_slip, rel=1e-6)
    assert atoms.arrays[SLIP.name].max() == last.largest_slip


def test_atoms_that_stick_have_the_weakened_bound():
    atoms = atoms_on(SOLID)
    list(sliding_path(atoms, LAW, penetrations=1.0, displacements=[0.0, 2.0, 1.99]))
    slip = atoms.arrays[SLIP.name].copy()
    sticking = stick(atoms, LAW)
    assert (atoms.arrays[SLIP.name] == slip).all()
    with pytest.raises(SlipError):  # the bound without slip is 2.5 times as large
        sticking.move(atoms, (0.05, 0.0))
        atoms.get_forces()


TEXT = """
[substrate]
model = "atoms"
contact_modulus = 80.0
poisson = 0.3
spacing = 2.5
hardness = inf
[sphere]
radius = "20 nm"
[interaction]
kind = "hard"
[friction]
kind = "slip-weakening"
coefficient = 0.5
residual = 0.4
distance = "0.2 nm"
[path]
kind = "sliding"
values = [20.0]
displacements = [0, "4 Å"]
steps = 4
"""


def test_a_scene_names_slip_weakening_with_units():
    scene = Scene.parse(TEXT)
    law = scene.friction.law_on(scene.spacing)
    assert law == SlipWeakening(Coulomb(0.5), 0.4, 2.0)
    *_, last = scene.relax(validity="ignore")
    assert last.lateral_force_x == pytest.approx(0.2 * last.normal_force, rel=1e-4)


@pytest.mark.parametrize(
    "line, advice",
    [
        ('distance = "0.2 nm"', "needs distance"),
        ("coefficient = 0.5", "give coefficient, shear_strength, or both"),
    ],
)
def test_a_scene_without_a_key_says_which_one(line, advice):
    with pytest.raises(ValueError, match=advice):
        Scene.parse(TEXT.replace(line, "")).relax()


def test_the_plan_counts_the_slip_in_files():
    def plan(text):
        return Scene.parse(text).plan()

    coulomb = 'kind = "coulomb"\ncoefficient = 0.5\n'
    start, end = TEXT.index('kind = "slip'), TEXT.index("[path]")
    other = plan(TEXT[:start] + coulomb + TEXT[end:])
    found = plan(TEXT)
    assert found.fields_of_frame == other.fields_of_frame + 1
    assert found.fields_of_state == other.fields_of_state + 1


AGE = HistoryEntry("steps_in_contact", in_frames=True, start=5.0)


class Ageing(FrictionLaw):
    """Bound proportional to the number of steps since an atom came into contact."""

    histories = (AGE,)

    def bound(self, pressure, slip, rate, time, history, x, y):
        return 0.01 * history[AGE.name] * pressure

    def evolved(self, pressure, slip, rate, time, history, x, y):
        return {AGE.name: history[AGE.name] + 1.0}


def test_a_law_of_ones_own_keeps_its_history():
    found = followed(stepper_of(24), [0.2, 0.5, 0.2, 0.5], Ageing(), [0.0] * 4)
    ages = [left.state.history[AGE.name] for _, left in found]
    small, large = (found[k][1].fields.contact for k in (0, 1))
    assert set(ages[0][small]) == {6.0}  # from the start
    assert set(ages[3][small]) == {9.0}
    new = large & ~small  # free in between
    assert set(ages[1][new]) == {1.0}
    assert set(ages[2][new]) == {0.0}
    assert set(ages[3][new]) == {1.0}


def test_a_law_of_ones_own_with_history_works_in_scenes_by_name():
    Ageing.kind = "ageing-steps"
    text = TEXT[: TEXT.index("[friction]")] + '[friction]\nkind = "ageing-steps"\n'
    text += TEXT[TEXT.index("[path]") :]
    with patch.dict(LAWS, {"ageing-steps": Ageing}):
        *_, last = Scene.parse(text).relax(validity="ignore")
    # 5 at the start, one more after each of four steps
    assert last.largest_friction == pytest.approx(0.09 * last.normal_force, rel=1e-6)


def test_a_law_without_a_history_for_its_slip_is_told_to_declare_it():
    class Forgetful(FrictionLaw):
        def bound(self, pressure, slip, rate, time, history, x, y):
            return pressure * np.exp(-slip)

    with pytest.raises(ValueError, match=r"histories = \(SLIP,\)"):
        follow(stepper_of(16), 0.5, Forgetful(), [0.0])


def test_a_bound_with_other_arguments_is_refused_by_its_definition():
    with pytest.raises(TypeError, match="pressure, slip, rate, time, history, x, y"):

        class Hot(FrictionLaw):
            def bound(self, pressure, temperature):
                return pressure * temperature


def test_the_peak_of_slip_weakening_may_be_a_law_of_ones_own_without_memory():
    class Central(FrictionLaw):
        def bound(self, pressure, x, y):
            return np.where(np.hypot(x, y) < 1.0, pressure, 0.0)

    law = SlipWeakening(Central(), 0.5, 2.0)
    x, slip = np.array([0.0, 0.9, 2.0]), np.array([0.0, 1.0, 1.0])
    found = law.bound(np.ones(3), slip, slip, math.nan, {}, x, 0.0 * x)
    assert found == pytest.approx([1.0, 0.75, 0.0])
