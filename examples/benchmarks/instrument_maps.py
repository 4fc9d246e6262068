"""What is read from the maps and series of force curves of instruments in a folder.

    python examples/benchmarks/instrument_maps.py FOLDER

Of a file with several curves, or an archive of several, all are fitted by `fit_curves`
with a paraboloid of an assumed radius of 10 um, and by `scipy.optimize.curve_fit`, with
a free force that is linear in the height of the base. Where a file has no calibration,
0.1 N/m and 50 nm/V are given.
"""

import argparse
import logging
import warnings
from pathlib import Path

import numpy as np
from force_map import independent_fit
from markdown import table

from ase_roughcontact import fit_curves
from ase_roughcontact._util.units import UNITS, pressure_unit
from ase_roughcontact.fitting.curve_files import read_curve
from ase_roughcontact.fitting.formats.reader import count_curves
from ase_roughcontact.fitting.series.grid import grid_of
from ase_roughcontact.fitting.series.summary import SeriesSummary, is_good

GIVEN = {"stiffness": 0.1 * UNITS["N/m"], "sensitivity": "50 nm/V"}


def fitted(file):
    """Return the fits of the curves in a file, and the given calibration."""
    for given in ({}, GIVEN):
        curves = list(fit_curves(file, "paraboloid 10 um", workers=1, **given))
        if any(map(is_good, curves)):
            break
    return curves, given


def row(file):
    """Return what was read of a file."""
    curves, given = fitted(file)
    grid = grid_of(curves)
    shape = "one place" if grid is None else " x ".join(map(str, grid.shape))
    good = [curve for curve in curves if is_good(curve)]
    apart = []
    for curve in good:
        read = read_curve(file, "approach", curve=curve.number, **given)
        base, force = read.base / UNITS["nm"], read.force / UNITS["nN"]
        other = independent_fit(base, force, 1e4, read.stiffness / UNITS["N/m"])
        found = curve.contact_modulus / UNITS["kPa"]
        error = curve.contact_modulus_error / UNITS["kPa"]
        apart.append(abs(found - other) / error)
    quartiles = SeriesSummary(curves).quartiles
    unit = pressure_unit(quartiles["contact_modulus"][1])
    moduli, forces = (
        [f"{value / UNITS[u]:.4g}" for value in quartiles[name]]
        for name, u in (("contact_modulus", unit), ("pull_off_force", "nN"))
    )
    return [
        file.name,
        len(curves),
        len(curves) - len(good),
        shape,
        f"{moduli[1]} ({moduli[0]} to {moduli[2]}) {unit}",
        f"{np.median(apart):.1g}, {max(apart):.1g}",
        f"{forces[1]} ({forces[0]} to {forces[2]})",
        sum(bool(curve.doubts) for curve in curves),
    ]


def several(file):
    """Return whether a file has several curves."""
    try:
        return count_curves(file) > 1
    except ValueError:
        return False


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")
    table(
        "file | curves | failed | grid | E*: median (quartiles) | difference from "
        "curve_fit, standard errors: median, largest | pull-off force: median "
        "(quartiles), nN | with doubts",
        (row(file) for file in sorted(folder.iterdir()) if several(file)),
    )


if __name__ == "__main__":
    main()
