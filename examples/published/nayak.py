"""Area of rough flats of the same slope, over the breadth of the spectrum.

Nayak's parameter is 1.5 times mean square height times mean square curvature over the
fourth power of the rms slope. The longest wave is a quarter of a period of 512 points,
the shortest 8 to 64 points.
"""

import numpy as np
from published import Value, by, run
from rough_flats import pressed

from ase_roughcontact import SelfAffine

FIELDS = "short", "seed", "points", "nayak", "pressure", "area", "continuum", "error"
CASES = [(s, n, 512) for n in (1, 2, 3, 4) for s in (64.0, 32.0, 16.0, 8.0)]
QUICK = [(short, 1, 256) for short in (32.0, 8.0)]
PRESSURES = 0.05, 0.2


def calculate(short, seed, points):
    """Yield a row for each pressure: Nayak's parameter, areas over the nominal one."""
    rough = SelfAffine(0.1, 0.8, short, points / 4, seed=seed, domain=float(points))
    known = rough.statistics()
    nayak = 1.5 * (known.rms_height * known.rms_curvature / known.rms_slope**2) ** 2
    for pressure, (step, _) in zip(
        PRESSURES, pressed(rough, points, PRESSURES), strict=True
    ):
        areas = step.contact_area, step.continuum_area, step.continuum_area_error
        parts = (area / points**2 for area in areas)
        yield short, seed, points, nayak, pressure, *parts


def reported(rows):
    """Return the slope of kappa, in each realisation the mean over the pressures."""
    slopes = []
    for steps in by(rows, "seed").values():
        breadth, kappa = np.array(
            [(np.log(s["nayak"]), s["continuum"] / s["pressure"]) for s in steps]
        ).T
        slopes.append(np.polyfit(breadth, kappa, 1)[0])
    slope = Value.mean(slopes)
    return {"nayak": Value(slope.value, slope.error, slope.value + 2.0 * slope.error)}


if __name__ == "__main__":
    run(__file__, FIELDS, CASES, calculate)
