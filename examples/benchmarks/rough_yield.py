"""Largest stress below a rough sphere, and where it yields first, over the slope.

    python rough_yield.py                # all paths that rough_yield.csv lacks
    python rough_yield.py --report       # the table of the guide, from its rows
    python rough_yield.py --draw rough_yield.png  # depth and load over the slope
    python rough_yield.py --sections rough_sections.png  # stress on vertical planes

A sphere with a hard wall on an isotropic solid, nu = 0.3, is pressed until a smooth one
has a contact radius of 64 a0 and a largest pressure of 0.1 E*. Roughness has
wavelengths from 32 to 64 a0, a Hurst exponent of 0.8, and five seeds. The yield
strength is the largest von Mises stress of the smooth sphere at the last load. Grids
have spacings of a0 and a0/2: 32 and 64 points for the shortest wave.
"""

import argparse
import csv
from pathlib import Path

import numpy as np
from markdown import table
from matplotlib import pyplot

from ase_roughcontact import (
    HardWall,
    Output,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    substrate,
)
from ase_roughcontact.analysis import ContactMap, first_yield, stress_section
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.plot import BLUE, GREY, ORANGE, plot_stress_section, style

CONTACT_RADIUS, PRESSURE, SOLID = 64.0, 0.1, Isotropic(1.0, 0.3)
RADIUS = 2.0 * CONTACT_RADIUS / (np.pi * PRESSURE)
LOAD = 4.0 / 3.0 * CONTACT_RADIUS**3 / RADIUS
YIELD_STRENGTH = 0.6200 * PRESSURE
LOADS = LOAD * np.geomspace(3e-3, 1.05, 9)
COLUMNS = ["largest_von_mises", "von_mises_depth", "von_mises_x", "von_mises_y"]
TABLE = Path(__file__).with_name("rough_yield.csv")
CASE = ("spacing", "slope", "seed")
FIELDS = (*CASE, "stress", "depth", "yield load", "yield depth", "yield radius")
SLOPES = (0.0125, 0.025, 0.05, 0.1)
CASES = [
    (spacing, slope, seed)
    for spacing in (1.0, 0.5)
    for slope, seeds in ((0.0, 1), *((slope, 5) for slope in SLOPES))
    for seed in range(1, seeds + 1)
]


def atoms_of(spacing, slope, seed):
    """Return the substrate and the sphere above it."""
    rough = None
    if slope:
        rough = SelfAffine(slope, 0.8, 32.0, 64.0, seed=seed, domain=512.0)
    sphere = RoughSphere(RADIUS, rough)
    atoms = substrate("Cu", (16, 16), sphere, spacing=spacing, fixed=False)
    atoms.calc = RoughContact(sphere, None, HardWall(), solid=SOLID)
    return atoms


def path_of(atoms, loads):
    """Return the steps of a path."""
    output = Output(columns=COLUMNS)
    options = {"window": "auto", "validity": "ignore", "output": output}
    return list(load_path(atoms, loads=loads, **options))


def run():
    """Calculate what is missing."""
    if not TABLE.exists():
        TABLE.write_text(",".join(FIELDS) + "\n", "utf-8")
    with TABLE.open(newline="") as file:
        known = {tuple(float(row[k]) for k in CASE) for row in csv.DictReader(file)}
    for case in CASES:
        if case in known:
            continue
        steps = path_of(atoms_of(*case), LOADS)
        last, first = steps[-1], first_yield(steps, YIELD_STRENGTH)
        row = (
            last.largest_von_mises / YIELD_STRENGTH / 1.05 ** (1 / 3),
            last.von_mises_depth / CONTACT_RADIUS,
            first.normal_force / LOAD,
            first.depth / CONTACT_RADIUS,
            np.hypot(first.x, first.y) / CONTACT_RADIUS,
        )
        with TABLE.open("a", newline="") as file:
            csv.writer(file).writerow((*case, *(f"{each:.4g}" for each in row)))


