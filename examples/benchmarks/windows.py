"""What it saves to model only the atoms that can touch.

    python windows.py path     # automatic windows or one, a table of the guide
    python windows.py cold     # one contact, pairs, memory, time
    python windows.py cost     # cost against contact radius
    python windows.py draw     # its picture, from the table

Lengths are in spacings, and the contact modulus is 1. Run one at a time, on a machine
that does nothing else.
"""

import argparse
import csv
import resource
import time
from itertools import product
from pathlib import Path

import ducc0
import numpy as np
import scipy.fft
from markdown import table
from matplotlib import pyplot

from ase_roughcontact import (
    HardWall,
    LennardJones93,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    substrate,
)
from ase_roughcontact._util.threads import available_threads
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.plot import style

WALLS = {"hard": HardWall(), "repulsive": LennardJones93.repulsive(1.0, 1.0)}
LARGEST = 256.0  # contact radius of the last load of a path
TABLE = Path(__file__).parents[1] / "images" / "windows-cost.csv"


def make_atoms(radius, wall, shape=(8, 8)):
    rough = SelfAffine(0.1, 0.8, 4.0, 512.0, seed=1, domain=4096.0)
    sphere = RoughSphere(radius, rough)
    atoms = substrate("Cu", shape, sphere, spacing=1.0, fixed=False)
    atoms.calc = RoughContact(sphere, 1.0, wall)
    return atoms


def load_of(contact_radius, radius):
    """Load under which a smooth sphere has a contact radius."""
    return 4.0 * contact_radius**3 / (3.0 * radius)


def pair_times(shape):
    """Time of a pair of transforms of the padded grid of a window, by all processors.

    Of the whole grid by scipy and by ducc0, and in our convolution of the window.
    """
    halfspace = FreeHalfSpace(shape, 1.0, 1.0)
    threads, pressure = available_threads(), np.ones(shape)
    grid = np.ones(halfspace.grid)
    spectrum = scipy.fft.rfft2(grid)

    def by_scipy():
        spectrum = scipy.fft.rfft2(grid, workers=threads)
        scipy.fft.irfft2(spectrum, grid.shape, workers=threads)

    def by_ducc():
        options = {"axes": (0, 1), "nthreads": threads}
        ducc0.fft.r2c(grid, out=spectrum, **options)
        back = {"lastsize": grid.shape[1], "forward": False, **options}
        ducc0.fft.c2r(spectrum, out=grid, **back)

    ways = by_scipy, by_ducc, lambda: halfspace.displacement(pressure)
    return [least_time(way) for way in ways]


def least_time(way):
    times = []
    for _ in range(6):
        start = time.perf_counter()
        way()
        times.append(time.perf_counter() - start)
    return min(times[1:])


def shape_of(record):
    n, m = map(int, record.window.split("x"))
    return n, m


def memory():
    """Most memory that the process has had so far (GB)."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6


def path(_):
    """Compare the processor time of both windows at thirty loads."""
    rows = []
    for radius, wall in product((1e3, 1e5), WALLS):
        loads = np.geomspace(load_of(0.5, radius), load_of(LARGEST, radius), 30)
        times, shape = [], (8, 8)
        for window in ("auto", "fixed"):
            atoms = make_atoms(radius, WALLS[wall], shape)
            start = time.process_time()
            records = list(load_path(atoms, loads=loads, window=window))
            times.append(time.process_time() - start)
            shape = shape_of(records[-1])
        rows.append((f"{radius:g}", wall, f"{times[1] / times[0]:.1f}"))
    table("$R/a_0$ | wall | time with one window, relative", rows)


def cold(options):
    """One contact from a cold start."""
    atoms = make_atoms(options.radius, WALLS[options.wall])
    load = load_of(options.contact, options.radius)
    (record,) = load_path(atoms, loads=[load], window="auto")
    peak = memory()
    print(
        f"{options.wall}, R = {options.radius:g}, a_Hertz = {options.contact:g}: "
        f"{record.repulsive_atoms} atoms in contact, window {record.window}, "
        f"{record.pairs:.0f} pairs, {peak:.2f} GB, {record.seconds:.1f} s, "
        f"converged: {record.converged}"
    )
    names = "scipy", "ducc0", "our convolution"
    for name, pair in zip(names, pair_times(shape_of(record)), strict=True):
        took = record.seconds / pair
        print(
            f"  as long as {took:.0f} pairs by {name} ({1e3 * pair:.0f} ms), "
            f"{took / record.pairs:.2f} times its own"
        )


def cost(options):
    """Cost against contact radius, each from a cold start."""
    rows = []
    for wall in WALLS:
        for contact in 2.0 ** np.arange(4, 10.5, 0.5):
            atoms = make_atoms(options.radius, WALLS[wall])
            loads = [load_of(contact, options.radius)]
            start = time.process_time()
            (record,) = load_path(atoms, loads=loads, window="auto")
            seconds = time.process_time() - start
            n, m = shape_of(record)
            rows.append((wall, contact, n * m, record.pairs, f"{seconds:.4f}"))
            print(*rows[-1], flush=True)
    with TABLE.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("wall", "contact_radius", "points", "pairs", "seconds"))
        writer.writerows(rows)


def draw(options):
    """Draw the table."""
    with TABLE.open(newline="") as file:
        rows = list(csv.DictReader(file))
    with style():
        figure, axes = pyplot.subplots()
        for wall, line in zip(WALLS, ("o-", "s--"), strict=True):
            mine = [row for row in rows if row["wall"] == wall]
            names = "contact_radius", "points", "seconds"
            contact, points, seconds = (
                np.array([float(row[name]) for row in mine]) for name in names
            )
            axes.loglog(contact, seconds, line, label=f"{wall} wall")
        growth = points * np.log(points)
        label = r"$\propto n^2 \log n$, window of $n \times n$ points"
        axes.loglog(contact, seconds[-1] * growth / growth[-1], "k:", label=label)
        axes.set(xlabel=r"contact radius $a_\mathrm{Hertz}/a_0$")
        axes.set(ylabel="CPU time from a cold start (s)", ylim=(5e-3, None))
        axes.legend()
        figure.savefig(options.out / "windows-cost.png", dpi=200)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=("path", "cold", "cost", "draw"))
    parser.add_argument("--radius", type=float, default=1e4)
    parser.add_argument("--wall", choices=WALLS, default="hard")
    parser.add_argument("--contact", type=float, default=1024.0)
    parser.add_argument("--out", type=Path, default=Path())
    options = parser.parse_args()
    {"path": path, "cold": cold, "cost": cost, "draw": draw}[options.what](options)


if __name__ == "__main__":
    main()
