"""Steps of a path start from the pressure extrapolated from the last two."""

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import problem_of
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.paths.extrapolation import Extrapolation

SPHERE = rc.RoughSphere(300.0, rc.SelfAffine(0.05, 0.8, 4.0, 32.0, seed=2))
LOADS = 20.0 * 0.97 ** np.arange(3)
WALLS = {
    "hard": rc.HardWall(),
    "repulsive": rc.LennardJones93.repulsive(1.0, 1.0),
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.01),
}


def make_atoms(wall, fixed=False, height=0.0, load=0.0):
    return atoms_under(
        SPHERE, WALLS[wall], (32, 32), load=load, height=height, fixed=fixed
    )


def relaxed(wall, **path):
    return list(
        rc.load_path(
            make_atoms(wall, "loads" not in path), fmax=1e-6, window="unchecked", **path
        )
    )


@pytest.mark.parametrize("wall", ["hard", "repulsive"])
@pytest.mark.parametrize("control", ["loads", "heights"])
def test_extrapolated_step_ends_in_the_same_state(wall, control):
    targets = LOADS if control == "loads" else [-0.5, -0.48, -0.46]
    third = relaxed(wall, **{control: targets})[2]
    from_last = relaxed(wall, **{control: targets[1:]})[1]
    assert third.contact_area == from_last.contact_area
    assert third.height == pytest.approx(from_last.height, abs=1e-5)
    assert third.normal_force == pytest.approx(from_last.normal_force, rel=1e-5)


def kept_states(wall, heights):
    atoms, extrapolation = make_atoms(wall, fixed=True), Extrapolation()
    _, window = problem_of(atoms)
    for height in heights:
        atoms.positions[-1, 2] = height
        (rc.ActiveSet if wall == "hard" else rc.NewtonKrylov)(atoms).run(fmax=1e-6)
        pressure = atoms.calc.state(atoms).pressure
        extrapolation.add(height, rc.State(window, height, pressure), pressure)
    return extrapolation, window, pressure


def test_extrapolation_is_linear_and_without_tension():
    extrapolation, window, last = kept_states("hard", [-0.6, -0.5])
    pressure, height = extrapolation.start(window, -0.4)
    _, _, first = kept_states("hard", [-0.6])
    np.testing.assert_allclose(pressure, np.maximum(2.0 * last - first, 0.0), atol=1e-6)
    assert height == pytest.approx(-0.4)
    back, _ = extrapolation.start(window, -0.6)
    np.testing.assert_allclose(back, first, atol=1e-6)


@pytest.mark.parametrize(
    ("wall", "heights", "target"),
    [
        ("hard", [-0.5], -0.4),
        ("hard", [-0.5, -0.5], -0.4),
        ("hard", [-0.6, -0.5], -0.1),
        ("hard", [50.0, 49.0], 48.0),
    ],
    ids=["one state", "equal targets", "too far", "no contact"],
)
def test_nothing_is_extrapolated(wall, heights, target):
    extrapolation, window, _ = kept_states(wall, heights)
    assert extrapolation.start(window, target) is None


def test_states_of_another_window_are_not_used():
    extrapolation, window, _ = kept_states("hard", [-0.6, -0.5])
    other = Box(window.start, (8, 8))
    assert extrapolation.start(other, -0.4) is None


@pytest.mark.parametrize("steps", [4, 6, 9])
def test_unloading_a_soft_wall_to_no_load_at_all(steps):
    """Nothing holds the indenter there: it starts from the last state."""
    sphere = rc.RoughSphere(100.0)
    atoms = atoms_under(sphere, rc.LennardJones93.repulsive(1.0, 1.0), fixed=False)
    loads = np.linspace(3.0, 0.0, steps)
    path = list(rc.load_path(atoms, loads=loads, window="auto", validity="ignore"))
    assert all(step.converged for step in path)
    assert path[-1].normal_force == pytest.approx(0.0, abs=1e-6)
