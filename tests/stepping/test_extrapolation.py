"""Steps of a path start from the pressure extrapolated from the last two."""

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc

SPHERE = rc.RoughSphere(300.0, rc.SelfAffine(0.05, 0.8, 4.0, 32.0, seed=2))
LOADS = 20.0 * 0.97 ** np.arange(3)
WALLS = {"hard": rc.HardWall(), "repulsive": rc.LennardJones93.repulsive(1.0, 1.0)}


def relaxed(wall, **path):
    fixed = "loads" not in path
    atoms = atoms_under(SPHERE, WALLS[wall], (32, 32), height=0.0, fixed=fixed)
    return list(rc.load_path(atoms, fmax=1e-6, window="unchecked", **path))


@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("control", ["loads", "heights"])
def test_extrapolated_step_ends_in_the_same_state(wall, control):
    targets = LOADS if control == "loads" else [-0.5, -0.48, -0.46]
    third = relaxed(wall, **{control: targets})[2]
    from_last = relaxed(wall, **{control: targets[1:]})[1]
    assert third.contact_area == from_last.contact_area
    assert third.height == pytest.approx(from_last.height, abs=1e-5)
    assert third.normal_force == pytest.approx(from_last.normal_force, rel=1e-5)
    assert third.pairs < from_last.pairs


@pytest.mark.parametrize("steps", [4, 6, 9])
def test_unloading_a_soft_wall_to_no_load_at_all(steps):
    """Nothing holds the indenter there: it starts from the last state."""
    sphere = rc.RoughSphere(100.0)
    atoms = atoms_under(sphere, rc.LennardJones93.repulsive(1.0, 1.0), fixed=False)
    loads = np.linspace(3.0, 0.0, steps)
    path = list(rc.load_path(atoms, loads=loads, window="auto", validity="ignore"))
    assert all(step.converged for step in path)
    assert path[-1].normal_force == pytest.approx(0.0, abs=1e-6)
