"""Warnings about a scene before it is run: scan, grid, lengths without a unit."""

from __future__ import annotations

import math
from typing import Any

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.paths.limits import LEAST_EDGE_ZONE
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.theory.maugis import edge_zone

# Part of the necessary zone at the edge below which there is a warning: surfaces jump
# atom by atom, in many steps.
_RESOLVED = 0.25
# Contact radius in spacings that resolves a smooth sphere, and one that is too large.
_RESOLUTION, _WIDE = 60, 240


def warnings_of(scene: Any) -> list[str]:
    """Return warnings about scan, radius and grid of a `Scene`."""
    found = _range_warnings(scene.bodies, scene.grid_change.spacing(scene.spacing))
    radius, unit = scene.sphere.radius, scene.sphere.unit
    if scene.topography is not None:
        if isinstance(radius, int | float) and radius < math.inf and unit == "a0":
            found.append(
                f"radius = {radius:g} is in spacings a0 of the atoms, "
                f"{scene.radius / UNITS['nm']:.4g} nm: give it with a unit"
            )
        found += scene.topography.warnings(scene.radius, scene.whole_tip is not None)
    return found + _spacing_warnings(scene)


def _range_warnings(bodies: Bodies, spacing: float) -> list[str]:
    """Return a warning if a grid is far too coarse for the range of the attraction.

    The limits of the model report it, too, but only after the first step.
    """
    wall, creep = bodies.wall, bodies.solid.creep
    if not wall.attractive:
        return []
    modulus = bodies.contact_modulus * (creep.relaxed if creep else 1.0)
    work, length = wall.work_of_adhesion, wall.attraction_range
    zone = edge_zone(modulus, work, length) / spacing
    if zone >= _RESOLVED * LEAST_EDGE_ZONE:
        return []
    least, nm = length * math.sqrt(LEAST_EDGE_ZONE / zone), UNITS["nm"]
    return [
        f"the grid of {spacing / nm:.3g} nm does not resolve the range of the "
        f"attraction, {length / nm:.3g} nm: at the edge of a contact its zone is "
        f"{zone:.2g} spacings wide, and should be {LEAST_EDGE_ZONE:g} or more. "
        f'Take a finer grid, or attraction_range = "{1.01 * least / nm:.3g} nm": while '
        "Maugis' parameter is above 3, the pull-off force changes by about 1 %"
    ]


def _spacing_warnings(scene: Any) -> list[str]:
    """Return advice on a spacing of given moduli that is that of metals."""
    substrate = scene.substrate
    given = substrate.name or substrate.spacing or substrate.layer_thickness
    smooth = scene.rough is None and scene.whole_tip is None
    if given or scene.shape or not smooth:
        return []
    areas = scene.planned.expected_areas
    radius = math.sqrt(areas.max(initial=0.0) / math.pi)
    if radius < _WIDE * scene.grid_change.spacing(scene.spacing):
        return []
    advised = float(f"{radius / _RESOLUTION / UNITS['nm']:.1g}")  # one digit
    return [
        f"the contact has a radius of about {radius / scene.spacing:.0f} spacings "
        f"of the default, {scene.spacing / UNITS['nm']:.3g} nm: give [substrate] "
        f'spacing = "{advised:g} nm", with which a smooth sphere is resolved'
    ]
