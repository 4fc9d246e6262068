"""Twenty seeds of each kind of random roughness, by the package SurfaceTopography.

    python realisations.py             # writes realisations.csv and realisations.png
    python realisations.py --report    # the table of the guide, from its rows

The scan is synthetic: a surface with long waves along one direction, of which the peaks
are worn, so that its heights are not Gaussian. SurfaceTopography gives rms slopes by
differences of neighbouring points, and rms heights by the integral of its spectrum. The
expected values follow from the continuous spectrum, for slopes with the factor
sin(q a/2)/(q a/2) of differences along each axis; of a scan from the scan itself.
"""

import argparse
import csv
from dataclasses import replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from markdown import table

from ase_roughcontact import HeightMap, SelfAffine, TabulatedSpectrum
from ase_roughcontact.plot import style
from ase_roughcontact.topography.realisation import distribution_error

TABLE = Path(__file__).with_suffix(".csv")
SEEDS, POINTS, STEP = 20, 256, 2.0
SIDE = POINTS * STEP
BAND = {"short_wavelength": 16.0, "long_wavelength": 64.0, "domain": SIDE}
HURST = 0.8


def scan():
    """Return heights of a worn surface with a lay, shape (256, 256), in Å."""
    waves = SelfAffine(
        0.1, HURST, **BAND, anisotropy=2.0, direction=60.0, seed=11
    ).heights((POINTS, POINTS), STEP)
    level = 0.3 * waves.std()
    return waves - 0.9 * np.maximum(waves - level, 0.0)


def spectrum():
    """Return a table of a spectrum with a shoulder: q (1/Å) and C2D (Å^4)."""
    q = np.geomspace(2 * np.pi / 128.0, 2 * np.pi / 16.0, 30)
    return q, 5.0 / (1.0 + (q / 0.1) ** 2) ** 2


def kinds():
    """Return functions of the seed that give heights, and the mean power of waves."""
    height_map = HeightMap(scan(), STEP, periodic=True)
    corner = tuple(-np.array(height_map.center))
    roll_off = SelfAffine(0.1, HURST, **BAND, longest_wavelength=128.0)
    lay = SelfAffine(0.1, HURST, **BAND, anisotropy=2.0, direction=30.0)
    tabulated = TabulatedSpectrum(*spectrum(), domain=SIDE)

    def of_waves(rough):
        return lambda seed: replace(rough, seed=seed).heights((POINTS, POINTS), STEP)

    def of_scan(seed):
        return height_map.realisation(seed).heights((POINTS, POINTS), STEP, corner)

    return {
        "self-affine with roll-off": of_waves(roll_off),
        "anisotropic": of_waves(lay),
        "table of a spectrum": of_waves(tabulated),
        "realisation of a scan": of_scan,
    }


def density(kind, q_x, q_y):
    """Return the expected C(q) of a kind on a grid of wave vectors, up to a factor."""
    q = np.hypot(q_x, q_y)
    if kind == "realisation of a scan":
        return abs(np.fft.fft2(scan(), norm="forward")) ** 2 * SIDE**2
    if kind == "table of a spectrum":
        table_q, table_c = spectrum()
        inside = (q > table_q[0] - 1e-9) & (q < table_q[-1] + 1e-9)
        safe = np.maximum(q, table_q[0])
        return inside * np.exp(
            np.interp(np.log(safe), np.log(table_q), np.log(table_c))
        )
    longest = 64.0
    if kind == "anisotropic":
        angle = np.radians(30.0)
        along = np.cos(angle) * q_x + np.sin(angle) * q_y
        across = np.cos(angle) * q_y - np.sin(angle) * q_x
        q = np.hypot(2.0 * along, across)
    else:
        longest = 128.0
    inside = (q > 0.9999 * 2 * np.pi / longest) & (q < 1.0001 * 2 * np.pi / 16.0)
    power = inside * np.maximum(q, 2 * np.pi / 64.0) ** (-2 - 2 * HURST)
    slope = np.sqrt((np.hypot(q_x, q_y) ** 2 * power).sum()) / SIDE
    return power * (0.1 / slope) ** 2


