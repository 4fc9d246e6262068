"""True errors of areas from synthetic scans, beside the stated ones.

    python scan_errors.py            # all that scan_errors.csv lacks
    python scan_errors.py --report   # the table, from the stored rows

A self-affine surface of 1024 x 1024 points, with waves of 4 points and more, is pressed
by a sphere: that is the true area. A scan has every point, or every 2nd, 4th or 8th of
them, and in two of three cases noise of its points and lines. Of scans for which the
command advises a cutoff wavelength there is a second case with this filter; the last
seven cases are such scans. Slopes, Hurst exponents, waves, spheres, loads and walls are
random numbers of the seed.
"""

import argparse
import csv
import re
import tempfile
from pathlib import Path

import numpy as np
from markdown import table

from ase_roughcontact import SelfAffine
from ase_roughcontact._util.threads import threads
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.scene import Scene

TABLE = Path(__file__).with_name("scan_errors.csv")
POINTS, PIXEL = 1024, 0.25  # nm
NOISY = range(100, 107)  # seeds of scans for a filter
CASES = (*range(35), *NOISY)
FIELDS = (
    "seed",
    "ratio",
    "filter",
    "wall",
    "waves",
    "hurst",
    "slope",
    "noise",
    "lines",
    "load",
    "true",
    "area",
    "error",
    "patches",
)
SCENE = """
[substrate]
contact_modulus = 100.0
hardness = inf
[sphere]
radius = "{radius} nm"
[topography]
file = "{file}"
role = "substrate"
unit = "nm"
spacing = {spacing}
detrend = "none"
cutoff_wavelength = "{cutoff}"
[interaction]
kind = "{wall}"
[path]
loads = [{load}]
"""


def case(seed):
    """Return the parameters of a case, the heights of its surface and of its scan."""
    rng = np.random.default_rng(seed)
    waves, longest = rng.choice([4, 8, 16]), rng.choice([128, 256, 512])
    slope, hurst = rng.choice([0.02, 0.05, 0.1, 0.2]), rng.choice([0.3, 0.5, 0.8])
    a = 10.0 * PIXEL * rng.choice([3, 6, 10])  # contact radius of Hertz, nm
    radius = a * rng.choice([20, 60])
    ratio = 2 ** rng.integers(4)
    if seed in NOISY:
        ratio, waves = 1 + seed % 2, 16
    domain = POINTS * PIXEL
    lengths = waves * PIXEL, longest * PIXEL
    rough = SelfAffine(slope, hurst, *lengths, seed=seed, domain=domain)
    surface = rough.heights((POINTS, POINTS), PIXEL)
    scan = surface[::ratio, ::ratio]
    rms = np.sqrt(np.mean(np.diff(scan, axis=0) ** 2))
    noise = rng.choice([0.0, 0.1, 0.4]) * rms
    lines = rng.choice([0.0, 1.0]) * noise
    if seed in NOISY:
        noise, lines = 0.4 * rms, 0.0
    scan = scan + noise * rng.normal(size=scan.shape)
    scan = scan + lines * rng.normal(size=scan.shape[1])
    given = {
        "seed": seed,
        "ratio": ratio,
        "wall": rng.choice(["hard", "hard", "repulsive"]),
        "waves": waves / ratio,
        "hurst": hurst,
        "slope": slope,
        "noise": noise,
        "lines": lines,
        "load": 4.0 / 3.0 * 100.0 * a**3 / radius,  # nN
    }
    return given, radius, surface, scan


def pressed(heights, ratio, given, radius, cutoff="0 nm", errors=True):
    """Return the step of a scan, the warnings about it, and its pixels."""
    with tempfile.NamedTemporaryFile(suffix=".npy") as file:
        np.save(file, heights)
        file.flush()
        scene = Scene.parse(
            SCENE.format(
                file=file.name,
                spacing=PIXEL * ratio,
                radius=radius,
                cutoff=cutoff,
                **{key: given[key] for key in ("wall", "load")},
            )
        )
        scene.check()
        (step,) = scene.relax(validity="ignore", scan_errors=errors)
        return step, " ".join(scene.warnings), scene.scan.pixel


def rows(seed):
    """Yield the rows of a case: without a filter, and with the one that is advised."""
    given, radius, surface, scan = case(seed)
    exact, *_ = pressed(surface, 1, given, radius, errors=False)
    nm2 = UNITS["nm"] ** 2
    cutoffs = ["0 nm"]
    for cutoff in cutoffs:
        step, warnings, pixel = pressed(scan, given["ratio"], given, radius, cutoff)
        advice = re.search('cutoff_wavelength = "(.*)"', warnings)
        if advice and len(cutoffs) == 1:
            cutoffs.append(advice[1])
        yield given | {
            "filter": cutoff,
            "true": exact.continuum_area / nm2,
            "area": step.continuum_area / nm2,
            "error": step.area_error / nm2,
            "patches": 4.0 * step.contact_area / step.perimeter / pixel,
        }


def stored():
    """Return the stored rows."""
    if not TABLE.exists():
        return []
    with TABLE.open(newline="") as file:
        return list(csv.DictReader(file))


def calculate():
    """Append the cases that are missing."""
    done = {int(row["seed"]) for row in stored()}
    with TABLE.open("a", newline="") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        if not done:
            writer.writeheader()
        for seed in CASES:
            if seed in done:
                continue
            try:
                found = list(rows(seed))
            except ValueError as error:  # the contact is larger than the scan
                print(seed, error)
                continue
            for row in found:
                writer.writerow(
                    {
                        k: f"{v:.6g}" if isinstance(v, float) else v
                        for k, v in row.items()
                    }
                )
            file.flush()
            print(found[-1], flush=True)


def report():
    """Print how many true errors are within the stated ones, by kind of scan."""
    kinds = {
        "without noise": lambda r: float(r["noise"]) == 0.0,
        "with noise": lambda r: float(r["noise"]) and r["filter"] == "0 nm",
        "with noise, filtered": lambda r: r["filter"] != "0 nm",
        "all": lambda r: True,
    }
    lines = []
    for name, chosen in kinds.items():
        found = [row for row in stored() if chosen(row)]
        if not found:
            continue
        true, area, error = (
            np.array([float(row[key]) for row in found])
            for key in ("true", "area", "error")
        )
        ratio = abs(true - area) / error
        within = (f"{np.count_nonzero(ratio <= k)}" for k in (1, 2, 3))
        relative = (100.0 * np.median(x / area) for x in (abs(true - area), error))
        lines.append((name, len(found), *within, *(f"{x:.2g} %" for x in relative)))
    table(
        "scans | cases | within the stated error | twice | three times | "
        "median error | stated",
        lines,
    )


def main():
    """Calculate or report."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--report", action="store_true", help="print the table")
    if parser.parse_args().report:
        report()
        return
    with threads(1):
        calculate()


if __name__ == "__main__":
    main()
