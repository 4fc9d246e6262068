"""Energy lost by a rough sphere on a homogeneous surface, over depth, step and spacing.

    python rough_hysteresis.py             # all loops that rough_hysteresis.csv lacks
    python rough_hysteresis.py --report    # the table of the guide, from its rows

A sphere of radius 200 a0 with random roughness from 12 to 24 a0 and a hard wall with
Dugdale's attraction, w = 0.1 E* a0 and D = 0.8 a0. The energy lost by a smooth sphere,
which jumps in and out once, does not depend on the depth at which it turns; that of a
rough one grows with the area that its edge sweeps. Depths and steps are in units of
(w^2 R/E*^2)^(1/3), energies of (w^5 R^4/E*^2)^(1/3).
"""

import argparse
import csv
from pathlib import Path

import numpy as np
from markdown import table

from ase_roughcontact import (
    DugdaleWall,
    RoughContact,
    RoughSphere,
    SelfAffine,
    adhesion_loop,
    substrate,
)

RADIUS, WORK, RANGE = 200.0, 0.1, 0.8
TABLE = Path(__file__).with_name("rough_hysteresis.csv")
CASE = ("slope", "seed", "depth", "step", "spacing")
FIELDS = (*CASE, "lost", "jumps in", "jumps out", "pull-off", "states", "converged")
CASES = (
    *((slope, seed, depth, 0.5, 1.0) for slope, seed in ((0.0, 0), (0.2, 1), (0.2, 2))
      for depth in (0.5, 2.0)),
    (0.2, 1, 2.0, 0.25, 1.0),
    (0.2, 1, 2.0, 0.5, 0.5),
)  # fmt: skip


def loop_of(slope, seed, depth, step, spacing):
    """Return an adhesion loop."""
    rough = None
    if slope:
        rough = SelfAffine(slope, 0.8, 12.0, 24.0, seed=seed, domain=192.0)
    sphere = RoughSphere(RADIUS, rough)
    atoms = substrate("Cu", (16, 16), sphere, spacing=spacing)
    atoms.calc = RoughContact(sphere, 1.0, DugdaleWall(WORK, RANGE))
    unit = np.cbrt(WORK**2 * RADIUS)
    options = {"window": "auto", "validity": "ignore", "tolerance": 3e-3}
    return adhesion_loop(atoms, deepest=depth * unit, step=step * unit, **options)


def run():
    """Calculate what is missing."""
    if not TABLE.exists():
        TABLE.write_text(",".join(FIELDS) + "\n", "utf-8")
    with TABLE.open(newline="") as file:
        known = {tuple(float(row[k]) for k in CASE) for row in csv.DictReader(file)}
    for case in CASES:
        if case in known:
            continue
        loop = loop_of(*case)
        steps = (*loop.approach, *loop.retraction)
        with TABLE.open("a", newline="") as file:
            csv.writer(file).writerow(
                (
                    *case,
                    loop.dissipated_energy / np.cbrt(WORK**5 * RADIUS**4),
                    len(loop.approach_jumps),
                    len(loop.retraction_jumps),
                    loop.pull_off_force / (np.pi * WORK * RADIUS),
                    len(steps),
                    all(step.converged for step in steps),
                )
            )


def report():
    """Print the table of the guide."""
    with TABLE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    head = "sphere | depth | step | spacing | energy lost | jumps in, out"
    table(
        head + r" | pull-off$/\pi w R$",
        (
            (
                f"rough, seed {row['seed']}" if float(row["slope"]) else "smooth",
                *(f"{float(row[name]):g}" for name in ("depth", "step", "spacing")),
                f"{float(row['lost']):.2f}",
                f"{row['jumps in']}, {row['jumps out']}",
                f"{float(row['pull-off']):.2f}",
            )
            for row in rows
        ),
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--report", action="store_true", help="print the table")
    if not parser.parse_args().report:
        run()
    report()
