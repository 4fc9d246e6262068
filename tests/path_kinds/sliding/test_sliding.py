"""Sliding paths, against exact results of contacts with friction."""

from itertools import pairwise

import numpy as np
import pytest
from sliding_contacts import (
    MU,
    assert_resumed,
    atoms_on,
    follow,
    followed,
    stepper_of,
)

from ase_roughcontact import (
    Coulomb,
    DugdaleWall,
    FrictionLaw,
    HardWall,
    LennardJones93,
    LoadStep,
    Output,
    PlasticWall,
    RoughSphere,
    SelfAffine,
    SlidingStep,
    Tresca,
    load_path,
    sliding_path,
)
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.path_kinds.sliding.specification import SlidingSpecification
from ase_roughcontact.path_kinds.sliding.steps import SlidingSteps
from ase_roughcontact.paths import follow as paths
from ase_roughcontact.paths.path_steps import NumberedSteps

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")


def tractions(state):
    history = state.history
    return np.stack([history["traction_x"], history["traction_y"]])


def penetration(stepper, load):
    return LoadStep.of(stepper.relax(stepper.start, load)).penetration


def test_displacement_and_stick_radius_agree_with_cattaneo_and_mindlin():
    n, depth = 128, 12.0 / 4.0
    exact = {"accuracy": 1e-6}
    (first,) = follow(stepper_of(n, **exact), depth, Coulomb(MU), [0.0])
    full, a = MU * first.normal_force, np.sqrt(10.0 * n * depth)
    forces = full * np.array([0.0, 0.3, 0.6, 0.9])
    for step in follow(stepper_of(n, **exact), depth, Coulomb(MU), forces, "forces"):
        left = 1.0 - step.lateral_force_x / full
        # the shear modulus is E*/2 for a Poisson's ratio of zero
        expected = 3.0 * full * 2.0 / (8.0 * a) * (1.0 - left ** (2.0 / 3.0))
        assert step.converged
        assert step.lateral_x == pytest.approx(expected, rel=2e-4)
        radius = np.sqrt(step.stick_area / np.pi)
        assert radius == pytest.approx(a * left ** (1.0 / 3.0), abs=0.5)


def test_displacements_agree_with_two_normal_contacts():
    # Ciavarella and Jaeger for Poisson's ratio zero, whatever the grid
    n, loads = 32, np.array([10.0, 4.0])
    deep, shallow = (
        penetration(stepper_of(n, control="loads", accuracy=1e-6), load)
        for load in loads
    )
    stepper = stepper_of(n, control="loads", accuracy=1e-6)
    forces = [0.0, MU * (loads[0] - loads[1])]
    last = follow(stepper, loads[0], Coulomb(MU), forces, "forces")[-1]
    assert last.lateral_x == pytest.approx(MU * (deep - shallow), rel=1e-5)


@pytest.mark.parametrize("start", [0.0, 70.0])
def test_slip_that_is_large_against_the_contact_is_a_limit(start):
    # counted from where the indenter came down
    stick, slid = follow(stepper_of(32), 0.5, Coulomb(MU), [start, start + 50.0])
    assert "slip/shortest wavelength" not in stick.validity
    assert "slip/shortest wavelength = 3.9" in slid.validity


@pytest.mark.parametrize("seed", range(5))
def test_tractions_of_rough_contacts_agree_with_ciavarella_and_jaeger(seed):
    n = 48
    rough = SelfAffine(0.1, 0.8, 4.0, 24.0, domain=48.0, seed=seed)
    loads, sphere = np.array([3.0, 9.0]), RoughSphere(10.0 * n, rough)
    normal = stepper_of(n, control="loads", indenter=sphere, accuracy=1e-6)
    path = paths.follow_states(NumberedSteps(normal, loads))
    pressures = [left.fields.pressure for _, left in path]
    stepper = stepper_of(n, control="loads", indenter=sphere, accuracy=1e-6)
    force = MU * (loads[1] - loads[0])
    path = followed(stepper, loads[1], Coulomb(MU), [0.0, force], "forces")
    _, (last, left) = path
    expected = MU * (pressures[1] - pressures[0])
    found = tractions(left.state)
    assert last.converged
    assert found[0] == pytest.approx(expected, abs=1e-3 * expected.max())
    assert abs(found[1]).max() < 1e-6 * expected.max()


