"""Error of the contact area by the fields at its edge, for many surfaces.

    OMP_NUM_THREADS=1 python edge_area.py

Spheres and nominally flat surfaces under a hard wall, for the loads, Hurst exponents,
slopes and seeds of `grid_error.py`, on grids of a0 to a0/8. Errors are relative to the
finest grid.
"""

from collections import defaultdict

import numpy as np
from grid_error import CONTACT_RADII, PRESSURES, RADIUS, SIDE, SPHERE, cases
from markdown import table

from ase_roughcontact import (
    HardWall,
    RoughContact,
    RoughSphere,
    SelfAffine,
    load_path,
    substrate,
)

SPACINGS = (1.0, 0.5, 0.25, 0.125)


def steps(shape, slope, hurst, seed, spacing):
    """Return the steps of a path on one grid, as in grid_error.py."""
    flat = shape == "flat"
    domain = float(SIDE if flat else 128)
    rough = SelfAffine(slope, hurst, 4.0, 32.0, seed=seed, domain=domain)
    surface = RoughSphere(np.inf if flat else RADIUS, rough)
    loads = PRESSURES * slope * SIDE**2 if flat else SPHERE.force(CONTACT_RADII)
    points = round(SIDE / spacing) if flat else 8
    atoms = substrate(
        "Cu", (points, points), surface, spacing=spacing, periodic=flat, fixed=False
    )
    atoms.calc = RoughContact(surface, 1.0, HardWall())
    window = "fixed" if flat else "auto"
    grid = {"grid": "a0", "accuracy": 1e-4}
    return list(load_path(atoms, loads=loads, window=window, validity="ignore", **grid))


def main():
    """Print mean and largest errors, and the share within twice the estimate."""
    errors = defaultdict(list)
    for shape, wall, slope, hurst, seed in cases():
        if wall != "hard":
            continue
        *grids, exact = (steps(shape, slope, hurst, seed, dx) for dx in SPACINGS)
        for spacing, found in zip(SPACINGS, grids, strict=False):
            for load, (step, best) in enumerate(zip(found, exact, strict=True)):
                error = step.continuum_area / best.continuum_area - 1.0
                estimate = step.area_error / best.continuum_area
                errors[shape, spacing, load].append((error, estimate))
    rows = []
    for shape, loads in (("flat", PRESSURES), ("sphere", CONTACT_RADII)):
        for load, value in enumerate(loads):
            cells = []
            for spacing in SPACINGS[:-1]:
                error = 100 * np.transpose(errors[shape, spacing, load])[0]
                cells.append(f"{error.mean():.1f}, {abs(error).max():.1f}")
            name = f"mean pressure {value:g} $h'E^*$"
            if shape == "sphere":
                name = f"Hertz radius {value:g} $a_0$"
            rows.append((f"{shape}, {name}", *cells))
    table("contact | grid of $a_0$ | $a_0/2$ | $a_0/4$", rows)
    error, estimate = np.transpose(
        [pair for found in errors.values() for pair in found]
    )
    held = np.sum(abs(error) <= 2 * estimate)
    print(f"\n{held} of {len(error)} errors are within twice the estimate.")


if __name__ == "__main__":
    main()
