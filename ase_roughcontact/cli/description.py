"""Description of a scene and of the theory for it, as names and texts."""

from __future__ import annotations

import math
from typing import Any

from ase_roughcontact._util.rounding import RATIO_ROUNDING
from ase_roughcontact._util.units import UNITS, pressure_unit, with_unit
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.results.record import columns_of
from ase_roughcontact.results.scan_errors import scans_of
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import Reference
from ase_roughcontact.scene.rough_bodies import combined
from ase_roughcontact.scene.scan import tip_radius
from ase_roughcontact.scene.solid import label_of
from ase_roughcontact.topography import Inverted, RandomWaves
from ase_roughcontact.windows.regrid import lost_text

# Spacing below which it is printed in Å (Å).
_MAX_ATOMIC_SPACING = 10.0


def bodies(scene: Scene) -> dict[str, str]:
    """Return descriptions of solid, indenter, roughness and wall."""
    nm, tip = UNITS["nm"], scene.whole_tip
    radius = f"radius {with_unit(scene.radius, 'nm')}"
    solid = label_of(scene.substrate, scene.solid)
    if scene.bodies.tip is not None:
        solid += f" with {scene.bodies.tip.label}"
    if not scene.is_flat:
        solid += f", {_spacing(scene)}"
    indenter = f"sphere of {radius}"
    if tip is not None:
        indenter = f"scanned tip (radius {tip_radius(tip)}, fitted to the scan)"
    if scene.bodies.shape is not None:
        indenter = scene.bodies.shape.label
    found = {"solid": f"{solid}, {_hardness(scene)}", "indenter": indenter}
    if scene.is_flat:
        n, m = (k * scene.spacing / nm for k in scene.bodies.cell or ())
        found["indenter"] = f"rough flat, periodic cell of {n:.4g} x {m:.4g} nm"
        found["indenter"] += _resampled(scene)
        removed = scene.bodies.problem.topography.rough.edge_change
        if removed:
            found["indenter"] += (
                f"; a smooth surface (rms height {removed / nm:.3g} nm) is subtracted, "
                "which makes it periodic (Moisan 2011); the errors of areas include it"
            )
    found |= _roughness(scene)
    wall = scene.wall
    found["wall"] = wall.label
    if wall.attractive:
        found["wall"] += (
            f", {wall.work_of_adhesion / UNITS['J/m^2']:.3g} J/m², range of the "
            f"attraction {wall.attraction_range / nm:.3g} nm{_origin(scene)}"
        )
    if scene.friction is not None:
        found["friction"] = scene.friction.label
        if isinstance(scene.solid, Isotropic):
            poisson = scene.solid.poisson
            found["friction"] += f"; Poisson's ratio of the solid {poisson:.3g}"
    if scene.is_continuum:
        lost = scene.lost_slope
        label = scene.grid_change.label
        if scene.is_flat and scene.scan is not None:
            label = label.replace("a0", "pixel")
        spacing = scene.grid_change.spacing(scene.spacing) / nm
        found["grid"] = f"continuum on a grid of spacing {label} = {spacing:.4g} nm"
        if lost:
            found["grid"] += f"; {lost_text(scene.grid_change, lost)}"
    return found


def _roughness(scene: Scene) -> dict[str, str]:
    """Return the statistics of the roughness of each body, and of their sum."""
    found, parts = {}, scene.bodies.parts
    for part in parts:
        body = part.section.title.rpartition(".")[0]
        if part.is_scan:
            found[f"{body} scan".strip()] = part.section.summary
        else:
            free = part.section.free
            found[f"{body} roughness".strip()] = _random_text(part.surface, free)
    if len(parts) > 1:
        both = combined(parts)
        found["roughness of both"] = (
            f"{_statistics_text(both)}: sums of mean squares, as of independent "
            "surfaces"
        )
    return found


def _random_text(surface: Any, free: str) -> str:
    """Return statistics and spectrum of a random roughness, and what was solved for."""
    nm, rough = UNITS["nm"], surface
    if isinstance(surface, Inverted):
        rough = surface.surface
    label = (
        f"Hurst exponent {rough.hurst:.3g}, wavelengths from "
        f"{rough.short_wavelength / nm:.4g} to {rough.long_wavelength / nm:.4g}"
    )
    if isinstance(rough, RandomWaves):
        label = rough.label(nm)
    text = f"{_statistics_text(rough)}; {label} nm; one realisation"
    if free:
        value = getattr(rough, free)
        words = f"{value:.4g}" if free == "hurst" else with_unit(value, "nm")
        text += f"; {free} = {words} follows from the other two"
    return text


