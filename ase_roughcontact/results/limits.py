"""Limits of the model: quantities of a relaxed step that must not exceed a value.

The model is a linear elastic half space under small slopes, sampled by atoms. A limit
is an entry of `CHECKS`. The column `validity` of a step lists the limits it exceeds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact.contact import Problem
from ase_roughcontact.elasticity.named_materials import LARGEST_RELATIVE_HARDNESS
from ase_roughcontact.results.stresses import yield_ratio
from ase_roughcontact.results.surroundings_errors import LARGEST_PART_OF_CELL
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.theory.maugis import edge_zone
from ase_roughcontact.windows.expected import contact_radius_on
from ase_roughcontact.windows.fixed import at_edge

#: Least width of the zone of attraction at the edge of a contact, in a0.
LEAST_EDGE_ZONE = 7.0
#: Largest relative error of force or area that a given `fmax` may leave.
LARGEST_ERROR_BY_FMAX = 0.01
# Name of the limit of the mean pressure.
_MEAN_PRESSURE = "mean pressure/hardness"
# Name of the limit of the largest pressure.
_LARGEST_PRESSURE = "largest pressure/hardness"
# Name of the limit of the largest pressure if the hardness is not known.
_PRESSURE_OVER_BOUND = "largest pressure/bound of the hardness"
# Separator of the entries of the column `validity`.
_SEPARATOR = "; "


@dataclass(frozen=True)
class Check:
    """A limit of the model's validity.

    Attributes
    ----------
    condition : str
        ``"quantity/unit > limit"`` or ``"< limit"``, outside of the validity.
    reason : str
        The reason for the limit.
    value : callable
        Function of a `RelaxedStep` that returns the quantity, NaN if it is not defined.
    constant : bool
        Whether the quantity is the same in all steps of a path, apart from a local
        work of adhesion.
    attractive : bool or None
        Whether it is a limit of walls with attraction, of others, or of all.
    """

    condition: str
    reason: str
    value: Callable[[RelaxedStep], float]
    constant: bool = False
    attractive: bool | None = None

    @property
    def name(self) -> str:
        """The quantity, divided by its unit."""
        return self.condition.rsplit(" ", 2)[0]

    def violation(self, step: RelaxedStep) -> str:
        """Return ``"quantity = value > limit"``; empty if the limit is kept."""
        if self.attractive not in (None, step.contact.wall.attractive):
            return ""
        return self.entry(self.value(step))

    def entry(self, value: float) -> str:
        """Return the entry in the column for a value; empty if the limit is kept."""
        name, sign, limit = self.condition.rsplit(" ", 2)
        exceeds = value > float(limit) if sign == ">" else value < float(limit)
        return f"{name} = {value:.3g} {sign} {limit}" if exceeds else ""


def violations(step: RelaxedStep) -> str:
    """Return the limits that a relaxed step exceeds, with values; empty if none."""
    entries = [check.violation(step) for check in CHECKS]
    return _SEPARATOR.join(filter(None, entries))


def marked_for_hardness(
    columns: Mapping[str, Any], hardness: float, bound: float
) -> str:
    """Return the column `validity` of a result for another hardness.

    Parameters
    ----------
    columns : mapping
        Columns of the result.
    hardness : float
        Hardness with which pressures are compared; infinity or NaN for none (pressure).
    bound : float
        Bound of a hardness that is not known; NaN without one (pressure).

    Returns
    -------
    str
    """
    largest, mean = columns["largest_pressure"], columns["mean_pressure"]
    if columns["area_column"] == "continuum_area" and columns["contact_area"]:
        mean *= columns["continuum_area"] / columns["contact_area"]  # over atoms
    values = {
        _MEAN_PRESSURE: min(mean, largest) / hardness,
        _LARGEST_PRESSURE: largest / hardness,
        _PRESSURE_OVER_BOUND: largest / bound,
    }
    entries = [
        check.entry(values[check.name]) for check in CHECKS if check.name in values
    ]
    entries += [
        entry
        for entry, check in failed_checks(columns["validity"]).items()
        if check.name not in values
    ]
    return _SEPARATOR.join(filter(None, entries))


def failed_checks(validity: str) -> dict[str, Check]:
    """Return the checks in a column `validity`, by their entries in it.

    Parameters
    ----------
    validity : str
        The column, as `violations` returns it.

    Returns
    -------
    dict of Check
    """
    checks = {check.name: check for check in CHECKS}
    entries = validity.split(_SEPARATOR) if validity else []
    return {entry: checks[entry.partition(" = ")[0]] for entry in entries}


def exceeded_names(validities: Iterable[str]) -> list[str]:
    """Return the names of all limits in several columns `validity`, each once.

    Parameters
    ----------
    validities : iterable of str
        Columns of the steps of a path, as `violations` returns them.

    Returns
    -------
    list of str
    """
    checks = (check for text in validities for check in failed_checks(text).values())
    return list(dict.fromkeys(check.name for check in checks))


def _mean_pressure(step: RelaxedStep) -> float:
    # rounding may make the mean of equal pressures larger than any of them
    pressure = min(step.mean_pressure, float(step.fields.pressure.max()))
    return pressure / step.options.hardness


def _contact_radius(step: RelaxedStep) -> float:
    """Return the largest distance from the axis over R, for a paraboloid."""
    indenter = step.problem.topography
    if indenter.profile != "paraboloid":
        return math.nan
    return step.contact_radius / indenter.apex_radius


def _patch_width(step: RelaxedStep) -> float:
    """Return the width in pixels of squares with the area and perimeter of patches."""
    if not step.touches:
        return math.nan
    area, sides = step.fields.contact_area, step.perimeter
    width = 4.0 * area / sides if sides else math.inf
    return width / step.problem.topography.rough.pixel


def _smallest_gap(step: RelaxedStep) -> float:
    core = step.contact.wall.extrapolated_below
    return float(step.fields.gap.min()) / core


def _slope(step: RelaxedStep) -> float:
    """Return the largest slope between an atom in contact and its neighbours.

    Zero if the indenter has vertical sides, between which it is flat.
    """
    if step.problem.topography.vertical_sides:
        return 0.0
    contact, heights = step.fields.contact.copy(), step.contact.heights
    contact[-1] = contact[:, -1] = False
    atoms = contact.ravel().nonzero()[0]
    here, right, above = (heights.take(atoms + k) for k in (0, 1, contact.shape[1]))
    right -= here
    above -= here
    largest = (right * right + above * above).max(initial=0.0)
    return math.sqrt(largest) / step.halfspace.spacing


def _tension(step: RelaxedStep) -> float:
    halfspace = step.halfspace
    load = 0.0
    if not step.run.support.fixed:
        load = step.run.support.load / halfspace.cell_area
    return max(-float(step.fields.pressure.min()), -load) / halfspace.contact_modulus


def _tip_zone(step: RelaxedStep) -> float:
    """Return the radius around a point contact in which the wall attracts, in a0."""
    reach = step.problem.topography.apex_radius * step.contact.wall.attraction_range
    return math.sqrt(2.0 * reach) / step.halfspace.spacing


def _part_of_period(step: RelaxedStep) -> float:
    """Return the cell over the period of the indenter, if the edges touch."""
    halfspace = step.halfspace
    if not (halfspace.periodic and at_edge(step.fields.contact)):
        return math.nan
    sides = halfspace.spacing * np.array(halfspace.shape)
    return step.problem.topography.part_of_period(sides)


def _edge_zone(step: RelaxedStep) -> float:
    """Return the smallest width of Dugdale's zone at the edge of a contact, in a0."""
    adhesion = step.contact.adhesion  # relative, None if it is uniform
    largest = 1.0 if adhesion is None else float(adhesion.max())
    return narrowest_zone(step.problem, largest) / step.halfspace.spacing


