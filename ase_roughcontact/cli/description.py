"""Description of a scene, and of the theory for it."""

from __future__ import annotations

import math

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import Reference
from ase_roughcontact.scene.scan_summary import scan_line
from ase_roughcontact.scene.solid import label_of
from ase_roughcontact.windows.regrid import lost_text


def description(reference: Reference) -> str:
    """Return a description of the scene and of the theory for it.

    Parameters
    ----------
    reference : Reference
        Theory for the scene.

    Returns
    -------
    str
    """
    scene, smooth = reference.scene, reference.smooth
    lines = [bodies(scene)]
    if reference.explanation:
        lines.append(f"Theory: {reference.explanation}")
    if reference.criteria:
        criteria = "; ".join(map(str, reference.criteria))
        lines.append(f"Stickiness of flat surfaces with this roughness: {criteria}")
    if scene.area_column == "continuum_area":
        lines.append(_grid(scene))
    if smooth.pull_off_force > 0.0:
        lines.append(f"Pull-off force: {pull_off_text(reference)}")
    return "\n".join(lines)


def bodies(scene: Scene) -> str:
    """Return a description of solid, indenter, wall and scan.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    str
    """
    radius = f"radius {scene.radius / UNITS['nm']:.4g} nm"
    indenter = f"sphere of {radius}"
    if scene.whole_tip is not None:
        indenter = f"scanned tip ({radius}, fitted to the scan)"
    line = (
        f"{label_of(scene.substrate, scene.solid)}, spacing {scene.spacing:.3f} Å, "
        f"{_hardness(scene)}; {indenter}, {scene.wall.label}"
    )
    if scene.scan is None or scene.topography is None:
        return line
    return f"{line}\n{scan_line(scene.topography)}"


def _hardness(scene: Scene) -> str:
    hardness = scene.hardness / UNITS["GPa"]
    if math.isnan(hardness):
        return "hardness unknown"
    return "elastic" if math.isinf(hardness) else f"hardness {hardness:.3g} GPa"


def _grid(scene: Scene) -> str:
    """Return the grid of the continuum, and what it can't resolve."""
    change, lost = scene.grid_change, scene.lost_slope
    line = f"Continuum on a grid of spacing {change.label}"
    return line + (f"; {lost_text(change, lost)}" if lost else "")


def pull_off_text(reference: Reference) -> str:
    """Return the pull-off force of theory, with its unit and the theory."""
    force = reference.smooth.pull_off_force / UNITS["nN"]
    return f"{force:.4g} nN ({reference.smooth.label})"