def expected(kind):
    """Return rms height (Å) and the rms slope by differences of neighbours."""
    q = 2 * np.pi * np.fft.fftfreq(POINTS, STEP)
    power = density(kind, q[:, None], q[None, :]) / SIDE**2
    power[0, 0] = 0.0
    difference = (2.0 / STEP * np.sin(0.5 * q * STEP)) ** 2
    square = difference[:, None] + difference
    return np.sqrt(power.sum()), np.sqrt((square * power).sum())


def of_peer(heights):
    """Return rms height and slope by SurfaceTopography."""
    from SurfaceTopography import Topography

    heights = heights - heights.mean()
    topography = Topography(heights, (SIDE, SIDE), periodic=True)
    q, profile = topography.power_spectrum_from_profile(
        resampling_method=None, reliable=False
    )
    # 1/pi times the integral over q, with half of the bin at zero
    height = np.sqrt((profile.sum() - 0.5 * profile[0]) * (q[1] - q[0]) / np.pi)
    return height, topography.rms_gradient()


def run():
    """Write the means over the seeds, and the figure of three realisations."""
    rows = []
    for kind, make in kinds().items():
        surfaces = [make(seed) for seed in range(SEEDS)]
        heights, slopes = np.transpose([of_peer(each) for each in surfaces])
        height, slope = expected(kind)
        deviation = np.nan
        if kind == "realisation of a scan":
            deviation = max(distribution_error(scan(), each) for each in surfaces)
        numbers = (
            *(height, heights.mean(), abs(heights / height - 1.0).max()),
            *(slope, slopes.mean(), abs(slopes / slope - 1.0).max(), deviation),
        )
        rows.append([kind, *(f"{number:.5g}" for number in numbers)])
    with Path("realisations.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(
            [
                "kind",
                "height",
                "height_mean",
                "height_error",
                "slope",
                "slope_mean",
                "slope_error",
                "distribution",
            ]
        )
        writer.writerows(rows)
    draw(kinds()["realisation of a scan"])


def draw(make):
    """Draw the scan, three realisations and their distributions of heights."""
    maps = {"scan": scan(), **{f"seed {seed}": make(seed) for seed in range(3)}}
    least, most = scan().min(), scan().max()
    with style():
        figure, panels = plt.subplots(
            1, 5, figsize=(6.8, 1.7), width_ratios=[1, 1, 1, 1, 1.3]
        )
        for panel, (name, heights) in zip(panels, maps.items(), strict=False):
            panel.imshow(
                heights.T / 10.0, origin="lower", vmin=least / 10.0, vmax=most / 10.0
            )
            panel.set(title=name, xticks=[], yticks=[])
        for name, heights in maps.items():
            values, edges = np.histogram(heights / 10.0, 40, density=True)
            middles = 0.5 * (edges[1:] + edges[:-1])
            look = {"color": "k", "lw": 1.5} if name == "scan" else {"lw": 0.7}
            panels[4].plot(middles, values, label=name, **look)
        panels[4].set(xlabel="height (nm)", ylabel="density (1/nm)")
        figure.savefig("realisations.png", dpi=150)


def report():
    """Print means over the seeds beside the expected values."""
    with TABLE.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    cells = []
    for row in rows:
        line = [row["kind"]]
        for name in ("height", "slope"):
            scale = 0.1 if name == "height" else 1.0
            value, mean = (scale * float(row[k]) for k in (name, f"{name}_mean"))
            error = float(row[f"{name}_error"])
            line += [f"{value:.4g}", f"{mean:.4g}"]
            line.append("< 1e-9" if error < 1e-9 else f"{error:.0e}")
        cells.append(line)
    table(
        "20 seeds | rms height (nm), expected | mean | largest relative error | "
        "slope, expected | mean | largest relative error",
        cells,
    )
    error = np.nanmax([float(row["distribution"]) for row in rows])
    print()
    print(
        "Root mean square difference of the heights of realisations and scan, sorted by"
    )
    print(f"size: at most {100 * error:.1g} % of the rms height.")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--report", action="store_true")
    if parser.parse_args().report:
        report()
    else:
        run()