def narrowest_zone(problem: Problem, relative_work: float = 1.0) -> float:
    """Return the smallest width of Dugdale's zone at the edge of a contact (length).

    Its modulus is the modulus for waves of its width in the relaxed solid.

    Parameters
    ----------
    problem : Problem
        Contact problem with an attractive wall.
    relative_work : float
        Work of adhesion over the wall's.
    """
    wall, creep = problem.wall, problem.solid.creep
    relaxed = creep.relaxed if creep else 1.0
    work = relative_work * wall.work_of_adhesion

    def zone(modulus: float) -> float:
        return edge_zone(relaxed * modulus, work, wall.attraction_range)

    return contact_radius_on(problem.solid, problem.spacing, zone)


def _coupling(step: RelaxedStep) -> float:
    neglected = step.lateral is not None and not step.lateral.alternations
    if not neglected or not step.fields.normal_force > 0.0:
        return math.nan
    tractions = float(np.hypot(*step.lateral.solution.tractions).sum())
    friction = tractions * step.fields.cell_area / step.fields.normal_force
    return step.problem.solid.coupling * friction


def _slip(step: RelaxedStep) -> float:
    """Return the largest slip over the shortest wave; without one, over the radius."""
    if step.lateral is None or not step.touches:
        return math.nan
    shortest = step.problem.topography.rough.shortest_wavelength
    length = step.contact_radius if math.isnan(shortest) else shortest
    return step.lateral.slip / length if length else math.nan


