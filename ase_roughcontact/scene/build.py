"""From the sections of a scene file to solid, indenter and wall in ASE's units."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import positive
from ase_roughcontact.contact import Problem
from ase_roughcontact.elasticity import (
    Crystal,
    ElasticSolid,
    Isotropic,
    Viscoelastic,
    named_materials,
)
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.interactions import WALLS, Interaction, make_wall
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.config import DEFAULT_RADIUS
from ase_roughcontact.scene.file import SceneFile
from ase_roughcontact.scene.random_fields import local_adhesion
from ase_roughcontact.scene.rough_bodies import combined, flat_cell, rough_bodies
from ase_roughcontact.scene.scan import TopographyConfig, tip_radius
from ase_roughcontact.scene.section import Problems, lengths
from ase_roughcontact.scene.solid import (
    MAX_HARDNESS,
    creep_of,
    in_gpa,
    named,
    poisson_of,
    solid_of,
    spacing_of,
    symbol_of,
)
from ase_roughcontact.scene.spacing import fitting_spacing
from ase_roughcontact.scene.tip import ElasticTip, elastic_tip
from ase_roughcontact.theory.indenters import Indenter
from ase_roughcontact.topography import (
    Heterogeneity,
    RoughSphere,
    ShapedIndenter,
    Topography,
)

# Least default period of a local work of adhesion, in units of the radius within which
# a touching sphere is in the range of the attraction.
_PERIOD_PER_RANGE = 4.0


def build(scene: SceneFile) -> Bodies:
    """Return solid, indenter and wall that the sections of a scene describe.

    A solid without a spacing of its own has one that fits the contact, see
    `fitting_spacing`.

    Parameters
    ----------
    scene : SceneFile

    Returns
    -------
    Bodies

    Raises
    ------
    ValueError
        If values are out of range or inconsistent with others, with section and key of
        all of them, as far as they do not depend on each other.
    """
    bodies = _bodies(scene)
    spacing = fitting_spacing(scene, bodies)
    if spacing is None:
        return bodies
    return replace(_bodies(scene, spacing), fitted=True)


def _bodies(scene: SceneFile, spacing: float | None = None) -> Bodies:
    """Return the bodies with a spacing (Å); by default the spacing of the solid."""
    problems = Problems()
    with problems.of("substrate"):
        substrate = named(scene.substrate)
    problems.check()
    with problems.of("substrate"):
        spacing = spacing_of(substrate) if spacing is None else spacing
    with problems.of("substrate"):
        solid: Any = solid_of(substrate, spacing)
        creep = creep_of(scene.substrate)
    problems.check()

    symbol = solid.symbol if isinstance(solid, Crystal) else symbol_of(substrate)
    poisson: float | None = None
    with problems.of("substrate"):
        spacing = solid.spacing if spacing is None else spacing
        solid.check(spacing)
        yield_strength = _yield_strength(scene)
        if isinstance(solid, Isotropic):
            poisson = _poisson(scene)
            solid = replace(solid, poisson=poisson if scene.friction else None)
    elastic: ElasticTip | None = None
    with problems.of("sphere" if scene.tip is None else "tip"):
        substrate_modulus = solid.contact_modulus
        elastic = elastic_tip(scene)
        hardness_bound = _hardness_bound(scene, solid, elastic, spacing, creep)
        if elastic is not None:
            solid = _with_tip(solid, elastic)
        if isinstance(solid, Isotropic) and not scene.friction:
            solid = replace(solid, poisson=poisson)  # stresses are of the substrate
        if creep is not None:  # the tip is elastic
            ratio = solid.contact_modulus / substrate_modulus
            solid = Viscoelastic(solid, creep.scaled(ratio))
    with problems.of("substrate"):
        hardness = _hardness(scene, solid, elastic)
    with problems.of():
        parts = rough_bodies(scene, spacing)
    problems.check()
    rough = combined(parts)

    without_sphere = scene.sphere.radius == math.inf
    cell = None
    shape: Indenter | None = None
    if scene.indenter is not None:
        with problems.of("indenter"):
            shape = _shape(scene, spacing)
        problems.check()
    with problems.of("sphere"):
        radius = _radius(scene, spacing)
        if radius == math.inf and rough is None:
            raise ValueError(
                "radius = inf needs [topography], the scan of a whole tip or a rough "
                "flat, or [roughness]: give that, or a finite radius"
            )
        profile: Any = scene.sphere.profile
        pixel = spacing
        if radius == math.inf and rough is not None:
            given = replace(scene.substrate, periodic=False).window_shape
            pixel, cell, parts = flat_cell(parts, spacing, given)
            rough = combined(parts)
            solid.check(pixel)
        surface: Topography
        if shape is not None:
            surface = ShapedIndenter(shape)
        else:
            surface = RoughSphere(
                math.inf if without_sphere else radius, rough, profile
            )
    with problems.of("interaction"):
        wall = _wall(scene, solid, spacing, hardness, elastic)
    problems.check()

    with problems.of("heterogeneity"):
        try:
            adhesion = _local_adhesion(scene, wall, radius, spacing)
        except MemoryError as error:
            raise MemoryError(f"[heterogeneity] {error}") from error
    fft: dict[str, Any] = {}
    if scene.solver.engine is not None:
        fft["engine"] = scene.solver.engine
        with problems.of("solver"):
            RealFFT2((1, 1), **fft)
    problems.check()
    wall_has_hardness = "hardness" in scene.interaction.parameters
    tip = None
    if without_sphere and cell is None:
        tip = next(each.surface for each in parts if _is_tip_scan(each.section))
        rough = combined([each for each in parts if each.surface is not tip])
    return Bodies(
        problem=Problem(
            indenter=surface,
            solid=solid,
            wall=wall,
            spacing=pixel,
            periodic=scene.substrate.periodic or cell is not None,
            heterogeneity=adhesion,
            fft=fft,
        ),
        symbol=symbol,
        hardness=wall.hardness if wall_has_hardness else hardness,
        hardness_bound=math.nan if wall_has_hardness else hardness_bound,
        yield_strength=yield_strength,
        radius=radius,
        rough=rough,
        shape=shape,
        cell=cell,
        whole_tip=tip,
        tip=elastic,
        parts=tuple(parts),
        friction=scene.friction,
        scanned=next((each.body for each in scene.scans.values()), ""),
    )


def _shape(scene: SceneFile, spacing: float) -> Indenter:
    """Return the indenter of another shape than a sphere, with lengths in Å."""
    if scene.sphere.given:
        raise ValueError(
            f"[indenter] is in place of [sphere], got {', '.join(scene.sphere.given)} "
            "in [sphere]: leave out one of the sections"
        )
    for title in (*scene.roughnesses, *scene.scans):
        raise ValueError(
            f"an indenter of another shape is smooth, got [{title}], which needs "
            "[sphere]: leave it out, or give a scan of the whole indenter"
        )
    if scene.substrate.periodic:
        raise ValueError(
            "an indenter of another shape needs a free half space: leave out "
            "periodic in [substrate]"
        )
    assert scene.indenter is not None
    return scene.indenter.shape(spacing)


def _radius(scene: SceneFile, spacing: float) -> float:
    """Return the radius of the sphere, or the radius of curvature of a whole tip (Å).

    The radius of a rough flat is infinity, of an indenter of another shape NaN.
    """
    if scene.indenter is not None:
        return math.nan
    sphere, given = scene.sphere, scene.sphere.radius
    scans = scene.scans.values()
    scan = next((each.surface for each in scans if _is_tip_scan(each)), None)
    if any(each.extrude for each in scans):
        if given != math.inf:
            raise ValueError(
                "an extruded profile is pressed as a flat: give radius = inf, got "
                f"{given!r}"
            )
        return math.inf
    if given == math.inf:
        if scan is None or scan.periodic:
            return math.inf
        if not scan.tip.is_tip and scan.turned.tip.is_tip:
            raise ValueError(
                "the scan of a tip is not convex around its highest point: is the "
                "height reversed? Else give the radius of the sphere in place of inf"
            )
        return scan.tip.radius if scan.tip.is_tip else math.inf
    if given is None:
        if scan is None:
            return DEFAULT_RADIUS * spacing
        reason = "the scan does not say whether it is a whole tip"
        if scan.tip.is_tip:
            reason = (
                f"the scan itself has a radius of {tip_radius(scan)} at its highest "
                "point"
            )
        raise ValueError(
            f"{reason}: give radius = inf for a whole tip, or the radius of the sphere "
            "for a scan of its roughness"
        )
    radius = sphere.plain(["radius"], lengths(spacing), "a0", sphere.unit).radius
    if not (isinstance(given, str) and 0.0 < radius < math.inf):
        positive(radius=given)
    if radius < 1.0:
        raise ValueError(
            f"radius must be at least the spacing a0 = {spacing:.4g} Å, got {given!r}, "
            f"{radius:.3g} a0"
        )
    return radius * spacing


def _is_tip_scan(section: Any) -> bool:
    """Return whether a section describes a scan of the indenter."""
    return isinstance(section, TopographyConfig) and section.body == "indenter"


def _hardness(scene: SceneFile, solid: ElasticSolid, tip: ElasticTip | None) -> float:
    """Return the smaller known hardness of both bodies (eV/Å^3); NaN if unknown.

    A given hardness of the substrate is the hardness of both, unless the hardness of
    the tip is given, too.
    """
    given = scene.substrate.hardness
    if given is None:
        hardnesses = _hardnesses(scene, solid, tip)
        known = [each for each in hardnesses if not math.isnan(each)]
        hardness = min(known, default=math.nan)
        if hardness == math.inf and len(known) < len(hardnesses):
            hardness = math.nan  # of the other body
        return UNITS["GPa"] * hardness
    if given != math.inf:
        in_gpa("hardness", given, MAX_HARDNESS)
    if tip is not None and tip.hardness_is_given:
        given = min(given, tip.hardness)
    return UNITS["GPa"] * given


def _poisson(scene: SceneFile) -> float | None:
    """Return Poisson's ratio of an isotropic substrate; None if it is not known.

    Only friction and stresses below the surface depend on it.
    """
    poisson = poisson_of(scene.substrate)
    if poisson is None and (scene.friction or scene.asks_for_stress):
        raise ValueError(
            "friction and stresses below the surface need Poisson's ratio, which is "
            "unknown: give poisson"
        )
    return poisson


def _yield_strength(scene: SceneFile) -> float:
    """Return the yield strength (eV/Å^3); NaN if it is not given."""
    strength = scene.substrate.yield_strength
    if strength is None:
        return math.nan
    in_gpa("yield_strength", strength, MAX_HARDNESS)
    return UNITS["GPa"] * strength


def _hardnesses(
    scene: SceneFile, solid: ElasticSolid, tip: ElasticTip | None
) -> list[float]:
    """Return the hardness of the substrate, and of an elastic tip (GPa)."""
    hardnesses = [math.nan]  # not known for a layer
    if not solid.layered:
        crystal = solid.symbol if isinstance(solid, Crystal) else ""
        name = scene.substrate.material or crystal
        hardnesses = [named_materials.hardness_of(name)]
    if tip is not None:
        hardnesses.append(tip.hardness)
    return hardnesses


def _hardness_bound(
    scene: SceneFile,
    solid: ElasticSolid,
    tip: ElasticTip | None,
    spacing: float,
    creep: Creep | None,
) -> float:
    """Return an upper bound of the hardness of bodies of unknown hardness.

    Parameters
    ----------
    scene : SceneFile
    solid : ElasticSolid
        Solid of the substrate alone.
    tip : ElasticTip or None
    spacing : float
        Distance of the atoms (Å).
    creep : Creep or None
        Creep of the substrate.

    Returns
    -------
    float
        The smaller bound of both bodies (eV/Å^3); NaN if a hardness is given, or known
        for both bodies, and for rubbers.
    """
    if scene.substrate.hardness is not None:
        return math.nan
    modulus = solid.modulus_at_surface(spacing) / UNITS["GPa"]
    bounds = [named_materials.hardness_bound(modulus, creep)]
    if tip is not None:
        modulus = tip.contact_modulus / UNITS["GPa"]
        bounds.append(named_materials.hardness_bound(modulus))
    hardnesses = _hardnesses(scene, solid, tip)
    unknown = [
        bound
        for bound, hardness in zip(bounds, hardnesses, strict=True)
        if math.isnan(hardness) and not math.isnan(bound)
    ]
    return UNITS["GPa"] * min(unknown, default=math.nan)


def _with_tip(solid: ElasticSolid, tip: ElasticTip) -> Isotropic:
    """Return the solid that deforms like a solid and an elastic tip together."""
    if not isinstance(solid, Isotropic):
        raise ValueError(
            f"an elastic tip needs an isotropic substrate, got {solid!r}: leave out "
            "the material and the moduli of the tip"
        )
    modulus, poisson = tip.contact_modulus, tip.poisson
    combined = named_materials.combined_modulus(solid.contact_modulus, modulus)
    if solid.poisson is None:
        return Isotropic(combined)
    if poisson is None:
        raise ValueError(
            f"Poisson's ratio of {tip.source} is not known, which friction needs: give "
            "[tip] poisson"
        )
    base, sphere = (solid.contact_modulus, solid.poisson), (modulus, poisson)
    return Isotropic(
        combined,
        named_materials.combined_poisson(base, sphere),
        named_materials.dundurs_parameter(base, sphere),
    )


def _wall(
    scene: SceneFile,
    solid: ElasticSolid,
    spacing: float,
    hardness: float,
    tip: ElasticTip | None,
) -> Interaction:
    """Return the wall; parameters not given follow from the materials."""
    kind, parameters = scene.interaction.kind, dict(scene.interaction.parameters)
    missing = WALLS.find(kind).parameters.keys() - parameters.keys()
    materials = scene.substrate.material, scene.tip_material
    if "work_of_adhesion" in missing and all(materials):
        parameters["work_of_adhesion"] = named_materials.work_of_adhesion(*materials)
    if "attraction_range" in missing and all(materials):
        parameters["attraction_range"] = f"{named_materials.ATTRACTION_RANGE} nm"
    is_known = scene.substrate.hardness is not None
    if not is_known:
        is_known = not any(map(math.isnan, _hardnesses(scene, solid, tip)))
    if "hardness" in missing and is_known and hardness < math.inf:
        parameters["hardness"] = hardness / UNITS["GPa"]
    return make_wall(kind, solid.contact_modulus, spacing, parameters)


def _local_adhesion(
    scene: SceneFile, wall: Interaction, radius: float, spacing: float
) -> Heterogeneity | None:
    """Return the local over the mean work of adhesion; None if it is uniform."""
    if scene.heterogeneity is None:
        return None
    if not wall.attractive:
        kind = scene.interaction.kind
        raise ValueError(
            f"needs a wall with a work of adhesion, got kind = {kind!r}: give "
            '[interaction] kind = "adhesive", or omit [heterogeneity]'
        )
    range_radius = 0.0
    if radius < math.inf:
        range_radius = math.sqrt(2.0 * radius * wall.reach)
    return local_adhesion(
        scene.heterogeneity, spacing, _PERIOD_PER_RANGE * range_radius
    )
