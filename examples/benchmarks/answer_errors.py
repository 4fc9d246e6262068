"""True errors of area, force and height, beside their estimates.

    python answer_errors.py                    # all that answer_errors.csv lacks
    python answer_errors.py --study cell       # one study
    python answer_errors.py --errors           # errors and estimates, from the table
    python answer_errors.py --draw             # the picture
    python answer_errors.py --report           # largest errors of the levels

*tolerance*: the model of atoms with loose tolerances, against a tight one.
*cell*: periodic cells of 2 to 4 diameters of the contact, against a free boundary.
*adhesive cell*: cells of 2 to 6 diameters by Hertz under adhesive walls, likewise.
*grid*: the continuum on grids of a0 and a0/2, against the limit of a0/4 and a0/8.
*levels*: larger contacts at the levels of accuracy, against the same.
*adhesion*: the same under adhesive walls, against the limit of a0/8 and a0/16.

Spheres have a radius of 200 a0 and roughness from 4 to 32 a0, for the levels 1000 and
4000 a0 and 4 to 128 a0. Works of adhesion are 0.01 and 0.05 E* a0. The spheres are
relaxed at a load and at a height. Lengths are in a0, and the contact modulus is 1.
"""

import argparse
import csv
import time
from collections import defaultdict
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
from markdown import table
from matplotlib.figure import Figure

from ase_roughcontact import (
    HardWall,
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    substrate,
)
from ase_roughcontact._util.threads import threads
from ase_roughcontact.plot import COLOURS
from ase_roughcontact.stepping.accuracy import LEVELS
from ase_roughcontact.theory import Hertz

IMAGE = Path(__file__).parents[1] / "images" / "accuracy.png"
TABLE = Path(__file__).with_name("answer_errors.csv")
CASE = ("study", "wall", "radius", "slope", "hurst", "seed", "contact", "setting")
# area and height at a load, area and force at a height
ANSWERS = ("area", "height", "area_at_height", "force")
FIELDS = (*CASE, *(n + part for n in ANSWERS for part in ("", "_error")), "cpu")
WALLS = {"hard": HardWall(), "repulsive": LennardJones93.repulsive(1.0, 1.0)}
ADHESIVE = {f"w = {w}": LennardJones93.adhesive(1.0, 1.0, w) for w in (0.01, 0.05)}
SLOPES = (0.05, 0.1)
# not those from which the estimates follow (grid_error.py): Hurst exponent and seed
UNSEEN = ((0.6, 11), (0.6, 12), (0.7, 13))
# from errors of cells with those seeds a term of the estimate follows
UNSEEN_IN_CELLS = ((0.55, 21), (0.65, 22), (0.75, 23))
SETTINGS = {
    "tolerance": {
        "0.1": {"accuracy": 0.1},
        "0.01": {"accuracy": 0.01},
        "exact": {"accuracy": 1e-10},
    },
    "cell": {"2": {}, "3": {}, "4": {}, "exact": {}},
    "adhesive cell": {"2": {}, "3": {}, "4": {}, "6": {}, "exact": {}},
    "grid": {grid: {"grid": grid} for grid in ("a0", "a0/2", "a0/4", "a0/8")},
    "levels": {
        **{name: {"accuracy": name} for name in ("fast", "normal", "high")},
        "a0/4": {"grid": "a0/4", "accuracy": 1e-6},
        "a0/8": {"grid": "a0/8", "accuracy": 1e-6},
    },
}
SETTINGS["adhesion"] = {
    **SETTINGS["levels"],
    "a0/16": {"grid": "a0/16", "accuracy": 1e-6},
}
# Grids from which limits are extrapolated, and all that others are compared with.
GRIDS = ("a0/4", "a0/8", "a0/16")
REFERENCES = ("exact", *GRIDS)


