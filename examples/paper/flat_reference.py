"""
Reference for strong adhesion: rough flats
==========================================

Where adhesion is strong, the fraction of contact in Eq. (4) is not that of Eq. (2) but
tabulated from nominally flat rough surfaces with the same interaction. This script
makes such a table::

    python examples/paper/flat_reference.py --work 0 0.0005 0.005 --out flat.csv

Periodic self-affine surfaces are pressed on a flat solid, from zero pressure up, and
the fraction of atoms that feel a repulsive force is written. Lengths are in units of
a0, pressures in units of E*, works of adhesion in units of E* a0. The table
``examples/paper/results/flat-reference.csv`` was made in this way. For another
roughness change the options, for another interaction the function ``wall``, and give
the file to ``flat_fraction``.
"""

import argparse
import csv
import shlex
import sys
from importlib.metadata import version
from pathlib import Path

import numpy as np
from scipy.interpolate import PchipInterpolator

from ase_roughcontact import (
    LennardJones93,
    RoughContact,
    SelfAffine,
    load_path,
    substrate,
)

COLUMNS = "work_of_adhesion", "pressure", "contact_fraction", "spread"
TABLE = Path(__file__).parent / "results" / "flat-reference.csv"


def flat_fraction(work, file=TABLE):
    """Fraction in contact as a function of the pressure, interpolated in a table."""
    lines = [line for line in file.read_text("utf-8").splitlines() if line[0] != "#"]
    table = np.genfromtxt(lines, delimiter=",", names=True)
    table = table[np.isclose(table["work_of_adhesion"], work, rtol=1e-6, atol=0.0)]
    curve = PchipInterpolator(table["pressure"], table["contact_fraction"])
    return lambda pressure: curve(np.minimum(pressure, table["pressure"][-1]))


def wall(work, stiffness):
    """Interaction in units of E* and a0."""
    return LennardJones93.adhesive(1.0, 1.0, work, stiffness=stiffness)


def surface(options, seed):
    """One realisation whose period is the cell."""
    return SelfAffine(
        options.slope,
        options.hurst,
        options.short,
        options.long,
        domain=float(options.size),
        seed=seed,
    )


def fractions(options, work, pressures, seed):
    """Fraction of the atoms in contact at rising pressures, for one realisation."""
    rough = surface(options, seed)
    shape = options.size, options.size
    atoms = substrate("Cu", shape, rough, spacing=1.0, periodic=True, fixed=False)
    atoms.calc = RoughContact(rough, 1.0, wall(work, options.stiffness))
    sites = options.size**2
    found = []
    for step in load_path(atoms, loads=pressures * sites, fmax=options.fmax):
        if not step.converged:
            raise RuntimeError(f"w {work:g}, seed {seed}: {step} did not converge")
        found.append(step.contact_area / sites)
        print(
            f"w {work:<8g} seed {seed}  p {pressures[step.step]:.3e}  "
            f"f {found[-1]:.6f}  {step.iterations:3d} steps "
            f"{step.seconds:6.1f} s",
            flush=True,
        )
    return found


def table(options):
    """Rows of the table: mean and standard deviation over the realisations."""
    rising = options.slope * np.geomspace(*options.pressures, options.points)
    pressures = np.append(0.0, rising)
    for work in options.work:
        curves = [fractions(options, work, pressures, seed) for seed in options.seeds]
        columns = pressures, np.mean(curves, axis=0), np.std(curves, axis=0)
        for row in zip(*columns, strict=True):
            yield [f"{work:g}", *(f"{value:.7g}" for value in row)]


def header(options, command):
    """Comment that says how the table was made."""
    return (
        "# Fraction of nominally flat rough surfaces in contact: mean and standard\n"
        "# deviation over the seeds. Units: a0, E*.\n"
        f"# python examples/paper/flat_reference.py {command}\n"
        f"# ase-roughcontact {version('ase-roughcontact')}; rms_slope={options.slope:g}"
        f" hurst={options.hurst:g} short_wavelength={options.short:g}"
        f" long_wavelength={options.long:g}\n"
        f"# size={options.size} seeds={options.seeds} stiffness={options.stiffness:g}"
        f" fmax={options.fmax:g}\n"
    )


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    add = parser.add_argument
    add("--work", type=float, nargs="+", default=[0.0, 0.0005, 0.005], help="w/(E* a0)")
    add("--stiffness", type=float, default=1.0, help="of the wall, a0/E* V''(a0)")
    add("--slope", type=float, default=0.1, help="rms slope")
    add("--hurst", type=float, default=0.8)
    add("--short", type=float, default=4.0, help="shortest wavelength")
    add("--long", type=float, default=512.0, help="longest wavelength")
    add("--size", type=int, default=1024, help="atoms a side of the periodic cell")
    add("--seeds", type=int, nargs="+", default=[1, 2, 3])
    add("--pressures", type=float, nargs=2, default=[1e-3, 3.0], help="p/(h' E*)")
    add("--points", type=int, default=20, help="number of pressures above zero")
    add("--fmax", type=float, default=1e-8, help="tolerance, E* a0^2")
    add("--out", default="flat_reference.csv")
    arguments = sys.argv[1:] if arguments is None else arguments
    options = parser.parse_args(arguments)
    with open(options.out, "w", encoding="utf-8", newline="") as file:
        file.write(header(options, shlex.join(arguments)))
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(COLUMNS)
        for row in table(options):
            rows.writerow(row)
            file.flush()


if __name__ == "__main__":
    main()
