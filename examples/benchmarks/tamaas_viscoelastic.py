"""A viscoelastic periodic contact: this package beside the Maxwell solid of Tamaas.

    python tamaas_viscoelastic.py

needs ``pip install tamaas``; measured with 2.9.0. The solid is a standard linear one of
relaxed modulus 1/5. First table: in full contact under a wave the pressures relax as
the modulus E(t), which is known; the surface is held from time zero, in steps of a
tenth of the relaxation time. Second table: a self-affine surface on 128 x 128 points
under a mean pressure, one step from rest that is much shorter or longer than the
relaxation time, so that the solid is the instantaneous or the relaxed one.
"""

import math

import numpy as np
import tamaas
from markdown import order, table

from ase_roughcontact import (
    Creep,
    HardWall,
    Problem,
    Schedule,
    SelfAffine,
    StepOptions,
    Stepper,
    Viscoelastic,
)
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.path_kinds.time.specification import TimeSpecification
from ase_roughcontact.path_kinds.time.steps import TimeSteps
from ase_roughcontact.paths.follow import follow_states

RELAXED, TIME, STEP = 0.2, 1.0, 0.1
CREEP = Creep.standard_solid(RELAXED, TIME)


class Heights:
    """Lower surface of the indenter, given at the points of a periodic grid."""

    def __init__(self, values):
        self.values = values

    def heights(self, shape, spacing, origin):
        """Return the heights, whatever part of the grid is asked for: all of it."""
        return self.values


def ours(values, pressure, schedule):
    """Yield times and pressures of a path in time, of mean pressures."""
    side = len(values)
    solid = Viscoelastic(1.0, CREEP)
    problem = Problem(Heights(values), solid, HardWall(), 1.0, periodic=True)
    options = StepOptions(accuracy=1e-8)
    stepper = Stepper(problem, "loads", Box((0, 0), (side, side)), options)
    path = schedule(pressure * side**2)
    for step, left in follow_states(
        TimeSteps(stepper, TimeSpecification(path, 1e-4)), validity="ignore"
    ):
        yield step.time, left.fields.pressure


def theirs(values, pressure, step, count=1):
    """Yield the pressures of Tamaas after each of some equal steps."""
    size = [float(len(values))] * 2
    model = tamaas.Model(tamaas.model_type.basic_2d, size, [len(values)] * 2)
    model.E, model.nu = RELAXED, 0.0
    surface = np.ascontiguousarray(-values)
    branch = [model.mu * (1.0 / RELAXED - 1.0)]
    solver = tamaas.MaxwellViscoelastic(model, surface, 1e-10, step, branch, [TIME])
    for _ in range(count):
        solver.solve(pressure)
        yield np.array(model.traction)


def main():
    """Print tables of a full and of a partial contact."""
    tamaas.set_log_level(tamaas.LogLevel.error)
    x = 2.0 * np.pi * np.arange(32) / 32
    wave = 0.1 * np.cos(x)[:, None] + np.zeros((32, 32))
    stiffness = 0.5 * 2.0 * np.pi / 32  # pressure per displacement of the wave

    def modulus(pressure):
        return -2.0 * float(np.mean(pressure * wave)) / (0.01 * stiffness)

    def held(load):
        path = Schedule(load)
        for _ in range(4):
            path = path.hold(STEP)
        return path

    ends = STEP * np.arange(1, 5)
    found = [
        modulus(pressure)
        for time, pressure in ours(wave, 1.0, held)
        if np.isclose(time, ends, rtol=1e-9).any()
    ]
    rows = [
        (
            f"{time:g}",
            f"{float(CREEP.relaxation(time)):.5f}",
            f"{mine:.5f}",
            f"{RELAXED + (1.0 - RELAXED) / (1.0 + STEP / TIME) ** (k + 1):.5f}",
            f"{modulus(pressure):.5f}",
        )
        for k, (mine, pressure) in enumerate(
            zip(found, theirs(wave, 1.0, STEP, 4), strict=True)
        )
        for time in [STEP * (k + 1)]
    ]
    table("time | E(t) | this package | backward Euler | Tamaas", rows)
    print()
    rough = SelfAffine(0.1, 0.8, 8.0, 64.0, domain=128.0, seed=1)
    values, rows = rough.heights((128, 128), 1.0), []
    for name, step in (("instantaneous", 1e-7), ("relaxed", 1e7)):
        for pressure in (0.002, 0.02):
            states = list(ours(values, pressure, lambda load: Schedule(load).hold(1e3)))
            _, mine = states[0 if step < 1.0 else -1]
            (other,) = theirs(values, pressure, step)
            areas = [f"{np.mean(p > 0.0):.5f}" for p in (mine, other)]
            apart = math.sqrt(np.mean((mine - other) ** 2) / np.mean(mine**2))
            rows.append((name, pressure, *areas, order(apart)))
    head = "solid | mean pressure/E(0) | contact area, this package | Tamaas"
    table(f"{head} | difference of the pressures (rms)", rows)


if __name__ == "__main__":
    main()