@pytest.mark.parametrize("poisson", [0.0, 0.3, 0.5])
def test_ratio_of_lateral_and_normal_stiffness(poisson):
    stepper = stepper_of(128, solid=Isotropic(1.0, poisson))
    path = SlidingSteps(stepper, SlidingSpecification(3.0, Coulomb(1e3), [0.0, 1e-3]))
    steps = list(paths.follow(path, Output(columns=["lateral_stiffness"])))
    lateral = steps[1].lateral_force_x / 1e-3
    ratio = 2.0 * (1.0 - poisson) / (2.0 - poisson)
    normal = 2.0 * np.sqrt(steps[1].contact_area / np.pi)  # 2 E* a
    assert lateral / normal == pytest.approx(ratio, rel=1e-2)
    assert steps[0].lateral_stiffness == pytest.approx(lateral, rel=1e-3)


def test_loops_lose_the_energy_of_mindlin_and_deresiewicz():
    n, depth, part = 64, 1.0, 0.7
    (first,) = follow(stepper_of(n), depth, Coulomb(MU), [0.0])
    full, a = MU * first.normal_force, np.sqrt(10.0 * n * depth)
    up = part * np.sin(np.linspace(0.0, 2.5 * np.pi, 41))
    steps = follow(stepper_of(n), depth, Coulomb(MU), full * up, "forces")
    lost = steps[40].dissipated_energy - steps[8].dissipated_energy
    # Johnson, Contact Mechanics (1985), Eq. (7.47), with G = E*/2 and nu = 0
    bracket = 1.0 - (1.0 - part) ** (5.0 / 3.0)
    bracket -= 5.0 * part / 6.0 * (1.0 + (1.0 - part) ** (2.0 / 3.0))
    expected = 9.0 * full**2 / (10.0 * a) * 2.0 * 2.0 * bracket
    assert lost == pytest.approx(expected, rel=1e-2)


def test_work_of_the_lateral_force_is_stored_or_dissipated():
    turn = np.concatenate([np.linspace(0.0, 0.8, 21), np.linspace(0.8, -0.5, 31)])
    path = np.stack([turn, 0.3 * turn**2], axis=1)
    steps = follow(stepper_of(48, solid=Isotropic(1.0, 0.3)), 1.0, Coulomb(MU), path)
    work = 0.0
    for a, b in pairwise(steps):
        x, y = b.lateral_x - a.lateral_x, b.lateral_y - a.lateral_y
        work += 0.5 * (a.lateral_force_x + b.lateral_force_x) * x
        work += 0.5 * (a.lateral_force_y + b.lateral_force_y) * y
    stored = steps[-1].lateral_energy
    assert work == pytest.approx(stored + steps[-1].dissipated_energy, rel=1e-2)


def test_sliding_of_tresca_is_the_strength_times_the_area():
    for wall in (HardWall(), LennardJones93.adhesive(1.0, 1.0, 0.02)):
        steps = follow(stepper_of(48, wall=wall), 1.0, Tresca(0.02), [0.0, 50.0])
        last = steps[-1]
        expected = 0.02 * last.contact_area
        assert last.lateral_force_x == pytest.approx(expected, rel=1e-6)


def test_atoms_under_tension_without_friction_neither_stick_nor_slip():
    stepper = stepper_of(32, wall=DugdaleWall(0.01, 1.0))
    done = followed(stepper, 0.5, Coulomb(MU), [0.0, 0.05, 5.0])
    steps, left = zip(*done, strict=True)
    pressed = np.count_nonzero(left[-1].state.pressure > 0.0)
    assert 0 < pressed < steps[0].contact_area
    for step in steps:
        assert step.stick_area + step.slip_area == pressed
    assert [step.slip_area for step in steps[::2]] == [0.0, pressed]
    assert steps[1].stick_area > 0.0
    assert steps[1].slip_area > 0.0


