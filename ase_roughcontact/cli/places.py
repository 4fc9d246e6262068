"""The command ``places``: maps of contact area and adhesion over a scan."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import report
from ase_roughcontact.cli.common import checked_scene
from ase_roughcontact.ensemble.places import Place, as_map, run_places

_HEADER = "   x (nm)    y (nm)   load (nN)   area (nm²)   pull-off force (nN)"
# Attributes in the figure, with their units and labels.
_MAPS = {
    "contact_area": ("nm²", "contact area"),
    "pull_off_force": ("nN", "pull-off force"),
}


def places(options: argparse.Namespace) -> int:
    """Run a scene with the tip at a grid of places on its scan, in parallel.

    Draws maps of the contact area and of the pull-off force: DIR/places.csv and
    DIR/places.png. The margin of [topography] keeps the places away from the edges. An
    interrupted run is resumed by running it again.

    Exit status: 0 all places have a result, 1 some have none, 2 the scene or the folder
    is invalid.
    """
    scene = checked_scene(options)
    found, failed = list[Place](), 0
    if not options.quiet:
        print(_HEADER)
    for place in run_places(scene, options.grid, options.out, workers=options.workers):
        found.append(place)
        failed += not place.converged
        if not options.quiet:
            print(_row(place), flush=True)
    files = [options.out / "places.csv"]
    if any(place.converged for place in found):
        files.append(options.out / "places.png")
        _draw(found, files[-1])
    if not options.quiet:
        print("\n".join(map(str, files)))
    if failed:
        report.print_error(f"{failed} of {len(found)} places have no result")
    return 1 if failed else 0


def _row(place: Place) -> str:
    row = f"{place.x / UNITS['nm']:9.4g} {place.y / UNITS['nm']:9.4g}"
    if place.message:
        return f"{row}   {place.message}"
    return (
        f"{row}{place.normal_force / UNITS['nN']:12.4g}"
        f"{place.contact_area / UNITS['nm²']:13.4g}"
        f"{place.pull_off_force / UNITS['nN']:22.4g}"
    )


def _draw(found: list[Place], file: Path) -> None:
    """Draw maps of the area, and of the pull-off force if there is any."""
    from matplotlib.figure import Figure

    from ase_roughcontact._util.files import replaced

    shown = [name for name in _MAPS if np.nansum(as_map(found, name)[2]) > 0.0]
    figure = Figure(figsize=(4 * max(len(shown), 1), 3.4), layout="constrained")
    for axes, name in zip(np.ravel(figure.subplots(1, len(shown))), shown, strict=True):
        unit, label = _MAPS[name]
        x, y, values = as_map(found, name)
        image = axes.pcolormesh(
            x / UNITS["nm"], y / UNITS["nm"], values.T / UNITS[unit], shading="nearest"
        )
        figure.colorbar(image, label=f"{label} ({unit})")
        axes.set(xlabel="$x$ (nm)", ylabel="$y$ (nm)", aspect="equal")
    with replaced(file) as name:
        figure.savefig(name, format="png", dpi=150)
