"""
Fig. 2: contact area against load
=================================

The contact area of rough spheres from the first contact to the limit of Hertz::

    python examples/paper/figure2.py --scale quick

Steps that the table ``results/figure2-*.csv`` does not contain yet are calculated, in
parallel, and added to it. ``--draw`` only draws. At ``--scale quick`` this takes
minutes; all steps of the figure as printed (``--scale paper``) take four to five hours.

.. image:: ../../images/figure2.png
"""

# sphinx_gallery_thumbnail_path = '../images/figure2.png'

import argparse
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from flat_reference import flat_fraction
from paper_scenes import (
    BANDS,
    Curve,
    curves,
    fill_database,
    read_table,
    scenes,
    theory,
)

from ase_roughcontact.ensemble import (
    run_ensemble,
    write_csv,
)
from ase_roughcontact.plot import BLUE, COLOURS, ORANGE, style
from ase_roughcontact.theory import (
    Hertz,
    contact_fraction,
    low_load_plateau,
    predicted_area,
)

HERE = Path(__file__).parent
SLOPE_COLOURS = {0.1: ORANGE, 0.01: BLUE}
WORK_COLOURS = {0.0005: COLOURS[5], 0.005: COLOURS[4]}
MARKERS = {1e2: "o", 1e3: "s", 1e4: "^", 1e5: "D"}
STYLES = {1e3: "-", 1e5: "--"}
# Contacts of fewer atoms are drawn pale: there is no circle of one atom.
FEWEST = 3.0
LIMITS = {"xlim": (1e-14, 1e6), "ylim": (2e-3, 8)}


def calculate(scale: str, table: Path, database: Path, workers: int | None) -> None:
    """Calculate the steps that neither table nor database hold."""
    if table.exists():
        fill_database(database, table)
    for band in scenes(scale):
        running = run_ensemble(band, database, workers=workers)
        try:
            for progress in running:
                print(f"\r{progress}", end="    ", flush=True)
        finally:  # also when stopped; not at each step, as it takes seconds
            print()
            write_csv(database, table)


def draw(table: Path, picture: Path) -> None:
    """Draw the curves of a table beside the paper's formulas."""
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    found = curves(read_table(table))
    figure, axes = plt.subplots(2, 2, figsize=(6.8, 6.0))
    hard, repulsive, adhesive, names = axes.flat
    for curve in found:
        axes = {"hard": hard, "repulsive": repulsive, "adhesive": adhesive}[curve.kind]
        (draw_adhesive if curve.work else draw_repulsive)(axes, curve)
    for axes in (hard, repulsive):
        draw_fraction(axes)
    hard.set_title(r"(a) hard wall, $N_c$ with $\kappa$ = 2")
    repulsive.set_title(r"(b) repulsive 9-3 wall, $N_c$ with $\kappa$ = 2.9")
    adhesive.set_title(r"(c) adhesive, $h'_\mathrm{rms}$ = 0.1, $N_c$ as in (b)")
    for axes in (hard, repulsive, adhesive):
        axes.set(xscale="log", yscale="log", xlabel="normal force $N/N_c$", **LIMITS)
        axes.set_ylabel(r"contact area $A/A_\mathrm{Hertz}$")
        axes.axhline(1.0, color="0.6", lw=0.7, zorder=0)
    adhesive.set_ylim(3e-3, 3e3)
    hard.plot([], [], "ko", ms=4, mfc="white", label="number of atoms")
    hard.plot([], [], "k.", ms=3, label="corrected for the grid")
    adhesive.plot([], [], "k-", lw=0.8, label=r"Eq. (4) with $f$ of rough flats")
    adhesive.plot([], [], "k:", lw=0.8, label=r"Eq. (4) with $\kappa_\mathrm{adh}$")
    names.axis("off")
    above, below = (axes.get_legend_handles_labels() for axes in (hard, adhesive))
    both = (first + second for first, second in zip(above, below, strict=True))
    names.legend(*both, loc="center")
    figure.savefig(picture, dpi=180)
    plt.close(figure)


