"""Problem and State: contacts on windows of a lattice, as arrays without Atoms."""

import numpy as np
import pytest
from ase.constraints import Hookean
from ase.optimize import FIRE, LBFGS
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import problem_of
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.paths.follow import follow, follow_states
from ase_roughcontact.paths.path_steps import NumberedSteps

SPHERE = rc.RoughSphere(200.0, rc.SelfAffine(0.1, 0.8, 4.0, 32.0, seed=3, domain=128.0))
WALLS = {
    "hard": rc.HardWall(),
    "repulsive": rc.LennardJones93.repulsive(1.0, 1.0),
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.02),
    "dugdale": rc.DugdaleWall(0.02, 0.7),
    "plastic": rc.PlasticWall(0.1, permanent=True),
}
WINDOW = Box((-16, -16), (32, 32))


IGNORE = rc.StepOptions(window="unchecked")


def problem(wall="hard", **options):
    return rc.Problem(SPHERE, Isotropic(1.0), WALLS[wall], 1.0, **options)


def atoms_of(wall, fixed, periodic=False):
    return atoms_under(
        SPHERE, WALLS[wall], WINDOW.shape, fixed=fixed, periodic=periodic
    )


@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("window", ["unchecked", "auto"])
def test_arrays_and_atoms_give_the_same_bits(wall, window):
    loads = [0.5, 5.0, 20.0, 2.0]
    options = rc.StepOptions(window=window)
    stepper = rc.Stepper(problem(wall), "loads", WINDOW, options)
    path = rc.load_path(atoms_of(wall, fixed=False), loads=loads, window=window)
    others = follow(NumberedSteps(stepper, np.array(loads)))
    for step, other in zip(path, others, strict=True):
        for name in ("height", "normal_force", "contact_area", "energy", "pairs"):
            assert getattr(other, name) == getattr(step, name), name


@pytest.mark.parametrize("wall", ["hard", "repulsive", "adhesive"])
def test_atoms_follow_every_step_with_its_results(wall):
    atoms = atoms_of(wall, fixed=True)
    for step in rc.load_path(atoms, heights=[-1.0, -1.5], window="auto"):
        assert not atoms.calc.check_state(atoms)
        assert atoms.get_potential_energy() == step.energy
        assert atoms.calc.get_property("normal_force", atoms) == step.normal_force
        assert atoms.positions[-1, 2] == step.height
        fresh = atoms.copy()
        fresh.calc = rc.RoughContact(**atoms.calc.parameters)
        if not WALLS[wall].hard:
            forces = fresh.get_forces()
            np.testing.assert_allclose(forces, atoms.get_forces(), atol=1e-9)


def test_a_step_leaves_the_state_before_it_unchanged():
    stepper = rc.Stepper(problem("repulsive"), "heights", WINDOW, IGNORE)
    before = stepper.commit(stepper.relax(stepper.start, -1.0)).state
    pressure, displacement = before.pressure.copy(), before.displacement.copy()
    assert stepper.relax(before, -1.5).state is not before
    np.testing.assert_array_equal(before.pressure, pressure)
    np.testing.assert_array_equal(before.displacement, displacement)


@pytest.mark.parametrize("wall", WALLS)
def test_a_path_continues_from_any_of_its_states(wall):
    heights = [-1.0, -1.8, -1.2, -2.0]
    stepper = rc.Stepper(problem(wall), "heights", WINDOW, IGNORE)
    whole = list(follow_states(NumberedSteps(stepper, np.array(heights))))
    again = rc.Stepper(problem(wall), "heights", WINDOW, IGNORE)
    rest = NumberedSteps(again, np.array(heights[2:]))
    _, left = whole[1]
    steps = follow_states(rest, first=lambda: left.state)
    for (done, _), (step, _) in zip(whole[2:], steps, strict=True):
        for name in ("normal_force", "contact_area", "plastic_atoms", "tolerance"):
            found, expected = getattr(step, name), getattr(done, name)
            np.testing.assert_equal(found, expected, name)


def test_atoms_with_an_offset_lattice_are_the_same_problem():
    atoms = atoms_of("hard", fixed=True)
    atoms.positions[-1, :2] += (0.25, -0.1)
    found, window = problem_of(atoms)
    assert found.offset == pytest.approx((-0.25, 0.1))
    assert window == WINDOW
    origin = atoms.positions[0, :2] - atoms.positions[-1, :2]
    assert found.origin(window) == pytest.approx(tuple(origin))


def test_local_adhesion_needs_an_attractive_wall():
    pattern = rc.Heterogeneity(lambda x, y: 0.1 * np.cos(x))
    contact = problem("dugdale", heterogeneity=pattern).contact(WINDOW)
    assert contact.adhesion is not None
    with pytest.raises(ValueError, match="attraction"):
        problem("hard", heterogeneity=pattern)


