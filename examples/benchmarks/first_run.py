"""Area of the built-in scene for eight realisations: ``examples/images/curve.png``.

    python first_run.py --picture ../images/curve.png    # draws first_run.csv
    python first_run.py --again                          # calculates the table again

The table has the load (eV/Å) and the contact area (Å²) of each step and seed.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from ase.units import J, m
from matplotlib.ticker import NullFormatter

from ase_roughcontact.plot import style
from ase_roughcontact.scene import Scene
from ase_roughcontact.theory import (
    KAPPA_REPULSIVE,
    Hertz,
    asperity_radius,
    low_load_plateau,
    mean_contact_pressure,
    predicted_area,
)

TABLE = Path(__file__).with_suffix(".csv")
SEEDS = range(1, 9)
NANONEWTON = 1e-9 * J / m


def calculate() -> None:
    """Relax the scene for each seed, and write the table."""
    rows = []
    for seed in SEEDS:
        scene = Scene.default().with_values({"roughness.seed": seed})
        for step in scene.relax(validity="ignore"):
            rows.append((seed, step.normal_force, step.contact_area))
    head = "seed,normal_force,contact_area"
    formats = ["%d", "%.6g", "%.6g"]
    np.savetxt(TABLE, rows, fmt=formats, delimiter=",", header=head, comments="")


def draw(picture: Path) -> None:
    """Draw the areas relative to Hertz beside the theories."""
    scene = Scene.default()
    radius, rough = scene.surface.radius, scene.surface.roughness
    modulus = scene.solid.contact_modulus
    hertz = Hertz(radius, modulus).contact_area
    seeds, loads, areas = np.loadtxt(TABLE, delimiter=",", skiprows=1).T
    along = np.geomspace(loads.min(), loads.max(), 100)
    pressure = mean_contact_pressure(rough.rms_slope, modulus, KAPPA_REPULSIVE)
    rho = float(asperity_radius(rough))
    eq4 = predicted_area(along, radius, modulus, pressure)
    with style():
        figure, axes = plt.subplots(figsize=(5.2, 3.4))
        axes.plot(along / NANONEWTON, eq4 / hertz(along), "k", label="Eq. (4)")
        plateau = low_load_plateau(3 * rho, radius)
        axes.axhline(plateau, color="#0072B2", ls="--", label="first asperity, 3ρ")
        for seed in SEEDS:
            chosen = seeds == seed
            x, y = loads[chosen], areas[chosen]
            first = seed == SEEDS[0]
            mark = {"color": "#D55E00", "ms": 5, "zorder": 3} if first else {}
            label = {1: "seed 1", 2: "seeds 2 to 8"}.get(seed)
            others = {"color": "0.6", "ms": 3, "zorder": 2}
            axes.plot(x / NANONEWTON, y / hertz(x), "o", label=label, **mark or others)
        axes.set(
            xscale="log",
            yscale="log",
            xlabel="normal force $N$ (nN)",
            ylabel=r"contact area $A/A_\mathrm{Hertz}$",
            yticks=[0.1, 0.2, 0.5, 1.0],
            yticklabels=["0.1", "0.2", "0.5", "1"],
        )
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.legend(loc="lower right", frameon=False)
        figure.savefig(picture, dpi=150)


def main() -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--again", action="store_true", help="calculate the table")
    parser.add_argument("--picture", type=Path, default=Path("first_run.png"))
    options = parser.parse_args()
    if options.again or not TABLE.exists():
        calculate()
    draw(options.picture)


if __name__ == "__main__":
    main()