def draw_repulsive(axes: Any, curve: Curve) -> None:
    """Mean and standard deviation of the realisations, and the first asperity.

    Dots are means of areas corrected for the grid.
    """
    load = curve.loads / curve.theory.crossover_load
    ratio = curve.areas / curve.hertz[:, None]
    mean, deviation = np.nanmean(ratio, axis=1), np.nanstd(ratio, axis=1)
    colour, marker = SLOPE_COLOURS[curve.slope], MARKERS[curve.radius]
    seen = np.nanmean(curve.areas, axis=1) >= FEWEST
    axes.plot(load, mean, "-", color=colour, lw=0.8, alpha=0.3)
    style = {"fmt": marker, "color": colour, "ms": 4, "lw": 0.8, "mfc": "white"}
    name = f"$R$ = {curve.radius:g} $a_0$, $h'_\\mathrm{{rms}}$ = {curve.slope:g}"
    axes.errorbar(load[seen], mean[seen], deviation[seen], label=name, **style)
    corrected = (curve.corrected / curve.hertz[:, None]).mean(axis=1)
    axes.plot(load[seen], corrected[seen], "k.", ms=3, zorder=3)
    rho = curve.theory.asperity_radius
    plateau = low_load_plateau(rho, curve.radius)
    end = (rho / curve.radius) ** 2  # N_c(rho)
    axes.plot([end * 1e-3, end], [plateau, plateau], color="0.5", lw=2, zorder=0)


def draw_fraction(axes: Any) -> None:
    """Eq. (4): the same curve for all spheres in these units."""
    load = np.geomspace(*LIMITS["xlim"], 300)
    fraction = contact_fraction(np.cbrt(load), 1.0)
    axes.plot(load, fraction, "k-", lw=1, label="Eq. (4)")
    axes.plot([], [], color="0.5", lw=2, label=r"first asperity, Eq. (6)")


def draw_adhesive(axes: Any, curve: Curve) -> None:
    """Band between the realisations, and the formulas through it."""
    crossover = curve.theory.crossover_load
    ratio = curve.areas / curve.hertz[:, None]
    colour, style = WORK_COLOURS[curve.work], STYLES[curve.radius]
    load = curve.loads / crossover
    band = np.nanmin(ratio, axis=1), np.nanmax(ratio, axis=1)
    axes.fill_between(load, *band, color=colour, alpha=0.2, lw=0)
    name = f"$w/E^*$ = {curve.work:g} $a_0$, $R$ = {curve.radius:g} $a_0$"
    axes.plot(load, np.nanmean(ratio, axis=1), style, color=colour, lw=1.8, label=name)
    loads = crossover * np.geomspace(load[0], LIMITS["xlim"][1], 200)
    hertz = Hertz(curve.radius, 1.0).contact_area(loads)
    first = np.nanmean(curve.areas[0])  # A_adh, of the least load
    sphere = theory(curve.radius, curve.slope, curve.kind, curve.work)
    table = flat_fraction(curve.work)
    flats: dict[str, Any] = {"-": table, ":": sphere.rough_pressure}
    for line, flat in flats.items():
        area = predicted_area(loads, curve.radius, 1.0, flat, asperity_area=first)
        axes.plot(loads / crossover, area / hertz, line, color="k", lw=0.8)


def main(arguments: list[str] | None = None) -> None:
    """Run the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[1])
    parser.add_argument("--scale", choices=BANDS, default="quick")
    parser.add_argument("--out", type=Path, default=HERE / "results")
    parser.add_argument("--workers", type=int, help="processes; one per processor")
    parser.add_argument("--draw", action="store_true", help="only what the table holds")
    parser.add_argument("--picture", type=Path, help="file of the picture")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    name = f"figure2-{options.scale}"
    table, database = options.out / f"{name}.csv", options.out / f"{name}.db"
    if not options.draw:
        calculate(options.scale, table, database, options.workers)
    with style():
        draw(table, options.picture or options.out / f"{name}.png")


if __name__ == "__main__":
    main()
