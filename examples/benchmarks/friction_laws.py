"""FFT pairs of a step with friction: slip-weakening, rate and state, and Coulomb.

    python friction_laws.py

prints a table in Markdown. A smooth sphere under a hard wall slides in three cases.
Coulomb friction and slip-weakening have a step at each displacement that the time steps
of rate and state friction reach.
"""

import numpy as np
from markdown import table

from ase_roughcontact import (
    Coulomb,
    HardWall,
    Isotropic,
    RateAndState,
    RoughContact,
    RoughSphere,
    Schedule,
    SlipWeakening,
    sliding_path,
    substrate,
)

# Diameters of the contact and ways of the sphere (Å), about.
CASES = ((16, 0.4), (32, 0.8), (32, 1.4), (64, 1.6))
RATE_AND_STATE = RateAndState(0.3, 0.01, 0.015, distance=0.5, velocity=1.0)
WEAKENING = SlipWeakening(Coulomb(0.3), 0.8, 0.5)


def slid(side, law, displacements):
    """Return the steps of a sphere that slides."""
    sphere = RoughSphere(radius=10.0 * side)
    atoms = substrate("Cu", (side, side), sphere, spacing=1.0)
    solid = Isotropic(1.0, poisson=0.3)
    atoms.calc = RoughContact(sphere, solid=solid, wall=HardWall())
    path = sliding_path(
        atoms,
        law,
        penetrations=0.02 * side,
        displacements=displacements,
        window="auto",
    )
    return list(path)


def pairs(steps):
    """Return the mean FFT pairs of friction of the steps after the first one."""
    return np.mean([step.friction_pairs for step in steps[1:]])


def main():
    """Print the table."""
    rows = []
    for side, way in CASES:
        in_time = slid(side, RATE_AND_STATE, Schedule(0.0).ramp(way, rate=1.0))
        displacements = [step.lateral_x for step in in_time]
        coulomb = pairs(slid(side, Coulomb(0.3), displacements))
        others = pairs(slid(side, WEAKENING, displacements)), pairs(in_time)
        texts = (f"{each:.1f} ({each / coulomb:.2f})" for each in others)
        rows.append([side, way, len(in_time) - 1, f"{coulomb:.1f}", *texts])
    head = "diameter (Å) | way (Å) | steps | Coulomb | slip-weakening | rate and state"
    table(head, rows)


if __name__ == "__main__":
    main()
