"""Area and stiffness of lightly loaded rough flats, against the load.

Roughness from 8 to 64 points, 512 points in a period.
"""

import numpy as np
from published import Value, by, run
from rough_flats import pressed

from ase_roughcontact import SelfAffine

FIELDS = (
    *("hurst", "seed", "points"),
    *("pressure", "area", "continuum", "error", "stiffness"),
)
CASES = [(hurst, seed, 512) for seed in (1, 2, 3, 4) for hurst in (0.8, 0.3)]
QUICK = [(hurst, 1, 256) for hurst in (0.8, 0.3)]
PRESSURES = 0.005, 0.01, 0.02, 0.04


def calculate(hurst, seed, points):
    """Yield a row for each pressure: areas over the nominal one, stiffness."""
    rough = SelfAffine(0.1, hurst, 8.0, points / 8, seed=seed, domain=float(points))
    for pressure, (step, _) in zip(
        PRESSURES, pressed(rough, points, PRESSURES), strict=True
    ):
        areas = step.contact_area, step.continuum_area, step.continuum_area_error
        parts = (area / points**2 for area in areas)
        yield hurst, seed, points, pressure, *parts, step.contact_stiffness


def reported(rows):
    """Return kappa, its change with the Hurst exponent, and the exponent."""
    light = [row for row in rows if 0.01 <= row["continuum"] <= 0.1]
    kappas, slopes = {}, []
    for case, steps in by(light, "hurst", "seed").items():
        pressure, area, stiffness = (
            np.array([step[name] for step in steps])
            for name in ("pressure", "continuum", "stiffness")
        )
        kappas[case] = float((area / pressure).mean())
        slopes.append(np.polyfit(np.log(pressure), np.log(stiffness), 1)[0])
    smooth, rough = (
        Value.mean(kappa for (each, _), kappa in kappas.items() if each == hurst)
        for hurst in (0.8, 0.3)
    )
    both = Value.mean(kappas.values())
    change = (rough.value - smooth.value) / both.value
    error = np.hypot(rough.error, smooth.error) / both.value
    return {
        "kappa": both,
        "kappa_two": both,
        "kappa_hurst": Value(change, error),
        "stiffness_linear": Value.mean(slopes),
    }


if __name__ == "__main__":
    run(__file__, FIELDS, CASES, calculate)
