"""Errors of paths in time against the exact force of a sphere, and their cost.

A hard sphere moves into a standard linear solid (relaxed modulus 1/5 of the
instantaneous one) and back at a constant rate, in windows of 128 x 128 atoms. The force
is compared with that of Lee & Radok, J. Appl. Mech. 27, 438 (1960), and of Ting, J.
Appl. Mech. 33, 845 (1966), relative to the largest one.
"""

import math

import numpy as np
from markdown import order, table
from scipy.integrate import quad
from scipy.optimize import brentq

from ase_roughcontact import (
    Creep,
    HardWall,
    Problem,
    RoughSphere,
    Schedule,
    Stepper,
    Viscoelastic,
)
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.path_kinds.time.specification import TimeSpecification
from ase_roughcontact.path_kinds.time.steps import TimeSteps
from ase_roughcontact.paths.follow import follow

SIDE, RADIUS = 128, 1280.0  # spacings
DEPTH = (0.4 * SIDE) ** 2 / RADIUS
CREEP = Creep.standard_solid(relaxed=0.2, time=1.0)


def ting_force(time, half):
    """Force at a time, of an approach and a retraction of the same duration."""
    rate, turned = DEPTH / half, min(time, half)
    if time > half:

        def unbalanced(begin):
            down = quad(lambda s: CREEP.relaxation(time - s), begin, half)[0]
            return down - quad(lambda s: CREEP.relaxation(time - s), half, time)[0]

        if unbalanced(0.0) < 0.0:
            return 0.0
        turned = brentq(unbalanced, 0.0, half)
    integral = quad(lambda s: CREEP.relaxation(time - s) * math.sqrt(s), 0.0, turned)[0]
    return 2.0 * math.sqrt(RADIUS * rate**3) * integral


def main():
    """Print a table of errors and costs."""
    rows = []
    for half in (0.1, 4.0, 40.0):
        for tolerance in (1e-2, 1e-3, 1e-4):
            solid = Viscoelastic(1.0, CREEP)
            sphere = RoughSphere(RADIUS)
            problem = Problem(sphere, solid, HardWall(), 1.0, offset=(0.5, 0.5))
            window = Box((-SIDE // 2, -SIDE // 2), (SIDE, SIDE))
            path = Schedule(0.0).ramp(DEPTH, time=half).ramp(0.0, time=half)
            stepper = Stepper(problem, "penetrations", window)
            steps = list(
                follow(
                    TimeSteps(stepper, TimeSpecification(path, tolerance)),
                    validity="ignore",
                )
            )
            exact = np.array([ting_force(step.time, half) for step in steps])
            errors = abs(np.array([step.normal_force for step in steps]) - exact)
            errors /= exact.max()
            loading = np.array([step.time <= half for step in steps])
            pairs = np.mean([step.pairs for step in steps])
            worst = (f"{errors[part].max():.1e}" for part in (loading, ~loading))
            rows.append(
                (f"{half:g}", order(tolerance), len(steps), *worst, f"{pairs:.1f}")
            )
    head = "duration (relaxation times) | tolerance | time steps | error of loading"
    table(f"{head} | error of unloading | FFT pairs a step", rows)


if __name__ == "__main__":
    main()
