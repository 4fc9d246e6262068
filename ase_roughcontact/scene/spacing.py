"""Lengths of a scene in units of the spacing a0, and a spacing that fits a contact."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from ase_roughcontact._util.units import LENGTHS, QUANTITY
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.results.limits import LEAST_EDGE_ZONE, narrowest_zone
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.file import SceneFile
from ase_roughcontact.scene.random_fields import LENGTH_KEYS, RandomFieldConfig
from ase_roughcontact.scene.solid import has_own_spacing
from ase_roughcontact.windows.expected import contact_radius_on

# Contact radius in spacings that resolves a smooth sphere.
_SPACINGS_PER_RADIUS = 60


def lengths_in_spacings(scene: SceneFile, spacing: float) -> str:
    """Return lengths without a unit in nm, if other lengths have a unit.

    Parameters
    ----------
    scene : SceneFile
    spacing : float
        The spacing a0 (Å).

    Returns
    -------
    str
        Keys and values in nm; empty without such lengths, or if all lengths are in
        units of a0.
    """
    a0, lengths = spacing / LENGTHS["nm"], _multiples(scene)
    values = ", ".join(
        f"{name} = {value:g}, {value * a0:.4g} nm"
        for name, value in lengths.items()
        if not isinstance(value, str)
    )
    if not values or not _has_lengths_with_unit(scene):
        return ""
    return f"lengths without a unit are in spacings a0 of {a0:.4g} nm: {values}"


def _multiples(scene: SceneFile) -> dict[str, Any]:
    """Return the lengths in units of a0, by section and key: numbers and texts."""
    found = {}
    for name, value, unit in _lengths(scene):
        if isinstance(value, str):
            unit = _unit_of(value)
        if value is not None and unit == "a0":
            found[name] = value
    return found


def _has_lengths_with_unit(scene: SceneFile) -> bool:
    """Return whether a length of a scene is given with another unit than a0."""
    if scene.scans:
        return True
    units = {unit for _, value, unit in _lengths(scene) if value is not None}
    units.update(map(_unit_of, _texts(scene.entries())))
    return not units.isdisjoint(LENGTHS)


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
    multiples = _multiples(scene) or default
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


def _lengths(scene: SceneFile) -> Iterator[tuple[str, Any, str]]:
    """Yield given lengths that may be multiples of a0, and the unit of numbers."""
    sphere = scene.sphere
    if sphere.radius not in (None, math.inf):
        yield "[sphere] radius", sphere.radius, sphere.unit
    for section in scene.sections.values():
        if isinstance(section, RandomFieldConfig):
            values = section.contents()
            for key in (*LENGTH_KEYS, "rms_height"):
                yield f"[{section.title}] {key}", values.get(key), section.unit
    if scene.indenter is not None:
        for key, parameter in scene.indenter.kind_parameters.items():
            if parameter.unit == "a0":
                value = scene.indenter.parameters.get(key)
                yield f"[indenter] {key}", value, "a0"
    for key, value in scene.interaction.parameters.items():
        if isinstance(value, str):
            yield f"[interaction] {key}", value, ""
    for value in _texts(scene.path.entries()):
        yield "[path]", value, ""


def _texts(values: Any) -> Iterator[str]:
    """Yield the texts in nested dictionaries and lists."""
    if isinstance(values, str):
        yield values
    elif isinstance(values, dict):
        yield from _texts(list(values.values()))
    elif isinstance(values, (list, tuple)):
        for each in values:
            yield from _texts(each)


def _unit_of(text: str) -> str:
    """Return the unit of a quantity; empty for other texts."""
    found = QUANTITY.fullmatch(text)
    return found[2] if found else ""
