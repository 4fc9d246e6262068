"""Estimated errors of the continuum under hard walls, for random contacts."""

import math
from collections import defaultdict
from functools import partial

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.theory import Hertz

ATTRACTIVE = {
    "dugdale": rc.DugdaleWall,
    "exponential": partial(rc.ExponentialWall, relative_cutoff=4.0),
    "power law": partial(rc.PowerLawWall, relative_cutoff=4.0),
}
SIDE, CASES = 32, 40


def random_contact(kind, number):
    """Return an indenter, a wall and loads: smooth, rough and flat in turn."""
    random = np.random.default_rng([number, 79])

    def between(low, high):
        return math.exp(random.uniform(math.log(low), math.log(high)))

    slope, hurst = random.uniform(0.03, 0.15), random.uniform(0.3, 0.9)
    radius, contact = between(100.0, 400.0), random.uniform(4.0, 11.0)
    load, pressure = Hertz(radius, 1.0).force(contact), 0.6 * slope
    shape = ("smooth", "rough", "flat")[number % 3]
    domain = SIDE if shape == "flat" else 128
    rough = rc.SelfAffine(slope, hurst, 4.0, 32.0, seed=9000 + number, domain=domain)
    if shape == "smooth":
        rough, pressure = None, 2.0 * contact / (math.pi * radius)
    if shape == "flat":
        radius, load = math.inf, SIDE**2 * slope * between(0.02, 1.2)
    wall, loads = rc.HardWall(), [load]
    if kind in ATTRACTIVE:
        work = between(0.1, 1.0) * (0.02 if shape == "smooth" else slope**2)
        zone = between(5.0, 60.0)  # of Dugdale, in spacings
        wall = ATTRACTIVE[kind](work, math.sqrt(4.0 * zone * work / math.pi))
    if kind in ("plastic", "unloaded"):
        hardness = between(0.3, 2.0) * pressure
        load = min(load, 0.85 * hardness * SIDE**2) if shape == "flat" else load
        wall = rc.PlasticWall(hardness, permanent=kind == "unloaded")
        loads = [load, 0.5 * load] if kind == "unloaded" else [load]
    return rc.RoughSphere(radius, rough), wall, loads


def last_step(indenter, wall, refine, **targets):
    flat, fixed = indenter.radius == math.inf, "heights" in targets
    shape = (SIDE, SIDE) if flat else (8, 8)
    atoms = atoms_under(indenter, wall, shape, fixed=fixed, periodic=flat)
    grid = {"grid": f"a0/{refine}", "accuracy": 1e-4}
    window = "fixed" if flat else "auto"
    *_, step = rc.load_path(atoms, **targets, **grid, window=window, validity="ignore")
    assert step.converged
    return step


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["hard", *ATTRACTIVE, "plastic", "unloaded"])
def test_nine_of_ten_errors_are_within_twice_the_estimate(kind):
    """Against the limit of the grids of a0/2 and a0/4."""
    within, areas = defaultdict(list), []
    for number in range(CASES):
        indenter, wall, loads = random_contact(kind, number)
        at_load = [last_step(indenter, wall, k, loads=loads) for k in (1, 2, 4)]
        answers = {"continuum_area": "area_error", "height": "height_error"}
        found = [(name, error, at_load) for name, error in answers.items()]
        if kind != "unloaded":
            height = [at_load[0].height]
            steps = [last_step(indenter, wall, k, heights=height) for k in (1, 2, 4)]
            found.append(("normal_force", "force_error", steps))
        for name, error, steps in found:
            coarse, fine, finest = (getattr(step, name) for step in steps)
            limit = finest + (finest - fine) / 3.0
            within[name].append(abs(coarse - limit) <= 2.0 * getattr(steps[0], error))
        areas.append(at_load[0].area_error / at_load[0].continuum_area)
    for values in within.values():
        assert np.mean(values) >= 0.9
    assert np.median(areas) < 0.05
