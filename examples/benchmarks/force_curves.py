"""Fits of synthetic force curves of rough tips, beside those of a smooth sphere.

    python examples/benchmarks/force_curves.py

For each seed a tip (radius 15 nm, rms slope 0.1, E* = 30 GPa, w = 0.1 J/m²) on a
cantilever of 2 N/m approaches and is pulled off; 150 points of each branch get a noise
of 0.1 nN. The fit begins at 0.06 J/m². ``--slope`` changes the roughness, ``--free``
the parameters, of which the first is printed with its error by noise, ``--tolerance``
that of the states, ``--picture`` draws the last fit.
"""

import argparse
from pathlib import Path

import numpy as np
from markdown import table

from ase_roughcontact import cantilever_curve
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.figures import draw_fit
from ase_roughcontact.fitting.fit import fit_curve
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.fitting.smooth_fit import smooth_fit
from ase_roughcontact.scene import Scene, relax_loop

WORK, FIRST, NOISE, POINTS, ZERO = 0.1, 0.06, 0.1 * UNITS["nN"], 150, 37.0
# those used while the method was developed, and others
SEEDS = (*range(1, 6), *range(11, 16))
SCENE = """
[substrate]
model = "atoms"
spacing = 3.0
shape = [40, 40]
contact_modulus = 30.0
hardness = inf
[sphere]
radius = "15 nm"
[roughness]
unit = "a0"
rms_slope = {slope}
long_wavelength = 16.0
seed = {seed}
[interaction]
kind = "adhesive"
work_of_adhesion = {work}
[path]
kind = "loop"
deepest = "0.4 nm"
cantilever_stiffness = 2.0
tolerance = {tolerance}
"""


def measured(scene, rng):
    """Return approach and retraction at equal steps of the base, with noise."""
    exact = cantilever_curve(relax_loop(scene, validity="ignore"), scene.cantilever)
    ends = exact.retraction.distance[[0, -1]]
    base = np.linspace(*ends, POINTS)
    down, up = (
        np.interp(base, each.distance[order], each.force[order])
        for each in (exact.approach, exact.retraction)
        for order in [np.argsort(each.distance, kind="stable")]
    )
    force = np.append(down[::-1], up[1:])
    force += NOISE * rng.normal(size=force.size)
    tip = np.append(base[::-1], base[1:]) + force / scene.cantilever
    return ForceCurve(ZERO - tip, force, scene.cantilever)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--slope", type=float, default=0.1)
    parser.add_argument("--seeds", type=int, nargs="+", default=SEEDS)
    parser.add_argument("--free", default="work_of_adhesion")
    parser.add_argument("--tolerance", type=float, default=1e-2)
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    rows = []
    for seed in options.seeds:
        values = {"slope": options.slope, "seed": seed}
        true = Scene.parse(SCENE.format(work=WORK, tolerance=1e-3, **values))
        curve = measured(true, np.random.default_rng(seed))
        start = Scene.parse(
            SCENE.format(work=FIRST, tolerance=options.tolerance, **values)
        )
        fit = fit_curve(start, curve, options.free.split(","))
        smooth = smooth_fit(start, curve)
        fitted = f"{fit.values[0]:.4f} ± {fit.contributions['noise'][0]:.4f}"
        rows.append((seed, fitted, f"{smooth.work_of_adhesion:.3f}"))
        if options.picture:
            draw_fit(fit, smooth, options.picture)
    table("seed | fit (J/m²) | smooth sphere, Maugis-Dugdale (J/m²)", rows)


if __name__ == "__main__":
    main()