def _error_by_fmax(step: RelaxedStep) -> float:
    """Return the relative error of force or area that a given `fmax` leaves.

    Force relative to all forces of the wall, area beyond one atom.
    """
    fields, errors = step.fields, step.relaxation
    if step.options.fmax is None or not step.touches:
        return math.nan
    force = errors.force
    if not step.run.support.fixed:
        force = errors.height * abs(step.response.force)
    area = max(errors.area - fields.cell_area, 0.0)
    return max(force / fields.total_magnitude, area / fields.contact_area)


#: Limits of the model.
CHECKS = (
    Check(
        f"{_MEAN_PRESSURE} > 1",
        "the contact deforms plastically: its area is about load over hardness",
        _mean_pressure,
    ),
    Check(
        f"{_LARGEST_PRESSURE} > 1",
        "the highest asperities deform plastically",
        lambda s: float(s.fields.pressure.max()) / s.options.hardness,
    ),
    Check(
        f"{_PRESSURE_OVER_BOUND} > 1",
        "the hardness is not known, and no listed material is harder than "
        f"{LARGEST_RELATIVE_HARDNESS:.3g} E*, about the theoretical strength: give a "
        "hardness, infinity for a rubber",
        lambda s: float(s.fields.pressure.max()) / s.options.hardness_bound,
    ),
    Check(
        "largest von Mises stress/yield strength > 1",
        "the solid yields below the surface, or under friction at it, which the model "
        "does not describe: the columns von_mises_depth, von_mises_x and von_mises_y "
        "have the place",
        yield_ratio,
    ),
    Check(
        "contact radius/R > 0.2",
        "a paraboloid is lower than the sphere of its curvature, by 1 % at this limit",
        _contact_radius,
    ),
    Check(
        "R/a0 < 1",
        "the sphere is smaller than the spacing of the atoms: lengths are in Å",
        lambda s: s.problem.topography.apex_radius / s.halfspace.spacing,
        constant=True,
    ),
    Check(
        "slope > 0.5",
        "slopes must be small: the true area is 12 % above its projection at this "
        "limit, and pressures act along z only",
        _slope,
    ),
    Check(
        "atoms in contact < 10",
        "the area of fewer atoms depends on where the lattice lies below the indenter",
        lambda s: s.fields.repulsive_atoms or math.nan,
    ),
    Check(
        "width of contact patches/pixel < 3",
        "patches of few pixels depend on heights between them that were not measured, "
        "and on noise",
        _patch_width,
    ),
    Check(
        f"error by fmax > {LARGEST_ERROR_BY_FMAX:g}",
        "the forces that fmax allows change the force or the area by this part: give "
        "accuracy, or the fmax of fmax_for(atoms, error)",
        _error_by_fmax,
    ),
    Check(
        "smallest gap/core < 1",
        "the potential of the wall is extrapolated below its core",
        _smallest_gap,
    ),
    Check(
        "tension/E* > 0",
        "nothing holds the surfaces together without adhesion",
        _tension,
        attractive=False,
    ),
    Check(
        f"adhesive contact/cell > {LARGEST_PART_OF_CELL:g}",
        "the contact nearly touches its periodic images, and may be in another state "
        "than a single one",
        lambda s: s.part_of_cell,
        attractive=True,
    ),
    Check(
        "cell/period of the roughness < 1",
        "heights jump at the edges of the periodic cell, and atoms touch there",
        _part_of_period,
    ),
    Check(
        "adhesive zone at the tip/a0 < 5",
        "the atoms do not resolve sqrt(2 R D), the radius in which a sphere in point "
        "contact attracts, and the pull-off force may be wrong by more than 1 %",
        _tip_zone,
        constant=True,
        attractive=True,
    ),
    Check(
        f"adhesive zone at the edge/a0 < {LEAST_EDGE_ZONE:g}",
        "the atoms do not resolve pi E* D^2/(4 w), the width of Dugdale's zone at the "
        "edge of a contact, and the pull-off force may be wrong by more than 1 %",
        _edge_zone,
        constant=True,
        attractive=True,
    ),
    Check(
        "coupling by friction > 0.1",
        "(1 - 2 nu)/(2 - 2 nu) times the friction over the load: tractions lift the "
        "surface, which is neglected unless coupling is 'solved'; at this limit a "
        "smooth sphere that slides has its center of pressure off by 5 % of its "
        "radius, and the load by 0.2 %",
        _coupling,
    ),
    Check(
        "new area/contact area > 0.1",
        "coupled atoms stick as if in contact since the beginning of the step; at this "
        "limit the area of a smooth sphere is 8 % too small: load in more steps",
        lambda s: s.lateral.new_contact if s.lateral else math.nan,
    ),
    Check(
        "slip/shortest wavelength > 0.1",
        "heights are taken at the first place of the indenter, but its shortest waves, "
        "or the contact of a smooth sphere, have moved",
        _slip,
    ),
)
