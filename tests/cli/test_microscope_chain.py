"""From the files of a microscope to a fit and a page: scan, force curve, report.

The scan has tilt, drift, noise and missing points; the curve has noise, an unknown zero
of the height, and a deflection with an offset and a drift.
"""

import csv
import re

import numpy as np
import pytest
from microscope_files import write_gwy

from ase_roughcontact.cli import main

PIXEL, SIDE = 1.0, 48  # nm, points
WORK, OFFSET, SLOPE = 0.08, 0.4, -0.03  # J/m², nN, nN/nm
STIFFNESS = 10.0  # N/m
SCENE = """
[substrate]
material = "Si"
spacing = "0.5 nm"
shape = [24, 24]
hardness = inf
[sphere]
material = "Si3N4"
radius = "20 nm"
[topography]
file = "scan.gwy"
role = "substrate"
detrend = "lines"
center = "highest"
margin = "12 nm"
[interaction]
kind = "adhesive"
work_of_adhesion = "0.08 J/m^2"
[path]
kind = "loop"
deepest = "0.15 nm"
tolerance = 0.01
cantilever = "10 N/m"
"""


def scan(rng):
    """Rough surface (nm) with tilt, drift between lines, noise and missing points."""
    qx, qy = np.fft.fftfreq(SIDE)[:, None], np.fft.fftfreq(SIDE)
    square = np.maximum(qx**2 + qy**2, SIDE**-2.0)
    waves = np.fft.fft2(rng.normal(size=(SIDE, SIDE)))
    heights = np.fft.ifft2(np.where(square < 0.04, square**-0.9, 0.0) * waves).real
    heights *= 0.5 / heights.std()
    x = PIXEL * np.arange(SIDE)
    heights += 0.02 * x[:, None] + np.cumsum(rng.normal(0.0, 0.05, SIDE))
    heights += rng.normal(0.0, 0.02, heights.shape)
    heights[rng.random(heights.shape) < 0.003] = np.nan
    return heights


def write_curve(exact, file, rng):
    """Both branches at 100 heights of the base, with noise, drift and other zeros."""
    with open(exact) as table:
        rows = list(csv.DictReader(table))
    lines = ["branch,distance (nm),deflection (nm),force (nN)"]
    for branch, order in ("approach", -1), ("retraction", 1):
        points = [row for row in rows if row["branch"] == branch]
        base, force = (
            np.array([float(row[column]) for row in points])
            for column in ("distance (nm)", "force (nN)")
        )
        upward = np.argsort(base, kind="stable")
        places = np.linspace(base.min(), 2.5, 100)[::order]
        noisy = np.interp(places, base[upward], force[upward])
        noisy += rng.normal(0.0, 0.05, len(places)) + OFFSET + SLOPE * (places - 2.5)
        lines += [
            f"{branch},{12.3 + z},{f / STIFFNESS},{f}"
            for z, f in zip(places, noisy, strict=True)
        ]
    file.write_text("\n".join(lines))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*noise makes up:UserWarning")
def test_a_scan_and_a_force_curve_become_a_fit_and_a_page(
    topography, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(7)
    write_gwy(tmp_path / "scan.gwy", scan(rng), (PIXEL, PIXEL))
    (tmp_path / "my.toml").write_text(SCENE)
    assert main(["run", "my.toml", "--out", "results", "--quiet"]) == 0
    write_curve("results/cantilever.csv", tmp_path / "curve.csv", rng)
    (tmp_path / "fit.toml").write_text(SCENE.replace(str(WORK), "0.05"))
    capsys.readouterr()
    free = "work_of_adhesion,force_offset,force_slope"
    assert main(["fit", "curve.csv", "fit.toml", "--free", free]) == 0
    printed = capsys.readouterr().out
    assert "warning:" not in printed  # also if the curve ends under little force
    for parameter, true, largest in (
        ("work_of_adhesion", WORK, 0.01),
        ("force_offset", OFFSET, 0.03),
        ("force_slope", SLOPE, 0.02),
    ):
        found = re.search(rf"{parameter} +(\S+) +(\S+) +\S+ +(\S+) ", printed)
        value, error, by_noise = map(float, found.groups())
        assert abs(value - true) < 3 * by_noise < 3 * largest
        assert by_noise < error
    assert main(["report", "results"]) == 0
    page = (tmp_path / "results" / "report.html").read_text()
    assert page.count("<img") == 5 and "scan.gwy" in page
    assert "10 N/m" in page and "cantilever snap-in" in page
