"""From the sections of a scene file to solid, indenter and wall in ASE's units."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import lookup
from ase_roughcontact.contact import Problem
from ase_roughcontact.elasticity import Creep, ElasticSolid, Viscoelastic
from ase_roughcontact.elasticity.greens import Isotropic
from ase_roughcontact.elasticity.named_materials import (
    ATTRACTION_RANGE,
    combined_modulus,
    combined_poisson,
    dundurs_parameter,
    material,
    work_of_adhesion,
)
from ase_roughcontact.interactions import WALLS, Interaction, make_wall
from ase_roughcontact.paths.validity import hardness_of
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.config import SubstrateConfig
from ase_roughcontact.scene.file import SceneFile
from ase_roughcontact.scene.indenter import flat_cell, radius_of
from ase_roughcontact.scene.random_fields import local_adhesion, random_field
from ase_roughcontact.scene.section import Problems
from ase_roughcontact.scene.solid import (
    creep_of,
    named,
    poisson_of,
    solid_of,
    spacing_of,
)
from ase_roughcontact.topography import (
    HeightMap,
    Heterogeneity,
    RoughSphere,
    SelfAffine,
)

# Hardness (GPa) above that of any solid: a larger value is in another unit.
_LARGEST_HARDNESS = 1e3
# Least default period of a local work of adhesion, in units of the radius in which a
# sphere that touches is in the range of the wall: room for three times that range.
_ROOM = 4.0


def build(scene: SceneFile) -> Bodies:
    """Return solid, indenter and wall that the sections of a scene describe.

    Parameters
    ----------
    scene : SceneFile

    Returns
    -------
    Bodies

    Raises
    ------
    ValueError
        With section and key of all values that are out of range or inconsistent with
        others, as far as they do not depend on each other.
    """
    problems = Problems()
    with problems.of("substrate"):
        substrate = named(scene.substrate)
    problems.check()
    with problems.of("substrate"):
        spacing = spacing_of(substrate)
    with problems.of("substrate"):
        solid: Any = solid_of(substrate)
        creep = creep_of(scene.substrate)
        if scene.friction and creep is not None:
            raise ValueError(
                "friction needs lateral displacements, which a viscoelastic solid has "
                "not: leave out [friction], or relaxation_moduli and relaxation_times"
            )
    problems.check()

    with problems.of("substrate"):
        spacing = solid.spacing if spacing is None else spacing
        solid.check(spacing)
        hardness = _hardness(scene.substrate, substrate.symbol, spacing)
        if isinstance(solid, Isotropic):  # only friction depends on Poisson's ratio
            poisson = poisson_of(scene.substrate) if scene.friction else None
            solid = replace(solid, poisson=poisson)
    with problems.of("sphere"):
        solid = _with_tip(solid, scene.sphere.material, creep)
    rough: SelfAffine | HeightMap | None = None
    if scene.topography is not None:
        with problems.of("topography"):
            rough = scene.topography.surface
    if scene.roughness is not None:
        with problems.of("roughness"):
            if scene.topography is not None:
                raise ValueError("give [roughness] or [topography], not both")
            rough = random_field(scene.roughness, spacing)
    problems.check()

    alone, cell = scene.sphere.radius == math.inf, None
    with problems.of("sphere"):
        radius = radius_of(scene.sphere, scene.topography, spacing)
        if radius == math.inf and rough is None:
            raise ValueError(
                "radius = inf needs a section [topography], whose scan is the whole "
                "tip or a rough flat, or [roughness]: give that, or a finite radius"
            )
        profile: Any = scene.sphere.profile
        pixel = spacing
        if radius == math.inf and rough is not None:
            pixel, cell, rough = flat_cell(scene, rough, spacing)
            solid.check(pixel)
        surface = RoughSphere(math.inf if alone else radius, rough, profile)
    with problems.of("interaction"):
        wall = _wall(scene, solid, spacing, hardness)
    problems.check()

    with problems.of("heterogeneity"):
        adhesion = _local_adhesion(scene, wall, radius, spacing)
    problems.check()
    given = "hardness" in scene.interaction.parameters
    is_tip = alone and cell is None
    return Bodies(
        problem=Problem(
            indenter=surface,
            solid=solid,
            wall=wall,
            spacing=pixel,
            periodic=scene.substrate.periodic or cell is not None,
            heterogeneity=adhesion,
        ),
        symbol=substrate.symbol,
        hardness=wall.hardness if given else hardness,
        radius=radius,
        rough=None if is_tip else rough,
        cell=cell,
        whole_tip=rough if is_tip and isinstance(rough, HeightMap) else None,
        friction=scene.friction,
        scanned=scene.topography.role if scene.topography else "",
    )


def _hardness(substrate: SubstrateConfig, symbol: str, spacing: float) -> float:
    """Return the hardness of the surface (eV/Å^3); NaN if it is not known."""
    given = substrate.hardness
    if given is None:
        if not substrate.name or substrate.layer_thickness is not None:
            return math.nan
        return hardness_of(symbol, spacing)
    if given != math.inf and not 0.0 < given <= _LARGEST_HARDNESS:
        raise ValueError(
            f"hardness is in GPa, above 0 and at most {_LARGEST_HARDNESS:g}, or inf, "
            f"got {given:g}"
        )
    return given * UNITS["GPa"]


def _with_tip(solid: ElasticSolid, name: str, creep: Creep | None) -> ElasticSolid:
    """Return the solid that deforms as both bodies do, if the tip has a material.

    The tip is elastic also if the substrate creeps.
    """
    if not name:
        return solid if creep is None else Viscoelastic(solid, creep)
    if not isinstance(solid, Isotropic):
        raise ValueError(
            "the material of the sphere needs an isotropic substrate, got "
            f"{solid!r}: leave it out"
        )
    tip = material(name).contact_modulus * UNITS["GPa"]
    poisson, beta, of_tip = None, None, material(name).poisson
    if solid.poisson is not None:
        if of_tip is None:
            raise ValueError(
                f"Poisson's ratio of the material {name!r} is not known, which "
                "friction needs: leave it out"
            )
        first = solid.contact_modulus, solid.poisson
        poisson = combined_poisson(first, (tip, of_tip))
        beta = dundurs_parameter(first, (tip, of_tip))
    both = Isotropic(combined_modulus(solid.contact_modulus, tip), poisson, beta)
    if creep is None:
        return both
    return Viscoelastic(
        both, creep.scaled(both.contact_modulus / solid.contact_modulus)
    )


def _wall(
    scene: SceneFile, solid: ElasticSolid, spacing: float, hardness: float
) -> Interaction:
    """Return the wall, with parameters of the materials for those not given."""
    kind, parameters = scene.interaction.kind, dict(scene.interaction.parameters)
    missing = lookup(kind, WALLS, "kind of interaction").parameters.keys()
    missing -= parameters.keys()
    materials = scene.substrate.material, scene.sphere.material
    if "work_of_adhesion" in missing and all(materials):
        parameters["work_of_adhesion"] = work_of_adhesion(*materials)
    if "attraction_range" in missing and all(materials):
        parameters["attraction_range"] = f"{ATTRACTION_RANGE} nm"
    if "hardness" in missing and not math.isnan(hardness):
        parameters["hardness"] = hardness / UNITS["GPa"]
    return make_wall(kind, solid.contact_modulus, spacing, parameters)


def _local_adhesion(
    scene: SceneFile, wall: Interaction, radius: float, spacing: float
) -> Heterogeneity | None:
    """Return the work of adhesion relative to that of the wall; None if uniform."""
    if scene.heterogeneity is None:
        return None
    if not wall.attractive:
        kind = scene.interaction.kind
        raise ValueError(f"needs a wall with a work of adhesion, got kind = {kind!r}")
    in_range = (
        0.0
        if radius == math.inf
        else math.sqrt(2.0 * radius * (wall.cutoff - wall.contact_distance))
    )
    return local_adhesion(scene.heterogeneity, spacing, _ROOM * in_range)
