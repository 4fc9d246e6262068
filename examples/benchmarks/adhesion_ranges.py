"""Pull-off and hysteresis of rough spheres over the range of hard walls' attraction.

    python adhesion_ranges.py             # all loops that adhesion_ranges.csv lacks
    python adhesion_ranges.py --report    # means over the seeds, from the table

A sphere of radius 100 a0 with roughness from 8 to 32 a0 approaches, is pressed in by
half of (w^2 R/E*^2)^(1/3), and pulled off, under three walls with the same work of
adhesion w = 0.05 E* a0 and ranges D from a0/2 to 2 a0. Lengths are in a0 and E* = 1.
"""

import argparse
import csv
from collections import defaultdict
from itertools import product
from pathlib import Path

import numpy as np
from markdown import table

from ase_roughcontact import (
    DugdaleWall,
    ExponentialWall,
    PowerLawWall,
    RoughContact,
    RoughSphere,
    SelfAffine,
    adhesion_loop,
    substrate,
)
from ase_roughcontact.theory import MaugisDugdale, RoughSphereTheory

TABLE = Path(__file__).with_suffix(".csv")
RADIUS, WORK = 100.0, 0.05
UNIT = np.cbrt(WORK**2 * RADIUS)
WALLS = {
    "Dugdale": DugdaleWall,
    "exponential": ExponentialWall,
    "power law": PowerLawWall,
}
# the cutoff of the power law at D = 2 is 40 a0
RANGES = {
    "Dugdale": (0.5, 1.0, 2.0),
    "exponential": (0.5, 1.0, 2.0),
    "power law": (0.5, 1.0),
}
SLOPES, SEEDS = (0.1,), (1, 2, 3, 5)
CASE = ("wall", "range", "slope", "seed")
FIELDS = (*CASE, "pull-off", "area", "lost", "states", "pairs", "converged")


def main():
    """Calculate what is missing, and print the means."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--table", type=Path, default=TABLE)
    parser.add_argument("--report", action="store_true")
    options = parser.parse_args()
    known = {} if not options.table.exists() else read(options.table)
    cases = [("Dugdale", reach, 0.0, 0) for reach in RANGES["Dugdale"]]
    cases += [
        (wall, reach, slope, seed)
        for seed, slope, (wall, ranges) in product(SEEDS, SLOPES, RANGES.items())
        for reach in ranges
    ]
    for case in cases:
        if not options.report and tuple(map(str, case)) not in known:
            append(options.table, case, loop_of(*case))
    report(read(options.table))


def roughness(slope, seed):
    """Return the roughness of the sphere; None if it is smooth."""
    return SelfAffine(slope, 0.8, 8.0, 32.0, seed=seed) if slope else None


def loop_of(wall, reach, slope, seed):
    """Return pull-off force, largest area, energy lost and cost of a loop."""
    sphere = RoughSphere(RADIUS, roughness(slope, seed))
    atoms = substrate("Cu", (16, 16), sphere, spacing=1.0)
    atoms.calc = RoughContact(sphere, 1.0, WALLS[wall](WORK, reach))
    options = {"window": "auto", "validity": "ignore", "tolerance": 3e-3}
    loop = adhesion_loop(atoms, deepest=0.5 * UNIT, step=0.5 * UNIT, **options)
    steps = (*loop.approach, *loop.retraction)
    return (
        loop.pull_off_force / (np.pi * WORK * RADIUS),
        loop.approach[-1].contact_area,
        loop.dissipated_energy / np.cbrt(WORK**5 * RADIUS**4),
        len(steps),
        sum(step.pairs for step in steps),
        all(step.converged for step in steps),
    )


def report(rows):
    """Print means and standard deviations over the seeds, beside theory."""
    groups = defaultdict(list)
    for (wall, reach, slope, _), row in rows.items():
        groups[slope, wall, float(reach)].append(row)
    lines = []
    for (slope, wall, reach), found in sorted(groups.items()):
        rough = float(slope) > 0.0
        values = {n: np.array([float(row[n]) for row in found]) for n in FIELDS[4:9]}
        cells = [f"{'rough' if rough else 'smooth'}, {wall}", f"{reach:g}"]
        for name, digits in (("pull-off", 2), ("theory", 2), ("area", 0), ("lost", 2)):
            if name == "theory":
                cells.append(f"{theory(float(slope), reach):.2f}")
                continue
            mean, spread = values[name].mean(), values[name].std()
            cell = f"{mean:.{digits}f}"
            cells.append(f"{cell} ± {spread:.{digits}f}" if rough else cell)
        lines.append((*cells, f"{values['states'].mean():.0f}"))
    table(
        "sphere, wall | $D$ | pull-off$/\\pi w R$ | theory | largest area | energy lost"
        " | states",
        lines,
    )


def theory(slope, reach):
    """Return the pull-off force of a smooth sphere with the effective w."""
    smooth = MaugisDugdale(RADIUS, 1.0, WORK, reach)
    if slope:
        rough = RoughSphereTheory(RADIUS, 1.0, roughness(slope, 1), WORK, reach)
        work = rough.effective_work_of_adhesion
        # the tension is that of the wall
        smooth = MaugisDugdale(RADIUS, 1.0, work, reach * work / WORK)
    return smooth.pull_off_force / (np.pi * WORK * RADIUS)


def read(table):
    """Return the rows of the table by their cases."""
    with table.open(newline="") as file:
        return {tuple(row[k] for k in CASE): row for row in csv.DictReader(file)}


def append(table, case, result):
    """Add a row to the table."""
    new = not table.exists()
    with table.open("a", newline="") as file:
        writer = csv.writer(file)
        if new:
            writer.writerow(FIELDS)
        writer.writerow((*case, *result))


if __name__ == "__main__":
    main()
