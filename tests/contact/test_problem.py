"""Problem and State: contacts on windows of a lattice, as arrays without Atoms."""

import numpy as np
import pytest

from ase_roughcontact import (
    DugdaleWall,
    HardWall,
    Heterogeneity,
    LennardJones93,
    PlasticWall,
    Problem,
    RoughContact,
    RoughSphere,
    SelfAffine,
    State,
    load_path,
    substrate,
)
from ase_roughcontact.atoms.path_atoms import problem_of
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.paths.step import StepOptions, Stepper

SPHERE = RoughSphere(200.0, SelfAffine(0.1, 0.8, 4.0, 32.0, seed=3, domain=128.0))
WALLS = {
    "hard": HardWall(),
    "repulsive": LennardJones93.repulsive(1.0, 1.0),
    "adhesive": LennardJones93.adhesive(1.0, 1.0, 0.02),
    "dugdale": DugdaleWall(0.02, 0.7),
    "plastic": PlasticWall(0.1, permanent=True),
}
WINDOW = Box((-16, -16), (32, 32))


IGNORE = StepOptions(edge="ignore")


def problem(wall="hard", **options):
    return Problem(SPHERE, Isotropic(1.0), WALLS[wall], 1.0, **options)


def atoms_of(wall, fixed, periodic=False):
    atoms = substrate(
        "Cu", WINDOW.shape, SPHERE, spacing=1.0, fixed=fixed, periodic=periodic
    )
    atoms.calc = RoughContact(SPHERE, 1.0, WALLS[wall])
    return atoms


@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("window", ["fixed", "auto"])
def test_arrays_and_atoms_give_the_same_bits(wall, window):
    loads = [0.5, 5.0, 20.0, 2.0]
    options = StepOptions(window=window, edge="ignore")
    stepper = Stepper(problem(wall), "loads", WINDOW, options)
    path = load_path(
        atoms_of(wall, fixed=False), loads=loads, window=window, edge="ignore"
    )
    for number, step in enumerate(path):
        other = stepper.step(number, loads[number])
        for name in ("height", "normal_force", "contact_area", "energy", "pairs"):
            assert getattr(other, name) == getattr(step, name), name


@pytest.mark.parametrize("wall", ["hard", "repulsive", "adhesive"])
def test_atoms_follow_every_step_with_its_results(wall):
    atoms = atoms_of(wall, fixed=True)
    for step in load_path(atoms, heights=[-1.0, -1.5], window="auto"):
        assert not atoms.calc.check_state(atoms)
        assert atoms.get_potential_energy() == step.energy
        assert atoms.calc.results["normal_force"] == step.normal_force
        assert atoms.positions[-1, 2] == step.height
        fresh = atoms.copy()
        fresh.calc = RoughContact(**atoms.calc.parameters)
        if not WALLS[wall].hard:
            np.testing.assert_allclose(
                fresh.get_forces(), atoms.get_forces(), atol=1e-9
            )


def test_a_step_leaves_the_state_before_it_unchanged():
    stepper = Stepper(problem("repulsive"), "heights", WINDOW, IGNORE)
    stepper.step(0, -1.0)
    before = stepper.state
    pressure, displacement = before.pressure.copy(), before.displacement.copy()
    stepper.step(1, -1.5)
    assert stepper.state is not before
    np.testing.assert_array_equal(before.pressure, pressure)
    np.testing.assert_array_equal(before.displacement, displacement)


@pytest.mark.parametrize("wall", WALLS)
def test_a_path_continues_from_any_of_its_states(wall):
    heights = [-1.0, -1.8, -1.2, -2.0]
    stepper = Stepper(problem(wall), "heights", WINDOW, IGNORE)
    whole, states = [], []
    for number, height in enumerate(heights):
        whole.append(stepper.step(number, height))
        states.append(stepper.state)
    again = Stepper(problem(wall), "heights", WINDOW, IGNORE)
    again.restart_from(states[1])
    for number in (2, 3):
        step = again.step(number, heights[number])
        assert step.normal_force == pytest.approx(whole[number].normal_force, rel=1e-4)
        assert step.contact_area == whole[number].contact_area
        assert step.plastic_atoms == whole[number].plastic_atoms


def test_history_is_carried_to_another_window():
    depth = np.zeros(WINDOW.shape)
    depth[10, 12] = 0.3
    state = State(WINDOW, 0.0, depth.copy(), history={"plastic_depth": depth})
    moved = state.on(Box((-20, -18), (40, 36)))
    assert moved.plastic_depth.sum() == moved.pressure.sum() == 0.3
    assert moved.plastic_depth[14, 14] == 0.3
    assert moved.on(WINDOW).plastic_depth[10, 12] == 0.3


def test_atoms_with_an_offset_lattice_are_the_same_problem():
    atoms = atoms_of("hard", fixed=True)
    atoms.positions[-1, :2] += (0.25, -0.1)
    found, window = problem_of(atoms)
    assert found.offset == pytest.approx((-0.25, 0.1))
    assert window == WINDOW
    origin = atoms.positions[0, :2] - atoms.positions[-1, :2]
    assert found.origin(window) == pytest.approx(tuple(origin))


def test_local_adhesion_needs_an_attractive_wall():
    pattern = Heterogeneity(lambda x, y: 0.1 * np.cos(x))
    assert (
        problem("dugdale", heterogeneity=pattern).contact(WINDOW).adhesion is not None
    )
    with pytest.raises(ValueError, match="attraction"):
        problem("hard", heterogeneity=pattern)
