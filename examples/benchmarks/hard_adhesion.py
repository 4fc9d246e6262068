"""FFT pairs and time of walls with attraction, for the page on the solvers.

python examples/benchmarks/hard_adhesion.py [SIZE ...]
"""

import sys
import time

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
from ase_roughcontact.solvers.newton import newton_krylov

WALLS = {
    "repulsive": LennardJones93.repulsive(1.0, 1.0),
    "adhesive, w = 0.005": LennardJones93.adhesive(1.0, 1.0, 0.005),
    "exponential, w = 0.005, D = 0.5": ExponentialWall(0.005, 0.5),
    "exponential, w = 0.05, D = 1": ExponentialWall(0.05, 1.0),
    "power law, w = 0.02, D = 0.5": PowerLawWall(0.02, 0.5),
    "Dugdale, w = 0.02, D = 0.5": DugdaleWall(0.02, 0.5),
}


def main(sizes):
    """Print one line for each wall, boundary and size."""
    print("wall | atoms | boundary | steps | pairs | seconds of the processor")
    for n in sizes:
        roughness = SelfAffine(0.1, 0.8, 4.0, float(n), seed=1)
        corner = (-(n - 1) / 2, -(n - 1) / 2)
        heights = RoughSphere(10.0 * n, roughness).heights((n, n), 1.0, corner)
        load = 4.0 / 3.0 * (0.3 * n) ** 3 / (10.0 * n)
        for name, wall in WALLS.items():
            for kind in (FreeHalfSpace, PeriodicHalfSpace):
                contact = Contact(kind((n, n), 1.0, 1.0), heights, wall)
                start = time.process_time()
                states = list(
                    newton_krylov(
                        contact,
                        height=0.0,
                        external=lambda z, load=load: (load * z, -load),
                        start=None,
                        tolerance=1e-6,
                    )
                )
                seconds = time.process_time() - start
                pairs = sum(state.pairs for state in states)
                boundary = "periodic" if contact.halfspace.periodic else "free"
                note = "" if states[-1].converged else states[-1].message
                print(
                    f"{name} | {n} | {boundary} | {len(states)} | {pairs:.0f} | "
                    f"{seconds:.2f} | {note}"
                )


main([int(size) for size in sys.argv[1:]] or [256, 512])
