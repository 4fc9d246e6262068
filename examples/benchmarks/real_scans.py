"""What is read from files of microscopes and profilometers, beside SurfaceTopography.

    python real_scans.py FOLDER      # writes real_scans.csv
    python real_scans.py --report    # the table, from the stored rows

The folder has files in any formats, such as tests/file_format_examples of the source
code of SurfaceTopography (MIT licence). Of several heights the first is read; files
without sizes or unit are read with pixels of 1 nm, in nm. The rms heights are those of
the known points about their mean (of profiles about a straight line), before anything
else is subtracted, by this package and by SurfaceTopography alone.
"""

import argparse
import csv
import re
import warnings
from pathlib import Path

import numpy as np
from markdown import table

from ase_roughcontact import HeightMap
from ase_roughcontact._util.units import LENGTHS, UNITS
from ase_roughcontact.topography.profile import LineProfile
from ase_roughcontact.topography.scan_files import read_scan

TABLE = Path(__file__).with_name("real_scans.csv")
FIELDS = (
    "file",
    "kind",
    "given",
    "points",
    "pixel",
    "missing",
    "rms",
    "other",
    "doubt",
)
NM = UNITS["nm"]


def first_height(file):
    """Return the number of the first of several heights, else None."""
    try:
        read_scan(file)
    except ValueError as error:
        several = re.search(r"could be the height.*?: .*?(\d+) '", str(error))
        if several:
            return int(several[1])
    return None


def row(file):
    """Return what is read from a file."""
    channel = first_height(file)
    found = {
        "file": file.name,
        "given": "" if channel is None else f"channel {channel}",
    }
    try:
        raw = read_scan(file, channel)
    except ValueError as error:
        return found | {"kind": "error", "doubt": str(error).partition(": ")[2]}
    unit = raw.unit or "nm"
    if raw.unit is None:
        found["given"] = ", ".join(filter(None, (found["given"], "unit")))
    found["other"] = by_surface_topography(file, channel, unit)
    if isinstance(raw, LineProfile):
        height, _slope = raw.statistics(unit)
        points = len(raw.heights)
        return found | {
            "kind": "profile",
            "points": points,
            "rms": f"{height / NM:.6g}",
            "doubt": "",
        }
    spacing = {} if raw.spacing else {"spacing": 1.0}
    if spacing:
        found["given"] += ", spacing"
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always")
        surface = HeightMap.from_topography(
            file, "substrate", detrend="mean", channel=channel, unit=unit, **spacing
        )
    n, m = raw.heights.shape
    x, y = (f"{step / NM:.6g}" for step in surface.spacing)
    return found | {
        "kind": "scan",
        "points": f"{n} x {m}",
        "pixel": x if x == y else f"{x} x {y}",
        "missing": surface.measurement.missing,
        "rms": f"{np.nanstd(raw.heights) * LENGTHS[unit] / NM:.6g}",
        "doubt": "; ".join(str(each.message).partition(": if")[0] for each in doubts),
    }


def by_surface_topography(file, channel, unit):
    """Return the rms height (nm) by SurfaceTopography, empty if it reads none."""
    from SurfaceTopography import open_topography

    try:
        with warnings.catch_warnings(), open_topography(str(file)) as reader:
            warnings.simplefilter("ignore")
            sizes = reader.channels[channel or 0].physical_sizes
            points = reader.channels[channel or 0].nb_grid_pts
            topography = reader.topography(
                channel_index=channel, physical_sizes=None if sizes else points
            )
            unit = topography.unit or unit
            if topography.dim == 1:
                height = topography.detrend("height").rms_height_from_profile()
            else:
                height = np.ma.masked_invalid(topography.heights()).std()
    except Exception:  # it has errors of many kinds
        return ""
    return f"{height * LENGTHS[unit] / NM:.6g}"


def calculate(folder):
    """Write the rows of all files of a folder."""
    files = sorted(each for each in Path(folder).iterdir() if each.is_file())
    with TABLE.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, FIELDS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(map(row, files))


def report():
    """Print the table."""
    with TABLE.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    table(
        "file | read as | given | points | pixel (nm) | missing | rms height (nm) "
        "| SurfaceTopography | doubts",
        [[each[name] for name in FIELDS] for each in rows],
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?")
    parser.add_argument("--report", action="store_true")
    options = parser.parse_args()
    report() if options.report else calculate(options.folder)
