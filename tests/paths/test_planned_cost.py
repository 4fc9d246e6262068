"""Planned time and memory of load steps."""

import itertools
import time

import numpy as np
import pytest

from ase_roughcontact import (
    HardWall,
    LennardJones93,
    RoughContact,
    RoughSphere,
    load_path,
    substrate,
)
from ase_roughcontact.atoms.path_atoms import problem_of
from ase_roughcontact.paths.plan import plan_path

SPHERE = RoughSphere(1e6)
WALLS = {
    "hard": HardWall(),
    "repulsive": LennardJones93.repulsive(1.0, 1.0),
    "adhesive": LennardJones93.adhesive(1.0, 1.0, 0.01),
}


def make_atoms(wall="repulsive", sphere=SPHERE, shape=(8, 8), **options):
    atoms = substrate("Cu", shape, sphere, spacing=1.0, **options)
    atoms.calc = RoughContact(sphere, 1.0, WALLS[wall])
    return atoms


def test_time_grows_as_n_log_n():
    # the grids are too large to be timed, and each is twice as wide as the one before:
    # all three times are extrapolated from the same measurement
    widths = np.array([1420.0, 2840.0, 5720.0])
    depths = widths**2 / (8.0 * SPHERE.radius)
    steps = plan_path(*problem_of(make_atoms()), "penetrations", depths, "auto").steps
    sides = np.array([[int(n) for n in step.grid.split("x")] for step in steps])
    np.testing.assert_array_equal(sides[1:], 2 * sides[:-1])
    points = sides.prod(axis=1)
    assert points[0] > 1024**2
    costs = points * np.log(points)
    first, second, third = (step.seconds for step in steps)
    ratio = (third - first) / (second - first)
    assert ratio == pytest.approx(np.diff(costs[[0, 2]])[0] / np.diff(costs[:2])[0])


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
    sphere, depths = RoughSphere(100.0), [0.5, 1.0]
    options = {"sphere": sphere, "shape": (64, 64)}
    plan = plan_path(
        *problem_of(make_atoms(wall, **options)), "penetrations", depths, window
    )
    atoms = make_atoms(wall, **options)
    for step, record in zip(
        plan.steps, load_path(atoms, depths, window=window), strict=True
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
    atoms = make_atoms(wall, RoughSphere(1000.0), (16, 16), periodic=True)
    (step,) = plan_path(*problem_of(atoms), "penetrations", [0.1], "fixed").steps
    fewest, most = MEASURED[wall]
    assert fewest < step.seconds < most
