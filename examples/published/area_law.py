"""Area of rough flats from 5 to 80 %, against the law of Y. Xu's program.

Roughness over two decades, H = 0.8, no roll-off, and one longest wave in the period.
"""

import numpy as np
from published import Value, by, finest, run
from rough_flats import pressed
from scipy.optimize import brentq
from scipy.special import erf

from ase_roughcontact import SelfAffine

FIELDS = "seed", "points", "law", "area", "continuum", "error"
CASES = [(seed, 512) for seed in range(1, 7)] + [(1, 1024)]
QUICK = [(1, 512)]
FACTOR = 0.45
AREAS = 0.05, 0.1, 0.2, 0.4, 0.6, 0.8


def law(pressure):
    """Return the area over the nominal one; pressures in units of slope and modulus."""
    variance = 0.25
    width = 2.0 * variance

    def excess(area):
        return area - erf(pressure / np.sqrt(width * (FACTOR + (1.0 - FACTOR) * area)))

    return brentq(excess, 0.0, 1.0)


def pressure_of_area(area):
    """Return the pressure at which the law has an area."""
    return brentq(lambda pressure: law(pressure) - area, 1e-6, 3.0)


def calculate(seed, points):
    """Yield a row for each pressure: area of the law, areas over the nominal one."""
    period = float(points)
    rough = SelfAffine(0.1, 0.8, period / 100, period, seed=seed, domain=period)
    pressures = [pressure_of_area(area) for area in AREAS]
    for area, (step, _) in zip(AREAS, pressed(rough, points, pressures), strict=True):
        areas = step.contact_area, step.continuum_area, step.continuum_area_error
        yield seed, points, area, *(each / points**2 for each in areas)


def reported(rows):
    """Return the largest relative deviation of the mean over the seeds."""
    deviations = []
    for (area,), steps in by(finest(rows), "law").items():
        deviations.append(Value.mean(step["continuum"] / area - 1.0 for step in steps))
    return {"area_law": max(deviations, key=lambda deviation: abs(deviation.value))}


if __name__ == "__main__":
    run(__file__, FIELDS, CASES, calculate)