def test_shear_strength_limits_coulomb_friction_under_plastic_flow():
    law = Coulomb(MU, strength=0.003)
    stepper = stepper_of(48, wall=PlasticWall(0.015, permanent=True))
    last, left = followed(stepper, [0.5, 0.8, 0.8], law, [0.0, 0.5, 50.0])[-1]
    pressure = left.fields.pressure
    expected = np.minimum(MU * pressure, 0.003).sum()
    assert last.lateral_force_x == pytest.approx(expected, rel=1e-6)
    assert expected < 0.9 * MU * pressure.sum()
    assert last.plastic_atoms > 0


def test_a_law_of_ones_own_depends_on_the_position():
    class OneSided(FrictionLaw):
        def bound(self, pressure, x, y):
            return np.where(x > 0.0, 0.2 * pressure, 0.0)

    stepper = stepper_of(32)
    last = follow(stepper, 0.5, OneSided(), [0.0, 50.0])[-1]
    assert last.lateral_force_x == pytest.approx(0.1 * last.normal_force, rel=1e-6)


@pytest.mark.parametrize("wrong", [np.nan, np.ones(3)])
def test_bounds_of_a_law_that_are_no_numbers_are_refused(wrong):
    class Wrong(FrictionLaw):
        def bound(self, pressure, x, y):
            return wrong

    with pytest.raises(ValueError, match=r"Wrong.bound must return"):
        follow(stepper_of(32), 0.5, Wrong(), [0.0])


def test_a_spring_follows_its_base_until_the_contact_slides():
    bases = np.array([[0.0, 0.0], [0.1, 0.05], [400.0, 200.0]])
    stepper = stepper_of(48, solid=Isotropic(1.0, 0.3))
    steps = follow(stepper, 1.0, Coulomb(MU), bases, "bases", spring=5.0)
    for step, base in zip(steps, bases, strict=True):
        extension = base - [step.lateral_x, step.lateral_y]
        force = [step.lateral_force_x, step.lateral_force_y]
        assert step.converged
        assert force == pytest.approx(5.0 * extension, abs=1e-5)
    last = np.hypot(step.lateral_force_x, step.lateral_force_y)
    assert last == pytest.approx(MU * step.normal_force, rel=1e-4)


def test_a_force_that_friction_cannot_carry_is_not_converged():
    steps = follow(stepper_of(32), 0.5, Coulomb(MU), [0.0, 1e3], "forces")
    assert steps[0].converged
    assert not steps[1].converged
    assert "the contact slides" in steps[1].message
    # how far it slides is not known
    assert steps[1].lateral_x == steps[1].dissipated_energy == 0.0
    assert steps[1].slip_area == steps[1].contact_area


def test_forces_above_friction_say_what_it_does_not_carry():
    stepper = stepper_of(32)
    (first,) = follow(stepper, 0.5, Coulomb(MU), [0.0])
    most = MU * first.normal_force
    forces = np.outer([0.0, 0.7, -0.7, 1.1, 1.25, 1.25], [most, 0.75 * most])
    steps = follow(stepper_of(32), 0.5, Coulomb(MU), forces, "forces")
    for step, part in zip(steps[3:], (1.375, 1.5625, 1.5625), strict=True):
        lacking = f"does not carry {100.0 - 100.0 / part:.3g} %"
        assert "the contact slides" in step.message
        assert lacking in step.message
        assert step.stick_area == 0.0
        held = [step.lateral_force_x, step.lateral_force_y]
        assert held == pytest.approx([0.8 * most, 0.6 * most])


def test_nothing_carries_a_force_out_of_contact():
    steps = follow(stepper_of(32), [0.5, -1.0, 0.5], Coulomb(MU), [0, 1, 0], "forces")
    assert [step.converged for step in steps] == [True, False, True]
    assert "no atom in contact" in steps[1].message


