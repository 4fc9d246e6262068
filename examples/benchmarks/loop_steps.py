"""Loops with default steps against loops with steps ten times finer, random settings.

    python loop_steps.py             # all settings that loop_steps.csv lacks
    python loop_steps.py --report    # differences for each wall

For each wall with attraction 40 spheres, a third of them rough, with Tabor numbers from
0.1 to 2.5; lengths in units of the spacing, pressures of the contact modulus. The fine
loops have steps of a tenth and a tenth of the tolerance.
"""

import argparse
import csv
from pathlib import Path

import numpy as np
from markdown import table

from ase_roughcontact import (
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    adhesion_loop,
    substrate,
)
from ase_roughcontact.interactions import DugdaleWall, ExponentialWall, PowerLawWall
from ase_roughcontact.path_kinds.loop.specification import default_step

WALLS = ("adhesive", "full", "dugdale", "exponential", "power-law")
SEEDS = range(40)
TABLE = Path(__file__).with_name("loop_steps.csv")
CASE = ("wall", "seed")
VALUES = ("pull-off", "snap-in", "lost", "jumps in", "jumps out", "states")
FIELDS = (*CASE, *VALUES, *(f"fine {name}" for name in VALUES), "energy")


def random_setting(kind, seed):
    """Return sphere, wall and deepest penetration."""
    rng = np.random.default_rng(seed)
    reach, exponent = 10 ** rng.uniform(-0.7, 0.5), rng.choice([1.5, 2.0, 3.0, 5.0])
    ends = {"full": (0.3, 1.1), "exponential": (0.7, 1.7), "power-law": (0.7, 1.7)}
    cutoff = 10 ** rng.uniform(*ends.get(kind, (0.08, 0.08)))
    radius = max(10 ** rng.uniform(1.2, 1.8) / (cutoff * reach + 0.5), 6.0)
    tabor = 10 ** rng.uniform(-1.0, 0.4)
    work = np.sqrt(tabor**3 * reach**3 / radius)
    work = min(work, reach**2 / (20 if kind == "full" else 10))  # else many jumps
    depth = max(np.cbrt(work**2 * radius), 0.2 * reach)
    walls = {
        "adhesive": lambda: LennardJones93.adhesive(
            1.0, 1.0, work, stiffness=12 * work / reach**2
        ),
        "full": lambda: LennardJones93.full(
            distance=reach, work_of_adhesion=work, cutoff=cutoff * reach
        ),
        "dugdale": lambda: DugdaleWall(work, reach),
        "exponential": lambda: ExponentialWall(work, reach, cutoff),
        "power-law": lambda: PowerLawWall(work, reach, exponent, cutoff),
    }
    rough = SelfAffine(reach * rng.uniform(0.03, 0.3), 0.8, 4.0, 16.0, seed=seed)
    sphere = RoughSphere(radius, rough if rng.random() < 0.3 else None)
    return sphere, walls[kind](), rng.uniform(0.3, 2.0) * depth


def loop_of(sphere, wall, deepest, finer=1.0, tolerance=1e-3):
    """Return an adhesion loop."""
    atoms = substrate("Cu", (12, 12), sphere, spacing=1.0)
    atoms.calc = RoughContact(sphere, contact_modulus=1.0, wall=wall)
    step = default_step(wall, deepest) / finer
    options = {"window": "auto", "validity": "ignore", "tolerance": tolerance}
    return adhesion_loop(atoms, deepest=deepest, step=step, **options)


def values_of(loop):
    """Return the values of a loop; snap-in is the largest tension on approach."""
    _, approach = loop.curve("approach")
    return (
        loop.pull_off_force,
        -approach.min(),
        loop.dissipated_energy,
        len(loop.approach_jumps),
        len(loop.retraction_jumps),
        len(loop.approach) + len(loop.retraction),
    )


def run():
    """Calculate what is missing."""
    if not TABLE.exists():
        TABLE.write_text(",".join(FIELDS) + "\n", "utf-8")
    with TABLE.open(newline="") as file:
        known = {(row["wall"], int(row["seed"])) for row in csv.DictReader(file)}
    for seed in SEEDS:
        for kind in WALLS:
            if (kind, seed) in known:
                continue
            setting = random_setting(kind, seed)
            fine = loop_of(*setting, finer=10.0, tolerance=1e-4)
            energy = max(step.energy for step in fine.approach)
            energy -= min(step.energy for step in fine.approach)
            row = kind, seed, *values_of(loop_of(*setting)), *values_of(fine), energy
            with TABLE.open("a", newline="") as file:
                csv.writer(file).writerow(row)


def report():
    """Print median and largest difference in %, of energies to the largest change."""
    with TABLE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    lines = []
    for kind in WALLS:
        chosen = [row for row in rows if row["wall"] == kind]
        columns = {
            name: np.array([float(row[name]) for row in chosen]) for name in FIELDS[2:]
        }
        differences = [
            100.0 * abs(columns[name] - columns[f"fine {name}"]) / columns[scale]
            for name, scale in (
                ("pull-off", "pull-off"),
                ("snap-in", "snap-in"),
                ("lost", "energy"),
            )
        ]
        states = [columns[name].sum() for name in ("states", "fine states")]
        lines.append(
            (
                kind,
                len(chosen),
                *(f"{np.median(d):.1g}, {d.max():.2g}" for d in differences),
                "{:.0f}, {:.0f}".format(*states),
            )
        )
    table(
        "wall | settings | pull-off force | largest tension on approach | "
        "energy lost | states, fine",
        lines,
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--report", action="store_true", help="print the table")
    if not parser.parse_args().report:
        run()
    report()
