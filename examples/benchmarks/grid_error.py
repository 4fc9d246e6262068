"""Error of the contact area that the grid makes, with and without the correction.

    python grid_error.py             # all that the table grid_error.csv lacks
    python grid_error.py --report    # errors, from the table

Spheres of radius 200 a0 and nominally flat surfaces, both with roughness from 4 to
32 a0, are pressed against a half space at the same loads on grids of spacing a0 to
a0/8. The wall is hard, or repulsive and as stiff as the solid. The reference is the
extrapolation of the two finest grids. Lengths are in a0, and the contact modulus is 1.
"""

import argparse
import csv
from collections import defaultdict
from itertools import product
from pathlib import Path

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
from ase_roughcontact.theory import Hertz
from ase_roughcontact.theory.counted_area import continuum_area

TABLE = Path(__file__).with_name("grid_error.csv")
CASE = ("shape", "wall", "slope", "hurst", "seed")
FIELDS = (*CASE, "load", "spacing", "area", "perimeter", "continuum", "penetration")
SPACINGS = (1.0, 0.5, 0.25, 0.125)
WALLS = {"hard": HardWall(), "repulsive": LennardJones93.repulsive(1.0, 1.0)}
# Hurst exponents and seeds from which the estimates of errors follow, and others that
# test them
FITTED = ((0.3, 1), (0.3, 2), (0.8, 1), (0.8, 2))
UNSEEN = ((0.5, 3), (0.5, 4))
RADIUS, SIDE = 200.0, 64
SPHERE = Hertz(RADIUS, 1.0)
# loads as those of a smooth sphere of these contact radii
CONTACT_RADII = np.array([6.0, 10.0, 16.0])
# mean pressures in units of slope times modulus, for contact from 1 to 90 %
PRESSURES = np.array([0.005, 0.05, 0.2, 0.5, 0.9, 1.4])


def cases():
    """Return shape, wall, slope, Hurst exponent and seed of each case."""
    # areas under a hard flat wall depend on pressure over slope alone
    flats = [("hard", 0.1), *(("repulsive", slope) for slope in (0.05, 0.1, 0.2))]
    spheres = product(WALLS, (0.05, 0.1, 0.2))
    for shape, choices in (("flat", flats), ("sphere", spheres)):
        for (wall, slope), (hurst, seed) in product(choices, FITTED + UNSEEN):
            yield shape, wall, slope, hurst, seed


def calculate(shape, wall, slope, hurst, seed, spacing):
    """Return the rows of the table for a case on one grid."""
    flat = shape == "flat"
    rough = SelfAffine(
        slope, hurst, 4.0, 32.0, seed=seed, domain=float(SIDE if flat else 128)
    )
    surface = RoughSphere(np.inf if flat else RADIUS, rough)
    loads = PRESSURES * slope * SIDE**2 if flat else SPHERE.force(CONTACT_RADII)
    points = round(SIDE / spacing) if flat else 8
    atoms = substrate(
        "Cu", (points, points), surface, spacing=spacing, periodic=flat, fixed=False
    )
    atoms.calc = RoughContact(surface, 1.0, WALLS[wall])
    window = "fixed" if flat else "auto"
    steps = load_path(atoms, loads=loads, window=window, validity="ignore")
    for number, step in enumerate(steps):
        values = (step.contact_area, step.perimeter, step.continuum_area)
        yield (
            *(shape, wall, slope, hurst, seed, number, spacing),
            *(f"{value:.8g}" for value in (*values, step.penetration)),
        )


def read():
    """Return the rows of the table."""
    if not TABLE.exists():
        return []
    with TABLE.open(newline="") as file:
        return list(csv.DictReader(file))


def run():
    """Calculate what the table lacks."""
    done = {tuple(row[name] for name in (*CASE, "spacing")) for row in read()}
    if not done:
        TABLE.write_text(",".join(FIELDS) + "\n", "utf-8")
    for spacing, case in product(SPACINGS, cases()):
        if tuple(map(str, (*case, spacing))) not in done:
            rows = list(calculate(*case, spacing))
            with TABLE.open("a", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows(rows)


def report():
    """Print the mean and largest errors in % on grids of a0, counted and corrected."""
    grids = defaultdict(dict)
    for row in read():
        state = tuple(row[name] for name in (*CASE, "load"))
        spacing, area = float(row["spacing"]), float(row["area"])
        correction = area - continuum_area(area, float(row["perimeter"]), spacing)
        grids[state][spacing] = area, correction, float(row["continuum"])
    errors = defaultdict(list)
    fine, finest = SPACINGS[-2:]
    for state, of_grid in grids.items():
        if finest not in of_grid:
            continue
        exact = 2 * of_grid[finest][2] - of_grid[fine][2]
        unseen = (float(state[3]), int(state[4])) in UNSEEN
        for spacing, (area, correction, _) in of_grid.items():
            both = area / exact - 1, (area - correction) / exact - 1
            errors[(unseen, *state[:2], state[5], spacing)].append(both)
    rows = []
    for shape, counts in (("flat", len(PRESSURES)), ("sphere", len(CONTACT_RADII))):
        for number in range(counts):
            cells = []
            for wall in WALLS:
                values = errors[False, shape, wall, str(number), 1.0]
                both = 100 * np.transpose(values)
                cells += [f"{e.mean():.2g}, {abs(e).max():.2g}" for e in both]
            name = f"mean pressure {PRESSURES[number]:g} $h'E^*$"
            if shape == "sphere":
                name = f"Hertz radius {CONTACT_RADII[number]:g} $a_0$"
            rows.append((f"{shape}, {name}", *cells))
    head = "contact | hard, counted | hard, corrected | repulsive, counted"
    table(f"{head} | repulsive, if corrected", rows)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--report", action="store_true", help="print the errors")
    if not parser.parse_args().report:
        run()
    report()
