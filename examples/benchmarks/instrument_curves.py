"""What is read from the force curves of instruments in a folder, and a modulus of each.

    python examples/benchmarks/instrument_curves.py FOLDER

Of archives and maps the first curve is read. Where a file has no calibration, 0.1 N/m
and 50 nm/V (nm/nA for NT-MDT) are given. To each approach a paraboloid of an assumed
radius of 10 µm with a free force without slope is fitted, by `fit_indentation`, and by
`scipy.optimize.curve_fit` on the arrays that afmformats reads, with Newton's method for
the depth at each height of the base.
"""

import argparse
import logging
import math
import tempfile
import warnings
import zipfile
from pathlib import Path

import afmformats
import numpy as np
from markdown import table
from scipy.optimize import curve_fit

from ase_roughcontact._util.units import UNITS, pressure_unit
from ase_roughcontact.fitting.curve_checks import curve_checks
from ase_roughcontact.fitting.curve_files import read_curve
from ase_roughcontact.fitting.indentation import fit_indentation
from ase_roughcontact.theory.indenters import Paraboloid

RADIUS, STIFFNESS, PER_VOLT = 10.0e-6, 0.1, 50e-9  # m, N/m, m/V
GIVEN = {"stiffness": STIFFNESS * UNITS["N/m"]}
CHOICES = (
    {},
    {"curve": 1},
    GIVEN,
    GIVEN | {"sensitivity": "50 nm/V"},
    GIVEN | {"sensitivity": "50 nm/V", "curve": 1},
    GIVEN | {"sensitivity": "50 nm/nA"},
    GIVEN | {"heads": ("height (m)", "force (N)", "deviation (N)")},
)
NUMBERS = {"force-distance": 0, "creep-compliance": 0, "stress-relaxation": 1}


def read(file):
    """Return a curve, and what was given; or the reason why it can't be read."""
    reasons = []
    for choice in CHOICES:
        try:
            return read_curve(file, **choice), choice
        except ValueError as error:
            reasons.append(str(error))
    return None, reasons[0]


def afm_approach(file, stiffness):
    """Return heights (m) and forces (N) of the approach by afmformats; None if none."""
    if file.suffix == ".zip":
        with zipfile.ZipFile(file) as archive, tempfile.TemporaryDirectory() as folder:
            name = sorted(archive.namelist())[0]
            return afm_approach(Path(archive.extract(name, folder)), stiffness)
    lacking = {"spring constant": stiffness}
    for given in ({}, lacking, lacking | {"sensitivity": PER_VOLT}):
        if file.suffix == ".txt" and "sensitivity" in given:
            given["sensitivity"] *= 1e9  # per nA
        try:
            curve = afmformats.load_data(file, meta_override=given)[0]
            part = curve["segment"] == NUMBERS[curve.metadata["imaging mode"]]
            measured = "height (measured)" in curve and "tip position" not in curve
            name = "height (measured)" if measured else "height (piezo)"
            height, force = curve[name][part], curve["force"][part]
        except BaseException:  # its errors are of this class
            continue
        if np.all(curve["segment"] == 0):  # both branches
            turn = int(np.argmin(height)) + 1
            height, force = height[:turn], force[:turn]
        return height, force
    return None


def independent_fit(base, force, stiffness):
    """Return E* (Pa) of a paraboloid, with forces compared at heights of the base."""

    def model(base, modulus, contact, offset):
        below = np.maximum(contact - base, 0.0)
        c = 4.0 / 3.0 * abs(modulus) * math.sqrt(RADIUS)
        depth = below.copy()
        for _ in range(60):
            value = depth + c * depth**1.5 / stiffness - below
            depth -= value / (1.0 + 1.5 * c * np.sqrt(depth) / stiffness)
            depth = np.maximum(depth, 0.0)
        return c * depth**1.5 + offset

    scale = np.array([1e3, np.ptp(base), np.ptp(force)])
    best = None
    for part in (0.02, 0.05, 0.1, 0.2, 0.4):
        contact = base.min() + part * np.ptp(base)
        first = [1e3, contact, float(np.median(force[: len(force) // 10]))]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found, _ = curve_fit(
                lambda b, *x: model(b, *(np.array(x) * scale)),
                base,
                force,
                np.array(first) / scale,
                maxfev=4000,
            )
        misfit = np.sum((model(base, *(found * scale)) - force) ** 2)
        if best is None or misfit < best[0]:
            best = misfit, abs(found[0] * scale[0])
    return best[1]


def row(file):
    """Return what was read of a file."""
    curve, choice = read(file)
    if curve is None:
        return [file.name, choice.replace(f"{file}", "not read:"), *"-------"]
    counts = " + ".join(
        str(branch.points.stop - branch.points.start) for branch in curve.branches
    )
    stiffness = curve.stiffness / UNITS["N/m"]
    largest = curve.force.max() / UNITS["nN"]
    try:
        approach = read_curve(file, "approach", **choice)
        fit = fit_indentation(
            approach, Paraboloid(RADIUS * UNITS["m"]), with_slope=False
        )
        unit = pressure_unit(fit.contact_modulus)
        modulus = f"{fit.contact_modulus / UNITS[unit]:.5g} {unit}"
    except ValueError:
        unit, modulus = "kPa", "-"
    theirs = afm_approach(file, stiffness)
    force, other = "-", "-"
    if theirs is not None:
        branch = curve.branches[0].points
        ours = curve.force[branch].max() / UNITS["nN"]
        force = f"{1e9 * theirs[1].max() / ours - 1.0:.0e}"
        scale = UNITS[unit] / UNITS["Pa"]
        if modulus != "-":
            other = f"{independent_fit(*theirs, stiffness) / scale:.5g} {unit}"
    given = ", ".join(key for key in choice if key != "curve")
    doubts = len(curve_checks(curve))
    return [
        file.name,
        counts,
        len(curve.remarks),
        f"{stiffness:.4g}{' (given)' if 'stiffness' in given else ''}",
        f"{largest:.4g}",
        force,
        modulus,
        other,
        doubts,
    ]


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    logging.disable(logging.CRITICAL)
    warnings.simplefilter("ignore")
    table(
        "file | points | holds left out | spring constant (N/m) | largest force (nN) "
        "| afmformats, approach: rel. difference | E* | E*, curve_fit | doubts",
        (row(file) for file in sorted(folder.iterdir()) if file.is_file()),
    )


if __name__ == "__main__":
    main()
