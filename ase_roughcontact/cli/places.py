"""The command ``places``: maps of contact area and adhesion over a scan."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.printing import cells, note, number, show, write
from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact._util.tables import TableRows
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli.common import checked_scene, show_plan
from ase_roughcontact.cli.messages import print_error
from ase_roughcontact.ensemble.ensemble_plan import EnsemblePlan
from ase_roughcontact.ensemble.places import (
    PLACE_UNITS,
    Place,
    as_map,
    places_of,
    run_places,
    scanned_section,
)
from ase_roughcontact.paths.planned_steps import StartCosts
from ase_roughcontact.scene import Scene

# Headings of the columns of the table; the last column has marks.
_HEADINGS = (
    "x (nm)",
    "y (nm)",
    "load (nN)",
    "area (nm²)",
    "pull-off force (nN)",
    "depth (nm)",
    "",
)
# Width of a column.
_COLUMN_WIDTH = 10
# Width of the column of areas, which have errors.
_AREA_WIDTH = 16
# Widths of all columns.
_WIDTHS = [8, 8, _COLUMN_WIDTH, _AREA_WIDTH, *[_COLUMN_WIDTH] * 2, 1]
# Relative error of an area that is not printed, as it is below the last digit.
_MIN_RELATIVE_ERROR = 5e-5
# Number of points of the scan along its longer side in the figure.
_SCAN_POINTS = 256
# Labels and units of the attributes and results in the figure.
_MAPS = {
    "area": ("contact area", "nm²"),
    "pull_off_force": ("pull-off force", "nN"),
    "dissipated_energy": ("dissipated energy", "eV"),
}


def places(options: argparse.Namespace) -> int:
    """Run a scene with the tip at a grid of places on its scan, in parallel.

    Draws the scan and maps of the contact area, the pull-off force and, of loops, the
    dissipated energy, DIR/places.png, and writes them with all results of the path,
    DIR/places.csv. Places outside of the validity of the model have a star. The margin
    of [topography] keeps the places away from the edges; by default it is half the
    window that is expected at the deepest step. An interrupted run is resumed
    by running it again, which tries places without a result again. "report DIR" writes
    all on one page. With --plan nothing is calculated but the number of places, time,
    memory and files.

    Exit status: 0 all places have a result, 1 some have none, 2 the scene or the folder
    is invalid.
    """
    start, scene = StartCosts.now(), checked_scene(options)
    if options.plan:
        scenes = places_of(scene, options.grid)
        plan = EnsemblePlan.of(scenes, options.workers, start, places=True)
        return show_plan(plan, options)
    found: list[Place] = []
    failed = 0
    limits: set[str] = set()
    rows = TableRows(_HEADINGS, _WIDTHS)
    for place in run_places(scene, options.grid, options.out, workers=options.workers):
        found.append(place)
        failed += not place.converged
        if not options.quiet:
            show(rows.row(_row(place)))
            new = [k for k in place.validity.split("; ") if k and k not in limits]
            limits.update(new)
            if new:
                show(note(f"* LIMITS: {', '.join(new)}", _COLUMN_WIDTH, "yellow"))
            if place.message:
                style = "yellow" if place.converged else "red"
                show(note(place.message, _COLUMN_WIDTH, style))
    files = [options.out / "places.csv"]
    if any(place.converged for place in found):
        files.append(options.out / "places.png")
        draw_places(found, scene, files[-1])
    if not options.quiet:
        write("\n".join(map(str, files)))
    if failed:
        print_error(f"{failed} of {len(found)} places have no result")
    return 1 if failed else 0


def _row(place: Place) -> list[str]:
    numbers = {k: getattr(place, k) / UNITS[unit] for k, unit in PLACE_UNITS.items()}
    error = numbers.pop("area_error")
    values = dict(zip(numbers, cells(numbers.values()), strict=True))
    if error > _MIN_RELATIVE_ERROR * numbers["area"]:
        values["area"] += f" ± {number(error, 2)}"
    return [*values.values(), "*" * bool(place.validity)]


def draw_places(found: list[Place], scene: Scene, file: Path) -> None:
    """Draw the scan, and maps of area, pull-off force and dissipated energy if any."""
    from ase_roughcontact import plot
    from ase_roughcontact.plot.files import written
    from ase_roughcontact.plot.style import letter

    known = {*PLACE_UNITS, *(name for place in found for name in place.results)}
    shown = [k for k in _MAPS if k in known and np.nansum(as_map(found, k)[2]) > 0.0]
    count = len(shown) + 1
    with written(file, 2.4, width=2.6 * count) as figure:
        panels = first, *others = figure.subplots(1, count, sharex=True, sharey=True)
        image = first.pcolormesh(*_scan(scene), cmap="gray", shading="nearest")
        figure.colorbar(image, label="height of the scan (nm)")
        x, y = np.transpose([(each.x, each.y) for each in found]) / UNITS["nm"]
        first.plot(x, y, ".", color=plot.ORANGE, ms=3, label="places")
        first.set_ylabel("$y$ (nm)")
        for axes, name in zip(others, shown, strict=True):
            label, unit = _MAPS[name]
            x, y, values = as_map(found, name)
            cells = x / UNITS["nm"], y / UNITS["nm"], values.T / UNITS[unit]
            image = axes.pcolormesh(*cells, shading="nearest")
            figure.colorbar(image, label=f"{label} ({unit})")
        first.invert_yaxis()  # the first line of the scan is at the top
        for axes in panels:
            axes.set(xlabel="$x$ (nm)", aspect="equal")
        letter(panels)


def _scan(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions on the scan and its heights after detrending (nm)."""
    config: Any = scene.scans[scanned_section(scene)]
    surface = config.surface
    sides = (np.array(surface.shape) - 1) * surface.spacing
    step = float(sides.max()) / _SCAN_POINTS
    n, m = (int(side / step + LENGTH_ROUNDING) + 1 for side in sides)
    x, y = surface.center
    heights = -surface.heights((n, m), step, (-x, -y))
    if config.body == "indenter":  # which is turned over around y
        heights = heights[::-1]
    x, y = (step * np.arange(count) / UNITS["nm"] for count in (n, m))
    return x, y, heights.T / UNITS["nm"]
