"""Order of convergence of paths in time, and the cost of their steps.

    python time_steps.py order
    python time_steps.py cost

A sphere moves into a standard linear solid (relaxed modulus 1/5 of the instantaneous
one) and back, each in four relaxation times, in equal time steps. Errors of the force
are those against eight times as many steps as the finest ones of the table, relative to
the largest force. The cost is that of 256 x 256 points on one thread: CPU time and FFT
pairs, beside the same heights on the instantaneous solid.
"""

import math
import resource
import sys

import numpy as np

from ase_roughcontact import (
    Creep,
    HardWall,
    LennardJones93,
    Problem,
    RoughSphere,
    SelfAffine,
    StepOptions,
    Stepper,
    Viscoelastic,
)
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box

CREEP = Creep.standard_solid(relaxed=0.2, time=1.0)
HALF = 4.0  # relaxation times


def stepper_of(side, wall, creep, roughness, accuracy):
    """Return a stepper on a window, and the largest penetration."""
    radius = 10.0 * side
    solid = Viscoelastic(1.0, creep) if creep else Isotropic(1.0)
    sphere = RoughSphere(radius, roughness)
    problem = Problem(sphere, solid, wall, 1.0, offset=(0.5, 0.5))
    box = Box((-side // 2, -side // 2), (side, side))
    options = StepOptions(accuracy=accuracy)
    return Stepper(problem, "penetrations", box, options), (0.35 * side) ** 2 / radius


def forces(side, wall, count, creep=CREEP, roughness=None, accuracy=1e-7):
    """Return forces after equal steps in and out, and the FFT pairs."""
    stepper, depth = stepper_of(side, wall, creep, roughness, accuracy)
    elapsed = HALF / count
    found, pairs, state = [], 0.0, stepper.start
    for k in range(2 * count + 1):
        target = depth * (1.0 - abs(k / count - 1.0))
        time = {"moment": k * elapsed, "elapsed": elapsed if k else 0.0}
        relaxed = stepper.relax(state, target, **(time if creep else {}))
        assert relaxed.run.converged, relaxed.run.message
        found.append(relaxed.fields.normal_force)
        pairs += relaxed.run.pairs
        state = stepper.commit(relaxed).state
    return np.array(found), pairs


def order(counts=(8, 16, 32, 64)):
    """Print errors while atoms close, and while they open, and their order."""
    print("| wall | steps | error of the approach | of the retraction | orders |")
    print("|---|---|---|---|---|")
    walls = {"hard": HardWall(), "soft": LennardJones93.repulsive(1.0, 1.0)}
    for name, wall in walls.items():
        exact, _ = forces(64, wall, 8 * counts[-1])
        last = None
        for count in counts:
            every = 8 * counts[-1] // count
            error = abs(forces(64, wall, count)[0] - exact[::every]) / exact.max()
            errors = error[: count + 1].max(), error[count:].max()
            orders = [
                math.log2(a / b) for a, b in zip(last or (), errors, strict=False)
            ]
            text = " and ".join(f"{value:.1f}" for value in orders)
            print(
                f"| {name} | {count} | {errors[0]:.1e} | {errors[1]:.1e} | {text} |",
                flush=True,
            )
            last = errors


def cost(count=500, side=256):
    """Print CPU time and FFT pairs of time steps and of elastic steps."""
    print("| sphere | solid | steps | CPU time (s) | FFT pairs a step |")
    print("|---|---|---|---|---|")
    rough = SelfAffine(0.05, 0.8, 4.0, 128.0, domain=256.0, seed=1)
    for sphere, roughness in (("smooth", None), ("rough", rough)):
        for solid, creep in (("viscoelastic", CREEP), ("elastic", None)):
            before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
            _, pairs = forces(side, HardWall(), count, creep, roughness, "normal")
            used = resource.getrusage(resource.RUSAGE_SELF).ru_utime - before
            steps = 2 * count + 1
            print(
                f"| {sphere} | {solid} | {steps} | {used:.0f} | {pairs / steps:.1f} |",
                flush=True,
            )


if __name__ == "__main__":
    {"order": order, "cost": cost}[sys.argv[1]]()
