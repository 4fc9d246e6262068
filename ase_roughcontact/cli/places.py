"""The command ``places``: maps of contact area and adhesion over a scan."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.printing import cells, note, show, write
from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact._util.tables import TableRows
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli.common import checked_scene
from ase_roughcontact.cli.messages import print_error
from ase_roughcontact.ensemble.places import PLACE_UNITS, Place, as_map, run_places
from ase_roughcontact.scene import Scene

# Headings of the columns of the table.
_HEADINGS = (
    "x (nm)",
    "y (nm)",
    "load (nN)",
    "area (nm²)",
    "pull-off force (nN)",
    "depth (nm)",
)
# Width of a column.
_COLUMN_WIDTH = 10
# Number of points of the scan along its longer side in the figure.
_SCAN_POINTS = 256
# Labels of the attributes in the figure.
_MAP_LABELS = {"area": "contact area", "pull_off_force": "pull-off force"}


def places(options: argparse.Namespace) -> int:
    """Run a scene with the tip at a grid of places on its scan, in parallel.

    Draws the scan and maps of the contact area and of the pull-off force,
    DIR/places.png, and writes them in nm and nN, DIR/places.csv. The margin of
    [topography] keeps the places away from the edges. An interrupted run is resumed by
    running it again.

    Exit status: 0 all places have a result, 1 some have none, 2 the scene or the folder
    is invalid.
    """
    scene = checked_scene(options)
    found: list[Place] = []
    failed = 0
    rows = TableRows(_HEADINGS, [_COLUMN_WIDTH] * len(_HEADINGS))
    for place in run_places(scene, options.grid, options.out, workers=options.workers):
        found.append(place)
        failed += not place.converged
        if not options.quiet:
            show(rows.row(_row(place)))
            if place.message:
                style = "yellow" if place.converged else "red"
                show(note(place.message, _COLUMN_WIDTH, style))
    files = [options.out / "places.csv"]
    if any(place.converged for place in found):
        files.append(options.out / "places.png")
        _draw(found, scene, files[-1])
    if not options.quiet:
        write("\n".join(map(str, files)))
    if failed:
        print_error(f"{failed} of {len(found)} places have no result")
    return 1 if failed else 0


def _row(place: Place) -> list[str]:
    units = PLACE_UNITS.items()
    return cells(getattr(place, name) / UNITS[unit] for name, unit in units)


def _draw(found: list[Place], scene: Scene, file: Path) -> None:
    """Draw the scan, and maps of the area and of the pull-off force if there is any."""
    from ase_roughcontact import plot
    from ase_roughcontact.plot.files import written
    from ase_roughcontact.plot.style import letter

    shown = [name for name in _MAP_LABELS if np.nansum(as_map(found, name)[2]) > 0.0]
    count = len(shown) + 1
    with written(file, 2.4, width=2.6 * count) as figure:
        panels = first, *others = figure.subplots(1, count, sharex=True, sharey=True)
        image = first.pcolormesh(*_scan(scene), cmap="gray", shading="nearest")
        figure.colorbar(image, label="height of the scan (nm)")
        x, y = np.transpose([(each.x, each.y) for each in found]) / UNITS["nm"]
        first.plot(x, y, ".", color=plot.ORANGE, ms=3, label="places")
        first.set_ylabel("$y$ (nm)")
        for axes, name in zip(others, shown, strict=True):
            unit = PLACE_UNITS[name]
            x, y, values = as_map(found, name)
            cells = x / UNITS["nm"], y / UNITS["nm"], values.T / UNITS[unit]
            image = axes.pcolormesh(*cells, shading="nearest")
            figure.colorbar(image, label=f"{_MAP_LABELS[name]} ({unit})")
        first.invert_yaxis()  # the first line of the scan is at the top
        for axes in panels:
            axes.set(xlabel="$x$ (nm)", aspect="equal")
        letter(panels)


def _scan(scene: Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return positions on the scan and its heights after detrending (nm)."""
    config: Any = scene.topography
    surface = config.surface
    sides = (np.array(surface.shape) - 1) * surface.spacing
    step = float(sides.max()) / _SCAN_POINTS
    n, m = (int(side / step + LENGTH_ROUNDING) + 1 for side in sides)
    x, y = surface.center
    heights = -surface.heights((n, m), step, (-x, -y))
    if config.role == "indenter":  # which is turned over around y
        heights = heights[::-1]
    x, y = (step * np.arange(count) / UNITS["nm"] for count in (n, m))
    return x, y, heights.T / UNITS["nm"]
