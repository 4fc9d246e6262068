"""Pressures in the contact-mechanics challenge without adhesion, at 250 kPa.

A period of 100 µm, roll-off from 20 µm, H = 0.8, unit rms slope, E* = 25 MPa. The
shortest wave is 2 pi/(10 per µm), as in `Fig_3d_program.m` beside the published data.
"""

import math

import numpy as np
from published import Value, by, finest, run
from rough_flats import pressed

from ase_roughcontact import SelfAffine
from ase_roughcontact.analysis import ContactMap, pressure_distribution

FIELDS = (
    *("seed", "points"),
    *("pressure", "density", "area", "continuum", "error"),
)
CASES = [(1, 1024), (2, 1024), (3, 1024), (1, 2048)]
QUICK = [(1, 512)]
EDGES = np.linspace(0.0, 1.5, 31)  # over E*


def calculate(seed, points):
    """Yield a row for each bin of the pressure over E*: density over all points."""
    rough = SelfAffine(
        *(1.0, 0.8, 2.0 * math.pi / 10.0, 20.0),
        longest_wavelength=100.0,
        domain=100.0,
        seed=seed,
    )
    ((step, atoms),) = pressed(rough, points, [0.25 / 25.0])
    found = pressure_distribution(ContactMap.from_atoms(atoms), EDGES)
    part = step.contact_area / 100.0**2
    areas = step.contact_area, step.continuum_area, step.continuum_area_error
    for pressure, density in zip(found.value, found.density, strict=True):
        row = (area / 100.0**2 for area in areas)
        yield seed, points, pressure, part * density, *row


def reported(rows):
    """Return the area and the most frequent pressure, of a parabola at the maximum."""
    areas, peaks = [], []
    for bins in by(finest(rows), "seed").values():
        pressure = np.array([each["pressure"] for each in bins])
        density = np.array([each["density"] for each in bins])
        near = (pressure > 0.15) & (pressure < 0.55)
        square, linear, _ = np.polyfit(pressure[near], density[near], 2)
        areas.append(bins[0]["continuum"])
        peaks.append(-linear / (2.0 * square))
    return {"challenge_area": Value.mean(areas), "challenge_peak": Value.mean(peaks)}


if __name__ == "__main__":
    run(__file__, FIELDS, CASES, calculate)
