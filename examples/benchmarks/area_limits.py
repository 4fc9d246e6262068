"""What limits the contact area: table of the guide, from the rows of other scripts.

    python area_limits.py --report

Changes of the area by the grid and the wall follow from `grid_error.csv`: at each load
the mean over slopes, Hurst exponents and seeds, and of these the least and the largest.
Those by the tolerance and the periodic cell follow from `speed_accuracy.csv`.
"""

import argparse
import csv
from collections import defaultdict
from pathlib import Path

from grid_error import CASE, UNSEEN
from markdown import ends, table

FOLDER = Path(__file__).parent
SHAPES = ("sphere", "flat")


def read(name):
    """Return the rows of a table."""
    with (FOLDER / name).open(newline="") as file:
        return list(csv.DictReader(file))


def areas():
    """Return for each state the counted area at a0, and the limit of fine grids.

    States are those of the table of `grid_error.py`.
    """
    grids = defaultdict(dict)
    for row in read("grid_error.csv"):
        if (float(row["hurst"]), int(row["seed"])) in UNSEEN:
            continue
        state = tuple(row[name] for name in (*CASE, "load"))
        grids[state][row["spacing"]] = float(row["area"]), float(row["continuum"])
    return {
        state: (grid["1.0"][0], 2.0 * grid["0.125"][1] - grid["0.25"][1])
        for state, grid in grids.items()
    }


def means(changes):
    """Return the range over the loads of means in %, by shape."""
    of_load = defaultdict(list)
    for (shape, *_, load), change in changes.items():
        of_load[shape, load].append(change)
    cells = []
    for wanted in SHAPES:
        mean = [100 * sum(v) / len(v) for (s, _), v in of_load.items() if s == wanted]
        cells.append(f"{ends(mean, '{:+.0f}'.format)} %")
    return cells


def by_grid(wall):
    """Return what counting the points of a grid of a0 adds."""
    found = areas().items()
    return means({s: area / limit - 1 for s, (area, limit) in found if s[1] == wall})


def by_wall():
    """Return what the repulsive wall adds to the area of the hard one, fine grids."""
    limits = {state: limit for state, (_, limit) in areas().items()}
    changes = {}
    for state, limit in limits.items():
        shape, wall, slope, *rest = state
        if wall == "repulsive":
            # areas of flats depend on pressure over slope alone
            same = slope if shape == "sphere" else "0.1"
            changes[state] = limit / limits[(shape, "hard", same, *rest)] - 1
    return means(changes)


def by_choice(setting):
    """Return the range of errors of the area of spheres."""
    errors = [
        100 * float(row["area_error"])
        for row in read("speed_accuracy.csv")
        if row["setting"] == setting
    ]
    return f"{ends(errors, '{:.1g}'.format)} %"


def report():
    """Print the table."""
    rows = [
        ("tolerance of 1e-2", by_choice("tolerance=0.01"), "", "`accuracy`"),
        ("grid of $a_0$, hard wall", *by_grid("hard"), '`model = "continuum"`'),
        (
            "grid of $a_0$, repulsive wall",
            *by_grid("repulsive"),
            '`model = "continuum"`',
        ),
        ("repulsive instead of hard wall", *by_wall(), "`kind`"),
        (
            "periodic cell of twice the contact",
            by_choice("tolerance=1e-06 cell=2"),
            "",
            "`periodic = false`",
        ),
    ]
    table("what limits the area | spheres | flats | choose by", rows)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--report", action="store_true", help="print the table")
    parser.parse_args()
    report()
