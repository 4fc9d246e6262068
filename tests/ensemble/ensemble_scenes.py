"""Small scenes for the tests of ensembles, and what these share."""

import multiprocessing
import os
import signal
import time
from concurrent.futures import Executor, Future, ThreadPoolExecutor

import numpy as np
from ase.db import connect

from ase_roughcontact.ensemble import product, run_ensemble
from ase_roughcontact.scene import InteractionConfig, Scene

WALLS = [
    InteractionConfig("repulsive"),
    InteractionConfig("adhesive", {"work_of_adhesion": 0.05}),
]
SCENE = Scene.parse("""
substrate = { material = "Cu" }
sphere = { unit = "a0", radius = 60.0 }
roughness = { unit = "a0", long_wavelength = 16.0 }
path = { control = "penetration", first = 0.2, last = 0.6, steps = 3, scale = "linear" }
""")
LONG = SCENE.with_values({"path.first": 0.02, "path.last": 0.8, "path.steps": 10})
SCENES = [
    *product(SCENE, {"roughness.seed": range(2), "interaction": WALLS}),
    *product(LONG, {"interaction": WALLS}),
]
STEPS = 4 * 3 + 2 * 10
SPAWN = multiprocessing.get_context("spawn")


class Here(Executor):
    """Runs tasks in this process, counts them, and lets something happen before."""

    def __init__(self, happens=lambda: None):
        self.happens, self.count = happens, 0

    def submit(self, function, /, *arguments):
        self.happens()
        self.count += 1
        future = Future()
        future.set_result(function(*arguments))
        return future


def killed(target, *arguments):
    """Run a function in a process of its own, which kills itself."""
    process = SPAWN.Process(target=target, args=arguments)
    process.start()
    process.join(60)
    assert process.exitcode == -signal.SIGKILL


def die(scene, database, number, stored):
    """Run, and be killed when a step is relaxed, before or after it is stored."""
    relax = Scene.relax

    def deadly(*arguments, **options):
        for step in relax(*arguments, **options):
            if step.step == number and not stored:
                os.kill(os.getpid(), signal.SIGKILL)
            yield step
            if step.step == number:
                os.kill(os.getpid(), signal.SIGKILL)

    Scene.relax = deadly
    finish([scene], database)


def finish(scenes, database, **options):
    """Run with one thread, and return the last progress."""
    with ThreadPoolExecutor(1) as pool:
        options = {"executor": pool, "interval": 0.02, **options}
        return list(run_ensemble(scenes, database, **options))[-1]


def wait_for(happened, seconds=30.0):
    end = time.monotonic() + seconds
    while not happened():
        assert time.monotonic() < end
        time.sleep(0.02)


def rows(database, **query):
    return list(connect(database).select(**query))


def assert_same(columns, others, **tolerance):
    """Compare columns, but for the time, which differs from run to run."""
    assert columns.keys() == others.keys()
    for name in columns.keys() - {"seconds"}:
        if tolerance and columns[name].dtype.kind == "f":
            np.testing.assert_allclose(columns[name], others[name], **tolerance)
        else:
            np.testing.assert_array_equal(columns[name], others[name], name)


def assert_same_states(columns, others):
    """Compare columns, some of them calculated on from the middle of a path.

    Their states are the same within the tolerance of the solver, 1e-4 of the mean
    force; the path of the solver to them is not.
    """
    solver = {"max_force", "tolerance", "iterations", "pairs", "window", "grid"}
    solver |= {"area_error", "force_error", "height_error", "penetration_error"}
    kept = columns.keys() - solver
    assert_same(
        {name: columns[name] for name in kept},
        {name: others[name] for name in kept},
        rtol=1e-3,
    )
