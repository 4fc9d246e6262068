"""Planned time and memory of load steps."""

import itertools
import time

import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import problem_of
from ase_roughcontact.paths.plan import plan_path

SPHERE = rc.RoughSphere(1e6)
WALLS = {
    "hard": rc.HardWall(),
    "repulsive": rc.LennardJones93.repulsive(1.0, 1.0),
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.01),
}


def make_atoms(wall="repulsive", sphere=SPHERE, shape=(8, 8), **options):
    return atoms_under(sphere, WALLS[wall], shape, **options)


def test_a_plan_has_the_total_time_and_the_peak_memory():
    plan = plan_path(
        *problem_of(make_atoms()), "penetrations", [1e-4, 1e-2, 1e-3], "auto"
    )
    assert plan.seconds == pytest.approx(sum(step.seconds for step in plan.steps))
    assert plan.memory == max(step.memory for step in plan.steps)
    assert [step.target for step in plan.steps] == [1e-4, 1e-2, 1e-3]


@pytest.mark.parametrize("window", ["fixed", "auto"])
@pytest.mark.parametrize("wall", WALLS)
def test_planned_memory_is_that_of_the_results(wall, window):
    sphere, depths = rc.RoughSphere(100.0), [0.5, 1.0]
    options = {"sphere": sphere, "shape": (64, 64)}
    plan = plan_path(
        *problem_of(make_atoms(wall, **options)), "penetrations", depths, window
    )
    atoms = make_atoms(wall, **options)
    for step, record in zip(
        plan.steps, rc.load_path(atoms, depths, window=window), strict=True
    ):
        tolerance = 1e-12 if step.window == record.window else 0.05
        assert step.memory == pytest.approx(record.memory, rel=tolerance)
        assert (step.window == "64x64") == (window == "fixed")


# Measured time of a step, in convolutions, for windows of 100 to 1700 atoms a side.
MEASURED = {"hard": (106, 197), "repulsive": (132, 248), "adhesive": (218, 463)}


@pytest.mark.parametrize("wall", WALLS)
def test_the_time_of_a_step_is_in_the_measured_range(wall, monkeypatch):
    ticks = itertools.count()
    monkeypatch.setattr(time, "perf_counter", lambda: float(next(ticks)))
    atoms = make_atoms(wall, rc.RoughSphere(1000.0), (16, 16), periodic=True)
    (step,) = plan_path(*problem_of(atoms), "penetrations", [0.1], "fixed").steps
    fewest, most = MEASURED[wall]
    assert fewest < step.seconds < most