@pytest.mark.parametrize("offset", [-0.5, -0.3, 0.0, 0.49])
@pytest.mark.parametrize("start", [-17, -10, -9, 0, 5])
def test_a_window_is_found_again_by_its_origin(offset, start):
    made = problem(offset=(offset, offset))
    window = Box((start, start), (6, 7))
    assert made.window(window.shape, made.origin(window)) == window


@pytest.mark.parametrize("shape", [(30, 30), (32, 32)])
def test_atoms_on_a_coarser_grid_agree_with_the_state(shape):
    sphere = rc.RoughSphere(60.0)
    atoms = atoms_under(sphere, shape=shape)
    options = {"window": "auto", "grid": "2 a0", "validity": "ignore"}
    for step in rc.load_path(atoms, penetrations=[0.5, 1.6], **options):
        fresh = atoms.copy()
        fresh.calc = rc.RoughContact(**atoms.calc.parameters)
        assert fresh.get_potential_energy() == pytest.approx(step.energy, rel=1e-6)


def test_a_path_starts_from_the_atoms_as_they_are_when_it_is_iterated():
    atoms = atoms_of("repulsive", fixed=True)
    down = rc.load_path(atoms, penetrations=[0.5, 1.0], window="unchecked")
    up = rc.load_path(atoms, penetrations=[-0.5], window="unchecked")
    list(down)
    (last,) = up
    assert atoms.get_potential_energy() == pytest.approx(last.energy, abs=1e-9)


def test_atoms_that_were_moved_after_the_last_step_keep_their_own_energy():
    atoms = atoms_of("repulsive", fixed=True)
    for step in rc.load_path(atoms, penetrations=[0.5], window="auto"):
        atoms.positions[-1, 2] -= 0.3
        assert atoms.get_potential_energy() > step.energy
    moved = atoms.get_potential_energy()
    atoms.calc.reset()
    assert atoms.get_potential_energy() == pytest.approx(moved)


def modes_by_lbfgs(atoms, logfile):
    return LBFGS(rc.FourierModes(atoms), alpha=1.0, logfile=logfile)


@pytest.mark.parametrize("optimizer", [None, modes_by_lbfgs])
def test_after_an_error_atoms_are_in_the_last_relaxed_state(optimizer):
    atoms = atoms_of("repulsive", fixed=True)
    tolerance = {"fmax": 1e-5, "max_steps": 1000}
    path = rc.load_path(
        atoms, penetrations=[0.3, 2.0], optimizer=optimizer, **tolerance
    )
    step = next(path)
    with pytest.raises(RuntimeError, match="edge"):
        next(path)
    assert atoms.positions[-1, 2] == step.height
    assert atoms.get_potential_energy() == pytest.approx(step.energy, rel=1e-6)


def test_forces_of_the_wall_bound_the_tolerance_of_any_optimizer():
    atoms = atoms_of("repulsive", fixed=True)
    (step,) = rc.load_path(
        atoms, penetrations=[1.0], optimizer=FIRE, fmax=50.0, window="unchecked"
    )
    assert not step.converged
    assert "fmax" in step.message


def test_message_of_a_step_has_forces_with_their_unit():
    atoms = atoms_of("repulsive", fixed=True)
    (step,) = rc.load_path(
        atoms, penetrations=[1.0], optimizer=FIRE, fmax=50.0, window="unchecked"
    )
    assert f"{step.max_force:.3g} eV/Å" in step.message


def test_a_finished_path_that_is_resumed_sets_the_load(tmp_path):
    options = {"output": rc.Output(trajectory=tmp_path / "a.traj", resume=True)}
    for _ in range(2):
        atoms = atoms_of("repulsive", fixed=False)
        list(rc.load_path(atoms, loads=[1.0, 2.0], window="auto", **options))
        assert atoms.calc.parameters["load"] == 2.0
        assert atoms.calc.get_property("normal_force", atoms) == pytest.approx(2.0)
        assert abs(atoms.get_forces()[-1, 2]) < 1e-3


def test_springs_are_refused_before_the_first_step_where_a_solver_has_none():
    atoms = atoms_of("hard", fixed=False)
    x, y, z = atoms.positions[-1]
    atoms.set_constraint(Hookean(len(atoms) - 1, (x, y, z - 5.0), k=0.3, rt=0.0))

    class Fixed(rc.ActiveSet):
        springs = False

    with pytest.raises(ValueError, match="Fixed does not support a spring"):
        rc.load_path(atoms, loads=[1.0], optimizer=Fixed)


def test_an_optimizer_warns_that_it_does_not_keep_a_plastic_shape():
    with pytest.warns(UserWarning, match="load_path"):
        rc.ActiveSet(atoms_of("plastic", fixed=True))


def test_a_hardness_in_the_wrong_unit_is_warned_of():
    with pytest.warns(UserWarning, match="GPa"):
        rc.RoughContact(SPHERE, 1.0, rc.PlasticWall(hardness=11.0))
