"""
An ensemble in an ASE database
==============================

Spheres that differ in the seed of their roughness are pressed into silicon, on all
processors of the machine. Steps are stored in an ASE database as they are finished, so
that a run that was stopped continues where it was.
"""

from dataclasses import replace

import matplotlib.pyplot as plt
import numpy as np
from ase.db import connect

from ase_roughcontact import nN
from ase_roughcontact.ensemble import product, read_ensemble, run_ensemble
from ase_roughcontact.plot import plot_curve, style
from ase_roughcontact.scene import Scene, Steps

SEEDS = 8
LOADS = (3.0, 10.0, 30.0, 100.0, 300.0)  # nN
WORKERS = None  # one process for each processor
DATABASE = "spheres.db"

# %%
# A ``Scene`` describes a whole calculation, as a TOML file does. ``product`` makes one
# scene for each combination of values.

scene = replace(Scene.default(), path=Steps(loads=LOADS))
scenes = product(scene, {"roughness.seed": range(SEEDS)})


def calculate():
    """Calculate the steps that are not in the database yet."""
    for progress in run_ensemble(scenes, DATABASE, workers=WORKERS):
        print(progress)


# %%
# ``read_ensemble`` returns the columns of the database as arrays. The command
# ``ase db spheres.db record=step,seed=0 -c target,contact_area,converged`` shows the
# same rows.


def evaluate():
    """Draw area against load, and return the ratio to Eq. (4) at the last load."""
    loads = np.array(LOADS) * nN
    steps = read_ensemble(DATABASE, "converged=True")
    converged, expected = steps["step"].size, SEEDS * len(loads)
    if converged != expected:
        raise RuntimeError(f"{DATABASE}: {converged} steps converged, not {expected}")
    order = np.lexsort([steps["target"], steps["seed"]])
    areas = steps["contact_area"][order].reshape(SEEDS, len(loads))
    bodies = scene.bodies
    hertz, predicted = bodies.hertz_area(loads), bodies.predicted_area(loads)
    smooth = np.geomspace(loads[0], loads[-1], 50)
    relative = bodies.predicted_area(smooth) / bodies.hertz_area(smooth)
    eq4 = smooth / nN, relative
    options = {"theory": {"Eq. (4)": eq4}, "label": f"mean of {SEEDS} spheres"}
    with style():
        figure, axes = plt.subplots()
        lines = axes.plot(LOADS, (areas / hertz).T, color="0.8", zorder=0)
        lines[0].set_label("each sphere")
        plot_curve(axes, np.array(LOADS), areas.mean(axis=0), hertz, **options)
        figure.savefig("ensemble_database.png", dpi=200)
    light = connect(DATABASE).count("record=step,repulsive_atoms<100")
    print(f"{light} of {areas.size} steps have fewer than 100 atoms in contact")
    ratios = areas[:, -1] / predicted[-1]
    error = ratios.std(ddof=1) / np.sqrt(SEEDS)
    print(f"area at {LOADS[-1]:g} nN: {ratios.mean():.3f} +- {error:.3f} of Eq. (4)")
    return float(ratios.mean())


# %%
# Worker processes import this file, so what it calculates must be guarded.

if __name__ == "__main__":
    calculate()
    ratio = evaluate()
