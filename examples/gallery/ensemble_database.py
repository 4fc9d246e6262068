"""An ensemble of rough spheres in an ASE database.

    python examples/gallery/ensemble_database.py --seeds 8 --out spheres.db
    ase db spheres.db record=step,seed=0 -c target,contact_area,converged

presses spheres that differ in the seed of their roughness into copper, on all
processors. A run that was stopped goes on where it was.
"""

import argparse
from dataclasses import replace

import numpy as np
from ase.db import connect
from matplotlib.figure import Figure

from ase_roughcontact.ensemble import product, read_ensemble, run_ensemble
from ase_roughcontact.plot import plot_curve, style
from ase_roughcontact.scene import NANONEWTON, PathConfig, Scene


def main(arguments: list[str] | None = None) -> float:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--loads", type=float, nargs="+", default=[3, 10, 30, 100, 300])
    parser.add_argument("--workers", type=int, help="by default one per processor")
    parser.add_argument("--out", default="spheres.db")
    parser.add_argument("--picture", default="ensemble_database.png")
    options = parser.parse_args(arguments)
    path = PathConfig(values=tuple(options.loads))  # in nN
    scene = replace(Scene.default(), path=path)
    scenes = product(scene, {"roughness.seed": range(options.seeds)})
    for progress in run_ensemble(scenes, options.out, workers=options.workers):
        print(progress)

    loads = np.array(options.loads) * NANONEWTON
    steps = read_ensemble(options.out, "converged=True")
    known, wanted = steps["step"].size, options.seeds * len(loads)
    if known != wanted:
        raise RuntimeError(f"{options.out}: {known} steps converged, not {wanted}")
    order = np.lexsort([steps["target"], steps["seed"]])
    areas = steps["contact_area"][order].reshape(options.seeds, len(loads))
    hertz, predicted = scene.hertz_area(loads), scene.predicted_area(loads)
    ratio = areas / predicted
    with style():
        axes = Figure().subplots()
        axes.plot(options.loads, (areas / hertz).T, color="0.8", zorder=0)
        plot_curve(axes, np.array(options.loads), areas.mean(axis=0), hertz, predicted)
        axes.figure.savefig(options.picture, dpi=200)
    # the database answers other questions, too
    light = connect(options.out).count("record=step,repulsive_atoms<100")
    print(f"{light} of {areas.size} steps have fewer than 100 atoms in contact")
    error = ratio[:, -1].std(ddof=1) / np.sqrt(options.seeds)
    print(f"area at {options.loads[-1]:g} nN: {ratio[:, -1].mean():.3f} +- {error:.3f} "
          "of Eq. (4)")  # fmt: skip
    return float(ratio[:, -1].mean())


if __name__ == "__main__":
    main()
