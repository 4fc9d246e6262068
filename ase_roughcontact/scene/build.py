"""From the sections of a scene file to solid, indenter and wall in ASE's units."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import Shape, positive
from ase_roughcontact.contact import Problem
from ase_roughcontact.elasticity import (
    ElasticSolid,
    Isotropic,
    Viscoelastic,
    named_materials,
)
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.interactions import WALLS, Interaction, make_wall
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.config import DEFAULT_RADIUS
from ase_roughcontact.scene.file import SceneFile
from ase_roughcontact.scene.random_fields import local_adhesion
from ase_roughcontact.scene.scan import tip_radius
from ase_roughcontact.scene.section import Problems, lengths
from ase_roughcontact.scene.solid import (
    creep_of,
    in_gpa,
    named,
    poisson_of,
    solid_of,
    spacing_of,
)
from ase_roughcontact.scene.spacing import fitting_spacing
from ase_roughcontact.theory.indenters import Indenter
from ase_roughcontact.topography import (
    HeightMap,
    Heterogeneity,
    RoughSphere,
    SelfAffine,
    ShapedIndenter,
    Topography,
)
from ase_roughcontact.topography.square_grid import SquareGrid

# Hardness (GPa) that no solid exceeds: a larger value is in another unit.
_MAX_HARDNESS = 1e3
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
        if scene.friction and creep is not None:
            raise ValueError(
                "there is no friction on a viscoelastic solid: leave out [friction], "
                "or relaxation_moduli and relaxation_times"
            )
    problems.check()

    with problems.of("substrate"):
        spacing = solid.spacing if spacing is None else spacing
        solid.check(spacing)
        hardness = _hardness(scene, solid)
        if isinstance(solid, Isotropic):  # only friction depends on Poisson's ratio
            poisson = poisson_of(scene.substrate) if scene.friction else None
            solid = replace(solid, poisson=poisson)
    with problems.of("sphere"):
        substrate_modulus = solid.contact_modulus
        if scene.tip_material:
            solid = _with_tip(solid, scene.tip_material)
        hardness_bound = _hardness_bound(scene, solid, substrate_modulus)
        if creep is not None:  # the tip is elastic
            ratio = solid.contact_modulus / substrate_modulus
            solid = Viscoelastic(solid, creep.scaled(ratio))
    rough: Any = None
    if scene.topography is not None:
        with problems.of("topography"):
            rough = scene.topography.surface
    if scene.roughness is not None:
        with problems.of("roughness"):
            if scene.topography is not None:
                raise ValueError("give [roughness] or [topography], not both")
            rough = scene.roughness.surface(spacing)
    problems.check()

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
            pixel, cell, rough = _flat_cell(scene, rough, spacing)
            solid.check(pixel)
        surface: Topography
        if shape is not None:
            surface = ShapedIndenter(shape)
        else:
            surface = RoughSphere(
                math.inf if without_sphere else radius, rough, profile
            )
    with problems.of("interaction"):
        wall = _wall(scene, solid, spacing, hardness)
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
    is_tip = without_sphere and cell is None
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
        symbol=substrate.symbol,
        hardness=wall.hardness if wall_has_hardness else hardness,
        hardness_bound=math.nan if wall_has_hardness else hardness_bound,
        radius=radius,
        rough=None if is_tip else rough,
        shape=shape,
        cell=cell,
        whole_tip=rough if is_tip and isinstance(rough, HeightMap) else None,
        friction=scene.friction,
        scanned=scene.topography.role if scene.topography else "",
    )


def _shape(scene: SceneFile, spacing: float) -> Indenter:
    """Return the indenter of another shape than a sphere, with lengths in Å."""
    if scene.sphere.given:
        raise ValueError(
            f"[indenter] is in place of [sphere], got {', '.join(scene.sphere.given)} "
            "in [sphere]: leave out one of the sections"
        )
    for title in ("roughness", "topography"):
        if getattr(scene, title) is not None:
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
    sphere, given, scan = scene.sphere, scene.sphere.radius, None
    if scene.topography is not None and scene.topography.role == "indenter":
        scan = scene.topography.surface
    if scene.topography is not None and scene.topography.extrude:
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


def _flat_cell(
    scene: SceneFile, rough: SelfAffine | HeightMap, spacing: float
) -> tuple[float, Shape, SelfAffine | HeightMap]:
    """Return grid spacing (Å), shape and roughness of the periodic cell of a flat.

    The grid of a scan consists of its pixels, or of squares about as large as the
    smaller side of a pixel. The cell is the scan, made periodic, with its middle on the
    axis. A random surface is sampled by atoms.
    """
    if isinstance(rough, HeightMap):
        grid = SquareGrid.of(rough.shape, rough.spacing)
        (n, m), spacing = grid.shape, grid.spacing
        rough = rough.made_periodic(grid.strain)
    else:
        n = m = round(rough.side / spacing)
    shape = replace(scene.substrate, periodic=False).window_shape or (n, m)
    if shape[0] > n or shape[1] > m:
        raise ValueError(
            f"shape must be at most {n} x {m}, the points of the flat, got "
            f"{shape[0]} x {shape[1]}: leave it out"
        )
    return spacing, shape, rough


def _hardness(scene: SceneFile, solid: ElasticSolid) -> float:
    """Return the smaller known hardness of both bodies (eV/Å^3); NaN if unknown."""
    hardness = scene.substrate.hardness
    if hardness is None:
        known = [each for each in _hardnesses(scene, solid) if not math.isnan(each)]
        return UNITS["GPa"] * min(known, default=math.nan)
    if hardness != math.inf:
        in_gpa("hardness", hardness, _MAX_HARDNESS)
    return UNITS["GPa"] * hardness


def _hardnesses(scene: SceneFile, solid: ElasticSolid) -> list[float]:
    """Return the hardness of the substrate, and of a tip of a named material (GPa)."""
    hardnesses = [math.nan]  # not known for a layer
    if not solid.layered:
        hardnesses = [named_materials.hardness_of(scene.substrate.name)]
    if scene.tip_material:
        hardnesses.append(named_materials.hardness_of(scene.tip_material))
    return hardnesses


def _hardness_bound(scene: SceneFile, solid: ElasticSolid, modulus: float) -> float:
    """Return an upper bound of the hardness of named bodies of unknown hardness.

    Parameters
    ----------
    scene : SceneFile
    solid : ElasticSolid
        Solid of the substrate, or of both bodies.
    modulus : float
        Contact modulus of the substrate alone (eV/Å^3).

    Returns
    -------
    float
        The smaller bound of both bodies (eV/Å^3); NaN if a hardness is given, or known
        for all named bodies.
    """
    if scene.substrate.hardness is not None:
        return math.nan
    moduli = {}
    if scene.substrate.name and not solid.layered:
        moduli[scene.substrate.name] = modulus
    if tip := scene.tip_material:
        tip_modulus = named_materials.material(tip).contact_modulus * UNITS["GPa"]
        moduli[tip] = min(tip_modulus, moduli.get(tip, math.inf))
    unknown = [
        modulus
        for name, modulus in moduli.items()
        if math.isnan(named_materials.hardness_of(name))
    ]
    relative_hardness = named_materials.LARGEST_RELATIVE_HARDNESS
    return relative_hardness * min(unknown, default=math.nan)


def _with_tip(solid: ElasticSolid, name: str) -> Isotropic:
    """Return the solid that deforms like a solid and an elastic tip together."""
    if not isinstance(solid, Isotropic):
        raise ValueError(
            "the material of the sphere needs an isotropic substrate, got "
            f"{solid!r}: leave it out"
        )
    tip = named_materials.material(name)
    modulus, poisson = tip.contact_modulus * UNITS["GPa"], tip.poisson
    combined = named_materials.combined_modulus(solid.contact_modulus, modulus)
    if solid.poisson is None:
        return Isotropic(combined)
    if poisson is None:
        raise ValueError(
            f"Poisson's ratio of the material {name!r} is not known, which friction "
            "needs: leave it out"
        )
    base, sphere = (solid.contact_modulus, solid.poisson), (modulus, poisson)
    return Isotropic(
        combined,
        named_materials.combined_poisson(base, sphere),
        named_materials.dundurs_parameter(base, sphere),
    )


def _wall(
    scene: SceneFile, solid: ElasticSolid, spacing: float, hardness: float
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
        is_known = not any(math.isnan(each) for each in _hardnesses(scene, solid))
    if "hardness" in missing and is_known:
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
