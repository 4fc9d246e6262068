"""Smooth spheres under Dugdale's attraction against Maugis-Dugdale and JKR.

    python dugdale_spheres.py pull-off   # pull-off force beside both theories
    python dugdale_spheres.py area       # counted area beside Maugis-Dugdale

Lengths are in a0 and E* = 1. The sphere is relaxed at penetrations to both sides of
the largest tension of Maugis-Dugdale, and from there to a load of pi w R.
"""

import sys

import numpy as np
from markdown import table

from ase_roughcontact import (
    DugdaleWall,
    RoughContact,
    RoughSphere,
    load_path,
    substrate,
)
from ase_roughcontact.theory import JKR, MaugisDugdale
from ase_roughcontact.theory.counted_area import continuum_area

# radius, work of adhesion, range
PULL_OFF = (
    *((1000.0, 0.1, reach) for reach in (2.0, 1.4, 1.0, 0.8, 0.675)),
    (3500.0, 0.1, 1.0),
)
AREA = ((200.0, 0.005, 0.5), (200.0, 0.05, 0.8), (100.0, 0.05, 0.5), (400.0, 0.1, 1.0))
# beyond the penetration of the largest tension, in units of (w^2 R/E*^2)^(1/3)
NEAR = (1.0, 0.6, *np.arange(0.42, -0.1, -0.03))
DEEP = np.linspace(2.0, 0.2, 10)


def steps_of(radius, work, reach, offsets):
    """Return the relaxed steps, and the theory of Maugis and Dugdale."""
    theory = MaugisDugdale(radius, 1.0, work, reach)
    *_, depth = theory.state(theory.stability_limit("load"))
    sphere = RoughSphere(radius)
    atoms = substrate("Cu", (16, 16), sphere, spacing=1.0)
    atoms.calc = RoughContact(sphere, 1.0, DugdaleWall(work, reach))
    depths = depth + np.cbrt(work**2 * radius) * np.array(offsets)
    options = {"window": "auto", "validity": "ignore"}
    return list(load_path(atoms, penetrations=depths, **options)), theory


def pull_off():
    """Print by how many per cent the pull-off exceeds that of JKR."""
    rows = []
    for case in PULL_OFF:
        radius, work, reach = case
        steps, theory = steps_of(*case, NEAR)
        jkr = JKR(radius, 1.0, work).pull_off_force
        found = -min(step.normal_force for step in steps)
        excess = 100.0 * (np.array([theory.pull_off_force, found]) / jkr - 1.0)
        zone = np.pi * reach**2 / (4.0 * work)
        cells = f"{theory.parameter:.2f}", f"{zone:.2g}"
        rows.append((f"{radius:g}", f"{reach:g}", *cells, *np.round(excess, 1)))
    table("$R$ | $D$ | Maugis parameter | $\\pi E^* D^2/4w$ | theory | wall", rows)


def area():
    """Print the excess of the counted area, in units of the correction."""
    rows = []
    for case in AREA:
        steps, theory = steps_of(*case, DEEP)
        parts = []
        for step in steps:
            exact = np.pi * float(theory.contact_radius(step.normal_force)) ** 2
            counted = step.contact_area
            correction = counted - continuum_area(counted, step.perimeter, 1.0)
            parts.append((counted - exact) / correction)
        rows.append((*case, *np.round([theory.parameter, np.mean(parts)], 2)))
    table("$R$ | $w$ | $D$ | Maugis parameter | excess over the correction", rows)


if __name__ == "__main__":
    for study in sys.argv[1:] or ("pull-off", "area"):
        {"pull-off": pull_off, "area": area}[study]()
