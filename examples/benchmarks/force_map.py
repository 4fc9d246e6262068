"""Synthetic force map with known moduli: its fit, and the picture of the guide.

    python examples/benchmarks/force_map.py

A map of 20 x 12 curves, 2 um apart: stripes of 2, 20 and 200 kPa under a sphere of a
radius of 5 um, a cantilever of 0.05 N/m, noise of 10 pN, 1000 points a branch, and a
pull-off force that grows along x. It is fitted by the command ``curves``, and some
curves of each stripe by `scipy.optimize.curve_fit`. Writes ``force_map.png``.
"""

import shutil
import tempfile
from pathlib import Path

import numpy as np
from markdown import table
from scipy.optimize import curve_fit

from ase_roughcontact import read_fitted_curves
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main as command

COLUMNS, ROWS, PIXEL = 20, 12, 2.0  # um
RADIUS, STIFFNESS, NOISE = 5000.0, 0.05, 0.01  # nm, nN/nm, nN
POINTS, HIGHEST, LARGEST = 1000, 800.0, 2.0  # nm, nN
MODULI = {2: "2 kPa", 20: "20 kPa", 200: "200 kPa"}


def modulus(column):
    """Return E* (kPa)."""
    return list(MODULI)[column * len(MODULI) // COLUMNS]


def force_at(base, modulus, contact, radius=RADIUS, stiffness=STIFFNESS):
    """Return forces (nN) at heights of the base (nm), by Newton's method; E* in kPa."""
    below = np.maximum(contact - base, 0.0)
    c = 4.0 / 3.0 * 1e-6 * abs(modulus) * np.sqrt(radius)
    depth = below.copy()
    for _ in range(60):
        value = depth + c * depth**1.5 / stiffness - below
        depth = np.maximum(depth - value / (1.0 + 1.5 * c * depth**0.5 / stiffness), 0)
    return c * depth**1.5


def curve(column, row, noise):
    """Return heights (nm) and forces (nN) of both branches."""
    c = 4.0 / 3.0 * 1e-6 * modulus(column) * np.sqrt(RADIUS)
    deepest = (LARGEST / c) ** (2.0 / 3.0) + LARGEST / STIFFNESS
    base = np.linspace(HIGHEST, -deepest, POINTS)
    down = force_at(base, modulus(column), 0.0)
    neck = -(0.1 + 0.02 * column) * (1.0 - base / 150.0)
    up = np.where((base > 0.0) & (base < 150.0), neck, down)[::-1]
    height = base + 100.0 * np.sin(0.5 * row)
    forces = np.array([down, up]) + NOISE * noise.normal(size=(2, POINTS)) + 0.2
    return (height, forces[0]), (height[::-1], forces[1])


def independent_fit(base, force, radius=RADIUS, stiffness=STIFFNESS):
    """Return E* (kPa) by `scipy.optimize.curve_fit`, with a linear free force."""

    def model(x, logarithm, contact, offset, slope):
        at = np.exp(logarithm), contact, radius, stiffness
        return force_at(x, *at) + offset + slope * (x - x.max()) / np.ptp(x)

    best = None
    for part in (0.05, 0.1, 0.2, 0.4):
        first = [np.log(10.0), base.min() + part * np.ptp(base), np.median(force), 0.0]
        found, _ = curve_fit(model, base, force, first, maxfev=10000)
        misfit = np.sum((model(base, *found) - force) ** 2)
        if best is None or misfit < best[0]:
            best = misfit, np.exp(found[0])
    return best[1]


def write(folder):
    """Write the curves as tables, and return their approaches by column and row."""
    noise, approaches = np.random.default_rng(5), {}
    for row in range(ROWS):
        for column in range(COLUMNS):
            approach, retraction = curve(column, row, noise)
            approaches[column, row] = approach
            lines = [f"# x (um): {PIXEL * column}", f"# y (um): {PIXEL * row}"]
            lines.append("height (nm),force (nN),branch")
            for name, branch in (("approach", approach), ("retraction", retraction)):
                points = np.transpose(branch)
                lines += [f"{z:.4f},{f:.6f},{name}" for z, f in points]
            (folder / f"{row:02}-{column:02}.csv").write_text(
                "\n".join(lines) + "\n", "utf-8"
            )
    return approaches


def main():
    """Print the table, and write the picture."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "map"
        folder.mkdir()
        approaches = write(folder)
        words = ["curves", str(folder), "--indenter", "paraboloid 5 um", "--quiet"]
        words += ["--cantilever", "0.05 N/m", "--workers", "1"]
        command([*words, "--out", f"{name}/out"])
        fitted = read_fitted_curves(f"{name}/out/curves.csv")
        shutil.copy(f"{name}/out/maps.png", "force_map.png")
    rows, kPa = [], UNITS["kPa"]
    for true, text in MODULI.items():
        numbers = [i for i in range(len(fitted)) if modulus(i % COLUMNS) == true]
        values = np.array([fitted[i].contact_modulus for i in numbers]) / kPa
        errors = np.array([fitted[i].contact_modulus_error for i in numbers]) / kPa
        off = (values - true) / errors
        apart = []
        for n in (0, len(numbers) // 2, len(numbers) - 1):
            approach = approaches[numbers[n] % COLUMNS, numbers[n] // COLUMNS]
            apart.append(abs(values[n] - independent_fit(*approach)) / errors[n])
        quartiles = np.percentile(values, (25, 50, 75))
        middle = "{1:.4g} ({0:.4g} to {2:.4g})".format(*quartiles)
        deviation = f"{np.mean(off):.2f}, {np.std(off):.2f}"
        rows.append([text, len(numbers), middle, deviation, f"{max(apart):.1g}"])
    table(
        "E* | curves | median (quartiles), kPa | deviation over its standard error: "
        "mean, standard deviation | largest difference from curve_fit, standard errors",
        rows,
    )


if __name__ == "__main__":
    main()