def test_automatic_windows_keep_the_tractions():
    depths = np.array([0.2, 0.5, 1.0, 0.5, 0.1, -0.5, 0.2])
    path = np.array([0.0, 0.1, 0.2, 0.15, 0.05, 0.05, 0.1])
    fixed, automatic = (
        follow(stepper_of(64, window=window), depths, Coulomb(MU), path)
        for window in ("fixed", "auto")
    )
    forces = [[s.lateral_force_x for s in steps] for steps in (fixed, automatic)]
    assert forces[1] == pytest.approx(forces[0], abs=1e-4 * max(forces[0]))
    assert fixed[5].lateral_force_x == 0.0
    assert {s.window for s in automatic} != {s.window for s in fixed}


PATH = np.array([0.0, 0.2, 0.5, 0.3, -0.2, 0.1])
DEPTHS = np.array([1.0, 1.5, 2.0, 1.8, 1.0, 1.5])
SOLID = Isotropic(0.8, 0.3)


@pytest.mark.parametrize("keep", ["all", "last"])
@pytest.mark.parametrize(
    "lateral", [{"displacements": PATH}, {"bases": PATH, "spring": 3.0}]
)
def test_a_killed_path_is_resumed(tmp_path, lateral, keep):
    names = "lateral_force_x", "lateral_x", "dissipated_energy"
    assert_resumed(tmp_path, SOLID, DEPTHS, keep, names, **lateral)


def test_another_path_is_not_resumed(tmp_path):
    files = {"trajectory": tmp_path / "p.traj"}
    law, output = Coulomb(MU), Output(**files, resume=True)
    list(
        sliding_path(
            atoms_on(SOLID),
            law,
            penetrations=1.0,
            displacements=PATH,
            output=Output(**files),
        )
    )
    with pytest.raises(ValueError, match=r"displacements\[1\] was 0.2, 0, is 0.4"):
        other = {"displacements": 2.0 * PATH}
        list(
            sliding_path(atoms_on(SOLID), law, penetrations=1.0, **other, output=output)
        )
    with pytest.raises(ValueError, match="friction"):
        other = {"displacements": PATH}
        list(
            sliding_path(
                atoms_on(SOLID), Coulomb(0.4), penetrations=1.0, **other, output=output
            )
        )
    with pytest.raises(ValueError, match="lateral forces"):
        list(
            sliding_path(
                atoms_on(SOLID), law, penetrations=1.0, forces=PATH, output=output
            )
        )


def test_normal_results_are_those_without_friction():
    law = Coulomb(MU)
    sliding = list(
        sliding_path(atoms_on(SOLID), law, penetrations=DEPTHS, displacements=PATH)
    )
    normal = list(load_path(atoms_on(SOLID), penetrations=DEPTHS))
    found = [s.normal_force for s in sliding]
    assert found == pytest.approx([s.normal_force for s in normal], rel=1e-12)


def test_wrong_arguments_say_what_is_expected():
    law = Coulomb(MU)
    with pytest.raises(ValueError, match="exactly one of displacements, forces, bases"):
        sliding_path(atoms_on(SOLID), law, penetrations=1.0)
    with pytest.raises(ValueError, match="bases need a spring"):
        sliding_path(atoms_on(SOLID), law, penetrations=1.0, bases=PATH)
    with pytest.raises(ValueError, match="all 6 displacements"):
        sliding_path(atoms_on(SOLID), law, penetrations=[1.0, 2.0], displacements=PATH)
    with pytest.raises(NotImplementedError, match=r"Isotropic\(contact_modulus, pois"):
        sliding_path(
            atoms_on(Isotropic(0.8)), law, penetrations=1.0, displacements=PATH
        )

    with pytest.raises(TypeError, match=r"law such as Coulomb\(0.3\), got 0.3"):
        sliding_path(atoms_on(SOLID), 0.3, penetrations=1.0, displacements=PATH)

    class Wrong(LoadStep):
        pass

    with pytest.raises(TypeError, match="derive Wrong from SlidingStep"):
        output = Output(record=Wrong)
        sliding_path(
            atoms_on(SOLID), law, penetrations=1.0, displacements=PATH, output=output
        )
    assert issubclass(SlidingStep, LoadStep)
