"""What it saves to model only the atoms that can touch.

    python windows.py path --radius 1000 --contact 512    # automatic windows or one
    python windows.py cold --wall hard         # one contact, pairs, memory, time
    python windows.py cost                     # cost against contact radius, a plot

Lengths are in spacings, and the contact modulus is 1. Run one at a time, on a machine
that does nothing else: the ratios are what counts.
"""

import argparse
import csv
import resource
import time
from pathlib import Path

import ducc0
import numpy as np
import scipy.fft

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

WALLS = {"hard": HardWall(), "repulsive": LennardJones93.repulsive(1.0, 1.0)}
IMAGES = Path(__file__).parents[1] / "images"


def make_atoms(radius, wall, shape=(8, 8)):
    rough = SelfAffine(0.1, 0.8, 4.0, 512.0, seed=1, domain=4096.0)
    sphere = RoughSphere(radius, rough)
    atoms = substrate("Cu", shape, sphere, spacing=1.0, fixed=False)
    atoms.calc = RoughContact(sphere, 1.0, WALLS[wall])
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


def path(options):
    """Thirty loads, from the first touching atom to the contact radius."""
    lightest = load_of(0.5, options.radius)
    loads = np.geomspace(lightest, load_of(options.contact, options.radius), 30)
    seconds, areas = {}, {}
    shape = (8, 8)
    for window in ("auto", "fixed"):
        atoms = make_atoms(options.radius, options.wall, shape)
        start = time.perf_counter()
        records = list(load_path(atoms, loads=loads, window=window))
        seconds[window] = time.perf_counter() - start
        areas[window] = [record.repulsive_atoms for record in records]
        shape = shape_of(records[-1])
        print(window, shape, f"{seconds[window]:.1f} s", areas[window], flush=True)
    ratio = seconds["fixed"] / seconds["auto"]
    print(f"R = {options.radius:g}, {options.wall}: one window takes {ratio:.1f} times")


def cold(options):
    """One contact from a cold start."""
    atoms = make_atoms(options.radius, options.wall)
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
            atoms = make_atoms(options.radius, wall)
            loads = [load_of(contact, options.radius)]
            (record,) = load_path(atoms, loads=loads, window="auto")
            n, m = shape_of(record)
            rows.append((wall, contact, n * m, record.pairs, record.seconds))
            print(*rows[-1], flush=True)
    with open(options.out / "windows-cost.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(("wall", "contact_radius", "window", "pairs", "seconds"))
        writer.writerows(rows)
    draw(rows, options.out / "windows-cost.png")


def draw(rows, file):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(5, 4), layout="constrained")
    for wall, colour in zip(WALLS, ("#0072B2", "#D55E00"), strict=True):
        mine = np.array([row[1:] for row in rows if row[0] == wall])
        axes.loglog(mine[:, 0], mine[:, 3], "o-", color=colour, label=f"{wall} wall")
    side = mine[:, 1] ** 0.5
    growth = mine[:, 1] * np.log(mine[:, 1])
    axes.loglog(
        mine[:, 0],
        mine[-1, 3] * growth / growth[-1],
        "k--",
        lw=1,
        label=r"$\propto n^2 \log n$, window of $n \times n$ atoms",
    )
    axes.set_xlabel("contact radius $a_\\mathrm{Hertz}/a_0$")
    axes.set_ylabel("time from a cold start (s)")
    axes.set_ylim(bottom=0.3 * min(row[4] for row in rows))
    axes.set_title(f"windows up to {side.max():.0f} atoms along a side", fontsize=10)
    axes.legend(frameon=False)
    figure.savefig(file, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=("path", "cold", "cost"))
    parser.add_argument("--radius", type=float, default=1e4)
    parser.add_argument("--wall", choices=WALLS, default="hard")
    parser.add_argument("--contact", type=float, default=1024.0)
    parser.add_argument("--out", type=Path, default=IMAGES)
    options = parser.parse_args()
    {"path": path, "cold": cold, "cost": cost}[options.what](options)


if __name__ == "__main__":
    main()
