"""Smallest tolerances that the solvers reach, limited by rounding errors.

    OMP_NUM_THREADS=1 python rounding.py

Tolerances of the forces fall from 1e-3 in half decades until a relaxation does not
converge. The surface is a
rough sphere of radius 100 a0 on a free half space, or a rough flat on a periodic one,
with an rms slope of 0.1, under a mean pressure of 0.02 E*. Lengths are in a0, and the
contact modulus is 1.
"""

from itertools import product

import numpy as np
from markdown import order, table

from ase_roughcontact import HardWall, LennardJones93, RoughSphere, SelfAffine
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.solvers.soft.newton import newton_krylov

WALLS = {
    "repulsive": LennardJones93.repulsive(1.0, 1.0),
    "adhesive": LennardJones93.adhesive(1.0, 1.0, 0.02),
    "hard": HardWall(),
}
PRESSURE = 0.02
SIDES = (32, 128)


def contact_of(wall, dtype, side, periodic):
    """Return a rough contact that is not relaxed."""
    rough = SelfAffine(0.1, 0.8, 4.0, 16.0, seed=1, domain=float(side))
    surface = rough if periodic else RoughSphere(100.0, rough)
    kind = PeriodicHalfSpace if periodic else FreeHalfSpace
    halfspace = kind((side, side), 1.0, 1.0, dtype=dtype)
    heights = surface.heights((side, side), 1.0, (-side // 2, -side // 2))
    return Contact(halfspace, heights, WALLS[wall])


def converges(contact, tolerance):
    """Return whether a relaxation reaches a tolerance of the forces."""
    load = PRESSURE * contact.heights.size
    solver = active_set if contact.wall.hard else newton_krylov
    *_, last = solver(
        contact,
        height=contact.first_contact,
        start=None,
        external=lambda height: (load * height, -load),
        tolerance=tolerance,
    )
    return last.converged


def smallest_tolerance(contact):
    """Return the last tolerance that is reached, None if there is none."""
    reached = None
    for tolerance in 10.0 ** -np.arange(3.0, 17.5, 0.5):
        if not converges(contact, tolerance):
            break
        reached = tolerance
    return reached


def show_tolerances():
    """Print the smallest tolerances."""
    rows = []
    for dtype, wall in product(("float64", "float32"), WALLS):
        cells = []
        for side, periodic in product(SIDES, (False, True)):
            reached = smallest_tolerance(contact_of(wall, dtype, side, periodic))
            cells.append("none" if reached is None else order(reached))
        rows.append((wall, dtype, *cells))
    names = [f"{k}, {n}" for n in SIDES for k in ("free", "periodic")]
    table(f"wall | precision | {' | '.join(names)}", rows)


if __name__ == "__main__":
    show_tolerances()