def rows_of(spacing, slope):
    """Return the rows of all seeds."""
    with TABLE.open(newline="") as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    return [r for r in rows if (r["spacing"], r["slope"]) == (spacing, slope)]


def mean(spacing, slope, column):
    """Return the mean of all seeds, and its standard error."""
    values = np.array([row[column] for row in rows_of(spacing, slope)])
    error = values.std(ddof=1) / np.sqrt(len(values)) if len(values) > 1 else 0.0
    return values.mean(), error


def report():
    """Print the table of the guide."""
    columns = ("stress", "depth", "yield load", "yield depth", "yield radius")
    table(
        "spacing | rms slope | largest stress | its depth | load of first yield | "
        "its depth | distance from the axis",
        (
            (
                "a0" if spacing == 1.0 else "a0/2",
                f"{slope:g}",
                *(
                    "{:.3f} ± {:.3f}".format(*mean(spacing, slope, column))
                    for column in columns
                ),
            )
            for slope in (0.0, *SLOPES)
            for spacing in (1.0, 0.5)
        ),
    )


def draw(file):
    """Draw depth and load of first yield over the slope."""
    with style():
        figure, (left, right) = pyplot.subplots(1, 2, figsize=(7.0, 2.8))
        for spacing, colour in ((1.0, ORANGE), (0.5, BLUE)):
            label = "spacing $a_0$" if spacing == 1.0 else "spacing $a_0/2$"
            for axes, column in ((left, "yield depth"), (right, "yield load")):
                found = [mean(spacing, slope, column) for slope in SLOPES]
                values, errors = np.transpose(found)
                axes.errorbar(SLOPES, values, errors, fmt="o-", color=colour, ms=4)
                axes.plot([], [], "o-", color=colour, label=label)
        smooth = rows_of(0.5, 0.0)[0]
        for axes, column in ((left, "yield depth"), (right, "yield load")):
            axes.axhline(smooth[column], color=GREY, ls="--", label="smooth sphere")
            axes.set_xscale("log")
            axes.set_xticks(SLOPES, [f"{slope:g}" for slope in SLOPES])
            axes.set_xticks([], minor=True)
            axes.set_xlabel("rms slope")
        left.set_ylim(0.0)
        left.set_ylabel("depth of first yield/$a_H$")
        right.set_yscale("log")
        right.set_ylabel("load of first yield/$N_H$")
        right.legend(frameon=False)
        figure.savefig(file, dpi=150)


def draw_sections(file):
    """Draw the stress on planes through its largest value, from smooth to rough."""
    unit = {"unit": "eV/Å^3"}  # E* = 1
    with style():
        figure, panels = pyplot.subplots(1, 3, figsize=(8.4, 2.8), sharey=True)
        for panel, slope in zip(panels, (0.0, 0.025, 0.1), strict=True):
            atoms = atoms_of(1.0, slope, 1)
            (step,) = path_of(atoms, LOAD * np.ones(1))
            seen = ContactMap.from_atoms(atoms)
            section = stress_section(
                seen, SOLID, at=step.von_mises_y, depths=np.linspace(1.0, 120.0, 80)
            )
            shown = {**unit, "yield_strength": 0.999 * YIELD_STRENGTH}
            contours = plot_stress_section(panel, section, **shown).collections[0]
            panel.set(title=f"rms slope {slope:g}", xlim=(-10.5, 10.5))
            panel.set(xlabel="$x$ (10 $a_0$)", ylabel="")
            label = "von Mises stress/$E^*$"
            figure.colorbar(contours, ax=panel, location="bottom", label=label)
        panels[0].set_ylabel("$z$ (10 $a_0$)")
        figure.savefig(file, dpi=150, bbox_inches="tight")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--report", action="store_true", help="print the table")
    parser.add_argument("--draw", metavar="FILE", help="draw the figure")
    parser.add_argument("--sections", metavar="FILE", help="draw sections")
    arguments = parser.parse_args()
    if arguments.sections:
        draw_sections(arguments.sections)
    elif arguments.draw:
        draw(arguments.draw)
    elif arguments.report:
        report()
    else:
        run()
        report()