def cases(study):
    """Return wall, radius, slope, Hurst exponent, seed, contact radius of each case."""
    if study == "levels":
        for seed, hurst, radius, wall in product(
            (2, 3), (0.8, 0.5), (1000.0, 4000.0), WALLS
        ):
            yield wall, radius, 0.1, hurst, seed, 128.0
        return
    if study == "adhesion":
        seeds, contacts = (
            ((0.8, 31), (0.6, 32), (0.7, 33), (0.5, 34)),
            (8.0, 14.0, 20.0),
        )
        for contact, wall, (hurst, seed) in product(contacts, ADHESIVE, seeds):
            yield wall, 200.0, 0.1, hurst, seed, contact
        return
    unseen = UNSEEN_IN_CELLS if study == "cell" else UNSEEN
    walls = ADHESIVE if "adhesive" in study else WALLS
    for wall, slope, (hurst, seed), contact in product(
        walls, SLOPES, unseen, (8.0, 14.0)
    ):
        yield wall, 200.0, slope, hurst, seed, contact


def calculate(study, wall, radius, slope, hurst, seed, contact, setting):
    """Return the row of a case."""
    longest, domain = (128.0, 512.0) if study == "levels" else (32.0, 128.0)
    domain *= 2.0 if "adhesi" in study else 1.0
    rough = SelfAffine(slope, hurst, 4.0, longest, seed=seed, domain=domain)
    sphere = RoughSphere(radius, rough)
    cell = int(setting) if "cell" in study and setting != "exact" else 0
    options = dict(SETTINGS[study][setting], window="fixed" if cell else "auto")
    column = "contact_area"
    if study in ("grid", "levels", "adhesion"):
        options.setdefault("grid", "continuum")
        if setting not in REFERENCES or by_edge(study, wall):
            column = "continuum_area"
    side = int(2 * contact * cell) if cell else 8

    def relaxed(**target):
        fixed, periodic = "heights" in target, cell > 0
        atoms = substrate(
            "Cu", (side, side), sphere, spacing=1.0, periodic=periodic, fixed=fixed
        )
        atoms.calc = RoughContact(sphere, 1.0, (WALLS | ADHESIVE)[wall])
        (step,) = load_path(atoms, **target, **options, validity="ignore")
        return step

    start = time.process_time()
    step = relaxed(loads=[Hertz(radius, 1.0).force(contact)])
    cpu = time.process_time() - start
    row = [getattr(step, column), step.area_error, step.height, step.height_error]
    if study in ("levels", "adhesion", "adhesive cell"):
        row += [np.nan] * 4
    else:
        step = relaxed(heights=[usual_height(wall, sphere, contact)])
        row += [getattr(step, column), step.area_error]
        row += [step.normal_force, step.force_error]
    case = (study, wall, radius, slope, hurst, seed, contact, setting)
    return [*case, *(f"{value:.9g}" for value in row), f"{cpu:.3g}"]


def by_edge(study, wall):
    """Return whether references are areas by the fields at the edge, and not counts.

    Counts are exact enough in large contacts only, and have another source there.
    """
    return study == "grid" and wall == "hard"


@cache
def usual_height(wall, sphere, contact):
    """Return the height of the model of atoms at the load."""
    atoms = substrate("Cu", (8, 8), sphere, spacing=1.0, fixed=False)
    atoms.calc = RoughContact(sphere, 1.0, WALLS[wall])
    load = Hertz(sphere.radius, 1.0).force(contact)
    (step,) = load_path(atoms, loads=[load], window="auto", validity="ignore")
    return round(step.height, 6)


def read():
    """Return the rows of the table."""
    if not TABLE.exists():
        return []
    with TABLE.open(newline="") as file:
        return list(csv.DictReader(file))


