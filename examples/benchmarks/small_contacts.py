"""Time of small contacts, in units of a convolution of the same window.

    OMP_NUM_THREADS=1 python small_contacts.py --sizes 16 32 64 128

A rough sphere with a contact radius of 0.3 of the window: a solution from a cold start,
one from the solution at 97 % of the load, and a step of `load_path` between loads that
differ by 3 %. Least times of the processor; the machine may be shared.
"""

import argparse
import time
from functools import partial

import numpy as np
from markdown import table

from ase_roughcontact import (
    HardWall,
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    substrate,
)
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.solvers.active_set import active_set
from ase_roughcontact.solvers.newton import newton_krylov

WALLS = {"hard": HardWall(), "repulsive": LennardJones93.repulsive(1.0, 1.0)}


def least_time(function, repeats):
    """Return the least time of calls (ms)."""
    times = []
    for _ in range(repeats):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return 1e3 * min(times)


def solution(wall, heights, load, start=None, height=None):
    """Return the last state and the pairs of transforms."""
    halfspace = FreeHalfSpace(heights.shape, 1.0, 1.0)
    contact = Contact(halfspace, heights, wall)
    states = (active_set if wall.hard else newton_krylov)(
        contact,
        height=contact.first_contact if height is None else height,
        external=lambda z: (load * z, -load),
        start=start,
        tolerance=1e-6,
    )
    pairs = 0.0
    for state in states:
        pairs += state.pairs
    assert state.converged
    return state, pairs


def step_time(wall, sphere, size, load):
    """Return the least time of a step of a path (ms)."""
    atoms = substrate("Cu", (size, size), sphere, spacing=1.0, fixed=False)
    atoms.calc = RoughContact(sphere, 1.0, wall)
    times, start = [], time.process_time()
    for _ in load_path(atoms, loads=load * 0.97 ** np.arange(20), window="unchecked"):
        times.append(time.process_time() - start)
        start = time.process_time()
    return 1e3 * np.median(times[1:])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=[16, 32, 64, 128])
    parser.add_argument("--repeat", type=int, default=20)
    options = parser.parse_args()
    rows = []
    for size in options.sizes:
        sphere = RoughSphere(10.0 * size, SelfAffine(0.1, 0.8, 4.0, 64.0, seed=0))
        heights = sphere.heights((size, size), 1.0, (-size / 2, -size / 2))
        load = 4.0 * (0.3 * size) ** 3 / (30.0 * size)
        halfspace = FreeHalfSpace((size, size), 1.0, 1.0)
        ones = np.ones((size, size))
        for name, wall in WALLS.items():
            near, _ = solution(wall, heights, 0.97 * load)
            ways = [(), (near.pressure, near.height)]
            cells = []
            for way in ways:
                pairs = solution(wall, heights, load, *way)[1]
                solve = partial(solution, wall, heights, load, *way)
                took = least_time(solve, options.repeat)
                pair = least_time(partial(halfspace.displacement, ones), 200)
                cells += [f"{took:.2f}", f"{pairs:.1f}", f"{took / pair:.0f}"]
            path = f"{step_time(wall, sphere, size, load):.2f}"
            rows.append((f"{size} × {size}", name, f"{pair:.3f}", *cells, path))
    head = "atoms | wall | convolution | cold | pairs | ratio | warm | pairs | ratio"
    table(f"{head} | step of a path", rows)


if __name__ == "__main__":
    main()
