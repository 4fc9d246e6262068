"""FFT pairs of walls with attraction, from a cold start.

    python examples/benchmarks/hard_adhesion.py [SIZE ...]

A rough sphere of radius 10 n on n x n points, lengths in a0 and E* = 1.
"""

import sys
from itertools import product

from markdown import table

from ase_roughcontact import (
    DugdaleWall,
    ExponentialWall,
    LennardJones93,
    PowerLawWall,
    RoughSphere,
    SelfAffine,
)
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.solvers.soft.newton import newton_krylov

WALLS = {
    "repulsive": LennardJones93.repulsive(1.0, 1.0),
    "adhesive, $w$ = 0.005": LennardJones93.adhesive(1.0, 1.0, 0.005),
    "exponential, $w$ = 0.005, $D$ = 0.5": ExponentialWall(0.005, 0.5),
    "exponential, $w$ = 0.05, $D$ = 1": ExponentialWall(0.05, 1.0),
    "power law, $w$ = 0.02, $D$ = 0.5": PowerLawWall(0.02, 0.5),
    "Dugdale, $w$ = 0.02, $D$ = 0.5": DugdaleWall(0.02, 0.5),
}


BOUNDARIES = {"free": FreeHalfSpace, "periodic": PeriodicHalfSpace}


def pairs(wall, kind, n):
    """Return the FFT pairs of a cold start."""
    roughness = SelfAffine(0.1, 0.8, 4.0, float(n), seed=1)
    corner = (-(n - 1) / 2, -(n - 1) / 2)
    heights = RoughSphere(10.0 * n, roughness).heights((n, n), 1.0, corner)
    load = 4.0 / 3.0 * (0.3 * n) ** 3 / (10.0 * n)
    *_, last = states = list(
        newton_krylov(
            Contact(kind((n, n), 1.0, 1.0), heights, wall),
            height=0.0,
            external=lambda z: (load * z, -load),
            start=None,
            tolerance=1e-6,
        )
    )
    if not last.converged:
        raise RuntimeError(last.message)
    return sum(state.pairs for state in states)


def main(sizes):
    """Print one line for each wall."""
    columns = list(product(sizes, BOUNDARIES))
    head = ["wall", *(f"{boundary}, {n}" for n, boundary in columns)]
    rows = [
        (name, *(f"{pairs(wall, BOUNDARIES[b], n):.0f}" for n, b in columns))
        for name, wall in WALLS.items()
    ]
    table(" | ".join(head), rows)


if __name__ == "__main__":
    main([int(size) for size in sys.argv[1:]] or [256, 512])