def run(studies):
    """Calculate what the table lacks."""
    done = {tuple(row[name] for name in CASE) for row in read()}
    if not done:
        TABLE.write_text(",".join(FIELDS) + "\n", "utf-8")
    for study in studies:
        for case, setting in product(cases(study), SETTINGS[study]):
            if tuple(map(str, (study, *case, setting))) in done:
                continue
            with threads(1):
                row = calculate(study, *case, setting)
            with TABLE.open("a", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow(row)


def compared(rows):
    """Return errors, estimates and times by study, setting, answer and wall."""
    of_case = defaultdict(dict)
    for row in rows:
        of_case[tuple(row[name] for name in CASE[:-1])][row["setting"]] = row
    found = defaultdict(list)
    for case, settings in of_case.items():
        for name, setting in product(ANSWERS, settings):
            row, exact = settings[setting], reference(case, settings, name)
            if setting in REFERENCES or not np.isfinite(exact):
                continue
            scale = 1.0 if name == "height" else exact
            error = abs(float(row[name]) - exact) / scale
            estimate = float(row[f"{name}_error"]) / scale
            if np.isfinite(estimate):
                values = error, estimate, float(row["cpu"])
                found[(case[0], setting, name, case[1])].append(values)
    return found


def reference(case, settings, name):
    """Return the exact answer, extrapolated for grids; NaN if it is not known."""
    if "exact" in settings:
        return float(settings["exact"][name])
    finest = [key for key in GRIDS if key in settings][-2:]
    if not finest:
        return np.nan
    coarse, fine = (float(settings[key][name]) for key in finest)
    # counts are wrong in proportion to the spacing, the others to about its square
    order = 1.0 if "area" in name and not by_edge(*case[:2]) else 2.0
    return fine + (fine - coarse) / (2.0**order - 1.0)


def print_errors():
    """Print the share of errors within twice the estimate, and their sizes."""
    print(
        "study, setting, answer, wall: cases, errors within twice the estimate, sizes"
    )
    for key, errors in compared(read()).items():
        true, estimate, _ = np.transpose(errors)
        print(
            f"{' '.join(key):44}{len(true):3d}{np.mean(true <= 2.0 * estimate):6.2f}"
            f"   median {np.median(true):.1e}, largest {true.max():.1e}, "
            f"estimate {np.median(estimate):.1e}"
        )


def report():
    """Print the largest errors of the area by level, and the mean time."""
    found, rows = compared(read()), []
    for name, study, walls in (
        ("hard", "levels", ["hard"]),
        ("repulsive", "levels", ["repulsive"]),
        ("adhesive", "adhesion", ADHESIVE),
    ):
        errors, times = [], []
        for level in LEVELS:
            cases = [case for w in walls for case in found[study, level, "area", w]]
            true, _, seconds = np.transpose(cases)
            errors.append(f"{100 * true.max():.2g} %")
            times.append(f"{seconds.mean():.2g} s")
        rows.append((name, *errors, *times))
    heads = "wall | largest error: fast | normal | high"
    table(f"{heads} | CPU time: fast | normal | high", rows)


def draw():
    """Draw the error of the area against the time, by level and wall."""
    figure = Figure(figsize=(5, 4), layout="constrained")
    axes = figure.subplots()
    errors = compared(read())
    for (wall, marker), (level, colour) in product(
        (("hard", "o"), ("repulsive", "s")), zip(LEVELS, COLOURS, strict=False)
    ):
        true, _, seconds = np.transpose(errors["levels", level, "area", wall])
        face = "none" if wall == "hard" else colour
        label = f"{level}, {wall} wall"
        axes.plot(seconds, true, marker, color=colour, mfc=face, label=label)
        axes.axhline(LEVELS[level], color=colour, lw=0.8, ls=":")
        goal = f"{level}: {100 * LEVELS[level]:g} % allowed"
        place = {"transform": axes.get_yaxis_transform(), "ha": "right", "va": "bottom"}
        if wall == "hard":
            axes.text(0.99, LEVELS[level], goal, color=colour, fontsize=8, **place)
    axes.set(xscale="log", yscale="log")
    axes.set_xticks(ticks := [0.2, 0.5, 1, 2, 5], map(str, ticks))
    axes.xaxis.set_minor_formatter("")
    axes.set(xlabel="CPU time of a step (s)", ylabel="true relative error of the area")
    figure.legend(loc="outside upper center", fontsize=8, ncols=2)
    figure.savefig(IMAGE, dpi=120)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--study", nargs="*", choices=SETTINGS, default=list(SETTINGS))
    for name in ("report", "errors", "draw"):
        parser.add_argument(f"--{name}", action="store_true")
    options = parser.parse_args()
    if options.report:
        report()
    elif options.draw:
        draw()
    else:
        if not options.errors:
            run(options.study)
        print_errors()
