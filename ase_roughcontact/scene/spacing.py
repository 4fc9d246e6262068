"""Spacing of the grid that fits the contact of a scene."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from itertools import chain
from typing import Any

import numpy as np

from ase_roughcontact._util.units import QUANTITY
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.results.limits import LEAST_EDGE_ZONE, narrowest_zone
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.file import SceneFile
from ase_roughcontact.scene.random_fields import LENGTH_KEYS, RandomFieldConfig
from ase_roughcontact.scene.solid import has_own_spacing
from ase_roughcontact.windows.expected import contact_radius_on

# Contact radius in spacings that resolves a smooth sphere.
_SPACINGS_PER_RADIUS = 60


def fitting_spacing(scene: SceneFile, bodies: Bodies) -> float | None:
    """Return the spacing that resolves the largest contact of a smooth indenter.

    The contact has a radius of 60 spacings. If it is the smaller spacing, the zone of
    attraction at the edge has a width of 7 spacings instead, unless the range of the
    attraction is itself a multiple of the spacing.

    Parameters
    ----------
    scene : SceneFile
    bodies : Bodies
        Bodies with the nominal spacing of the solid.

    Returns
    -------
    float or None
        Spacing (Å), one significant digit. None if the solid has a spacing of its own,
        a spacing is given, other lengths are multiples of it, the indenter is not
        smooth, the work of adhesion varies, or the nominal spacing is larger.
    """
    fixed = has_own_spacing(scene.substrate) or scene.substrate.window_shape
    default = scene.indenter is None and scene.sphere.radius is None
    multiples = _has_multiples(scene) or default
    smooth = bodies.rough is None and bodies.radius != math.inf
    if fixed or multiples or not smooth or bodies.problem.heterogeneity is not None:
        return None
    found = 0.0
    with suppress(ValueError):  # the path is checked later
        found = _largest_radius(scene, bodies) / _SPACINGS_PER_RADIUS
    zone = _edge_zone(scene, bodies) / LEAST_EDGE_ZONE
    if zone > bodies.spacing:
        found = min(found, zone)
    rounded = float(f"{found:.1g}")
    return rounded if rounded > bodies.spacing else None


def _largest_radius(scene: SceneFile, bodies: Bodies) -> float:
    """Return the radius of the largest contact of a path (Å)."""
    path, wall, creep = scene.path.planned(bodies), bodies.wall, bodies.solid.creep
    targets = path.targets(bodies)
    part = creep.relaxed if creep and creep.relaxed else 1.0
    if path.controlled == LOAD:
        load = float(max(targets.max(), 0.0))

        def radius(modulus: float) -> float:
            smooth = bodies.smooth_theory(part * modulus, wall.work_of_adhesion)
            return float(smooth.contact_radius(load))

        return contact_radius_on(bodies.solid, bodies.spacing, radius)
    deepest = path.controlled.depths(targets).max()
    return float(np.sqrt(bodies.area_at(deepest) / np.pi))


def _edge_zone(scene: SceneFile, bodies: Bodies) -> float:
    """Return the zone of attraction at the edge of a contact (Å); zero without one.

    Zero also if the range of the attraction follows from the spacing.
    """
    both_named = scene.substrate.material and scene.tip_material
    given = both_named or "attraction_range" in scene.interaction.parameters
    if not (bodies.wall.attractive and given):
        return 0.0
    return narrowest_zone(bodies.problem)


def _has_multiples(scene: SceneFile) -> bool:
    """Return whether a length is given as a multiple of the spacing."""
    return any(_unit_of(value, unit) == "a0" for value, unit in _lengths(scene))


def _lengths(scene: SceneFile) -> Iterator[tuple[Any, str]]:
    """Yield given lengths that may be multiples of a0, and the unit of numbers."""
    sphere = scene.sphere
    if sphere.radius != math.inf:
        yield sphere.radius, sphere.unit
    for section in scene.sections.values():
        if isinstance(section, RandomFieldConfig):
            values = section.contents()
            for key in (*LENGTH_KEYS, "rms_height"):
                yield values.get(key), section.unit
    sections = (scene.indenter, scene.interaction)
    parameters = [each.parameters.values() for each in sections if each is not None]
    for value in (*chain(*parameters), *_targets(scene)):
        if isinstance(value, str):
            yield value, ""


def _targets(scene: SceneFile) -> Iterator[Any]:
    """Yield the values in the section [path]."""
    for value in scene.path.entries().values():
        if isinstance(value, dict):
            yield from value.values()
        else:
            yield from value if isinstance(value, (list, tuple)) else [value]


def _unit_of(value: Any, unit: str) -> str:
    """Return the unit of a quantity, a number or a text; empty for none."""
    if not isinstance(value, str):
        return "" if value is None else unit
    found = QUANTITY.fullmatch(value)
    return found[2] if found else ""