def _statistics_text(rough: Any) -> str:
    """Return rms height, slope and curvature."""
    statistics, nm = rough.statistics(), UNITS["nm"]
    return (
        f"rms height {with_unit(statistics.rms_height, 'nm')}, slope "
        f"{statistics.rms_slope:.4g}, curvature "
        f"{statistics.rms_curvature * nm:.4g} /nm"
    )


def theory(reference: Reference) -> dict[str, str]:
    """Return descriptions of the theory with which a scene is compared."""
    scene, smooth = reference.scene, reference.smooth
    found, limits = {}, reference.scene.bodies.sphere_limits
    if reference.explanation:
        found["theory"] = reference.explanation
        if limits:
            found["theory"] += ", at the instantaneous modulus"
    if reference.criteria:
        found["stickiness of flats"] = "; ".join(map(str, reference.criteria))
    if smooth.pull_off_force:
        forces = (
            f"{with_unit(each.pull_off_force, 'nN')} ({each.name}, {name} modulus)"
            for name, each in limits.items()
        )
        found["pull-off force"] = "; ".join(forces) or pull_off_text(reference)
    if scene.is_flat:
        found["columns"] = (
            "p: nominal pressure; gap: mean; kappa = A h' E*/N; k: stiffness"
        )
        if "conductance" in columns_of(scene.record):
            found["columns"] += (
                "; C: electrical or thermal conductance of the contact region times "
                "the sum of the resistivities"
            )
    elif not scene.path.columns:
        label = scene.bodies.labelled(f"{smooth.name}, {smooth.sphere}")
        found[f"A/A_{smooth.symbol}"] = (
            f"contact area relative to {label}{_under_soft_wall(scene)}"
        )
    return found


def pull_off_text(reference: Reference) -> str:
    """Return the pull-off force of theory, with its unit and the theory."""
    smooth = reference.smooth
    label = reference.scene.bodies.labelled(smooth.label)
    return f"{with_unit(smooth.pull_off_force, 'nN')} ({label})"


def _origin(scene: Scene) -> str:
    """Return the origin of the range of the attraction if it is not given."""
    materials = scene.substrate.material and scene.tip_material
    if materials or "attraction_range" in scene.interaction.parameters:
        return ""
    return ", which follows from the spacing: attraction_range sets it"


def _resampled(scene: Scene) -> str:
    """Return how scans are sampled if their pixels are not the grid."""
    spacing, nm = scene.spacing, UNITS["nm"]
    scans: list[Any] = [
        part.section.surface for part in scene.bodies.parts if part.is_scan
    ]
    strains = [abs(scan.measurement.strain) for scan in scans_of(scene.bodies.problem)]
    if len(scans) > len(strains):
        return (
            f", the common middle of two scans, on squares of {spacing / nm:.4g} nm by "
            "cubic splines; errors by pixels and noise are not known"
        )
    if not scans or math.isclose(*scans[0].spacing, rel_tol=RATIO_ROUNDING):
        return ""
    x, y = (each / nm for each in scans[0].spacing)
    return (
        f", on squares of {spacing / nm:.4g} nm by cubic splines from "
        f"pixels of {x:.4g} x {y:.4g} nm; lengths along y are changed by "
        f"{100.0 * strains[0]:.2g} %"
    )


def _spacing(scene: Scene) -> str:
    """Return the spacing of the atoms, or the one that fits the contact."""
    if scene.bodies.fitted:
        return f"spacing {with_unit(scene.spacing, 'nm')}, which fits the contact"
    if scene.spacing < _MAX_ATOMIC_SPACING:
        return f"spacing {scene.spacing:.3f} Å"
    return f"spacing {with_unit(scene.spacing, 'nm')}"


def _hardness(scene: Scene) -> str:
    hardness = scene.hardness / UNITS["GPa"]
    if math.isnan(hardness):
        bound = scene.bodies.hardness_bound
        if math.isnan(bound):
            return "hardness unknown"
        pressure = with_unit(bound, pressure_unit(bound))
        return f"hardness unknown: pressures above {pressure} are marked"
    if math.isinf(hardness):
        return "elastic"
    of_both = " of the softer body as far as known" if scene.bodies.tip else ""
    return f"hardness {hardness:.3g} GPa{of_both}"


def _under_soft_wall(scene: Scene) -> str:
    """Return how the area under a soft wall differs from the area of theory."""
    if scene.wall.hard:
        return ""
    if not scene.wall.attractive:
        if scene.rough is not None:
            return ""
        return '; a soft wall enlarges it, most in small contacts (Hertz: "hard")'
    return (
        "; areas are of the atoms under pressure, while the area of theory includes "
        "the rim under tension, and is larger"
    )
