r"""Estimated errors of area, force, height and penetration of a relaxed step.

They add up from four sources:

- *Relaxation.* Remaining forces and gaps; see `RelaxationErrors`.
- *Grid*, if the continuum is asked for. Errors of the area are those of
  `edge_area` or `grid_error`. At a given height the error of the force is about

  .. math:: \delta N = a_0^2 \sum |p| \left[
            \frac{0.04\, \Delta x^2 S_d}{A^{3/2}}\, s^2
            \max\left(1, \frac{n + 1}{3}\right)
            + 0.015 \left(\frac{\Delta x}{a}\right)^3
            \frac{E^*(1/a)}{E^*(\pi/\Delta x)} \right]
            + \frac{N}{2 A}\, \delta A_c + H\, \delta A_p
            + 0.1 \left(S_d\, \Delta x^3\right)^{1/2} \Delta p_a

  on a grid of spacing :math:`\Delta x`, with the area :math:`A = \pi a^2` and its
  perimeter :math:`S_d`: attraction adds to the forces that a grid can't resolve. Under
  a rigid indenter of the profile r^n the force has a maximum at the true radius a of
  the contact, and an error da changes it by :math:`\tfrac{1}{2} s^2 (n + 1) N (da/a)^2`
  if the stiffness of the contact is proportional to :math:`a^s`: on a half space s = 1
  and :math:`n + 1 = (1 - N/(\delta\, dN/d\delta))^{-1}` with the penetration
  :math:`\delta` (from I. N. Sneddon, Int. J. Eng. Sci. 3, 47 (1965)); on layers
  :math:`s = 1 - d \ln E^*/d \ln q` at q = 1/a, taken as 1 if it is less. n + 1 is 3
  under a sphere, about that or less in rough contacts, taken as 3 under walls that are
  soft, attract or have a hardness, and not above :math:`A^{1/2}/\Delta x`. The second
  term is the error of the compliance of long waves on a free surface, which is large
  where a layer is thinner than the spacing. At a corner of the indenter there is no
  maximum: N is proportional to a, that is to :math:`\sqrt{A}`, and the error
  :math:`\delta A_c` of the area there counts to first order, and so does that of
  plastic contact, :math:`\delta A_p`, with
  the hardness H. Where the attraction of a hard wall ends between two points, or that
  of any wall without contact, as far as the largest difference :math:`\Delta p_a` of
  neighbours says, it is as if points were counted; this changes the area under a load
  as well. The height under a load is wrong by :math:`\delta N/(dN/dZ)`: next to an
  instability the contact is compliant. In
  a periodic half space the first factor is 0.006 without those that follow, and this
  part of the height is wrong by :math:`\delta N/(E^* \sqrt{A})`. A plastic shape that
  the surface has kept from earlier steps shifts the height by about

  .. math:: \delta Z = 0.005\, \frac{H S_f\, \Delta x}{E^* \sqrt{A_f}}

  with the area :math:`A_f` that has flowed and its perimeter :math:`S_f`. The zero of
  the penetration, the lowest point of the indenter, is known to `lowest_point_error`.
  Under a load or at a given height it is an error of the penetration, at a given
  penetration one of the height, which the stiffness of the contact turns into one of
  the force.
- *Cell.* Images of the contact in a square cell of side L shift the height, and press
  the surroundings down, by

  .. math:: \frac{1}{\pi E^*} \left(\frac{3.9003\, N}{L}
            - \frac{9.0336\, M}{4 L^3}\right), \qquad
            \frac{\delta A}{A} = \frac{2}{3}\, \frac{9.0336\, R N}{2 \pi E^* L^3},

  with the second moment of the pressure :math:`M = a_0^2 \sum p\, r^2`, which
  adhesion makes negative and large. Where an adhesive contact nearly touches its
  images, it may be in another state, and the errors are not known. A contact without
  images has the compliance dZ/dN of the cell plus that of this shift,
  from which the error of the force at a given height follows. The numbers are the sums
  of 1/r and 1/r^3 over a square lattice, the first of them with a uniform background.
  Waves of a few spacings are stiffer or softer than those of a free half space, which
  adds the error of a grid.
- *Edges* of a scan without a period, which is pressed without a smooth surface of rms
  height :math:`s`. How the surface goes on decides which asperities carry the load: the
  area of about :math:`n = \pi S_d^2/(64 A)` patches in a cell of side L is wrong by
  :math:`A/(3 \sqrt{n})` times :math:`\min(1, \pi E^* s L/N)`.
"""

from __future__ import annotations

import math
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ase_roughcontact.stepping.relaxation_errors import area_of_force
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.theory.counted_area import continuum_area, grid_error, open_sides
from ase_roughcontact.topography.lowest_point import lowest_point_error

# Factors of the error of the force by the grid: measured on rough spheres and flats by
# examples/benchmarks/grid_error.py.
_FORCE_FACTOR = {False: 0.04, True: 0.006}  # free and periodic half space
# Factor of the error of the force by the compliance of long waves: measured on spheres
# and incompressible layers with thicknesses of 0.5 to 2 spacings.
_COMPLIANCE_FACTOR = 0.015
# Factor of the error of the force where an attraction ends between two points: 0.10 to
# 0.17 on smooth spheres under Dugdale walls with zones of 6 to 22 spacings.
_ATTRACTION_FACTOR = 0.1
# Factor of the error of the height by a plastic shape: measured on rough spheres and
# flats after loading to 1 to 100 % of plastic contact.
_SHAPE_FACTOR = 0.005
# Error of the area by the waves of a cell, in parts of the correction of a count.
_PART_OF_CORRECTION = 0.1
# Sums over a square lattice, of 1/r with a uniform background and of 1/r^3.
_SUM_OF_INVERSES, _SUM_OF_CUBES = 3.900265, 9.033622
#: Largest diameter of an adhesive contact over the side of its periodic cell, at which
#: the errors were within twice the estimate: examples/benchmarks/answer_errors.py.
LARGEST_PART_OF_CELL = 0.85
# Factor of the error of the area by the edges of a scan without a period: twice the
# error covers nine of ten differences to scans that are continued by reflection, of 64
# and 128 points, Hurst exponents 0.5 and 0.8, and areas of 0.5, 2 and 10 %.
_EDGE_FACTOR = 1.0 / 3.0


# Reasons for errors that are not known.
_NEAR_IMAGES = (
    "an adhesive contact that nearly touches its images in the periodic cell may be in "
    "another state: give a larger shape"
)
_INSTABILITY = (
    "the contact stiffness is not known, as at an instability, where the state is no "
    "minimum"
)


class Errors(NamedTuple):
    """Estimated errors of the answer; NaN where they are not known.

    Attributes
    ----------
    area : float
        Of the contact area (Å^2).
    force : float
        Of the normal force (eV/Å).
    height : float
        Of the height (Å).
    penetration : float
        Of the penetration (Å).
    unknown : str
        Why some of them are not known; else empty.
    """

    area: float
    force: float
    height: float
    penetration: float
    unknown: str = ""

    @classmethod
    def not_known(cls, reason: str) -> Errors:
        """Return errors that are all NaN, for a reason."""
        return cls(math.nan, math.nan, math.nan, math.nan, reason)

    def plus(self, other: Errors) -> Errors:
        """Return the sums of these errors and others."""
        area, force, height, penetration = np.add(self[:4], other[:4]).tolist()
        reasons = dict.fromkeys(filter(None, (self.unknown, other.unknown)))
        return Errors(area, force, height, penetration, "; ".join(reasons))


# Errors of relaxed steps that several columns ask for.
_ESTIMATED: WeakKeyDictionary[RelaxedStep, Errors] = WeakKeyDictionary()


def errors_of(step: RelaxedStep) -> Errors:
    """Return the estimated errors of a step, with the errors by a scan.

    They are estimated once for each step.
    """
    if step not in _ESTIMATED:
        errors, by_scan = estimated_errors(step), step.options.scan_errors
        _ESTIMATED[step] = errors.plus(by_scan(step)) if by_scan else errors
    return _ESTIMATED[step]


def estimated_errors(step: RelaxedStep) -> Errors:
    """Return the estimated errors of area, force, height and penetration.

    Parameters
    ----------
    step : RelaxedStep

    Returns
    -------
    Errors
        Under a given load the error of the force is what the indenter's balance lacks;
        at a given height that of the height is zero. That of the area of a periodic
        cell is at most the cell. What is not prescribed is NaN at an instability, and
        all are where an adhesive contact nearly touches its images.
    """
    unbalanced = step.run.unbalanced
    given_depth, fixed = step.control == "penetrations", step.run.support.fixed
    lowest = _lowest_point(step)
    if not (step.touches or step.fields.attractive_atoms):
        left, penetration = step.relaxation, 0.0 if given_depth else lowest
        force = left.force if fixed else unbalanced
        return Errors(left.area, force, 0.0, penetration, left.unknown)
    attractive = step.contact.interaction.attractive
    if attractive and step.part_of_cell > LARGEST_PART_OF_CELL:
        return Errors.not_known(_NEAR_IMAGES)
    unstable = math.isnan(step.response.force)
    if reason := _INSTABILITY if unstable else step.relaxation.unknown:
        unknown = Errors.not_known(reason)
        if not fixed:
            return unknown._replace(force=unbalanced)
        return unknown._replace(height=0.0, penetration=0.0 if given_depth else lowest)
    stiffness = abs(step.response.force)
    # all atoms in contact may be in plastic contact
    softness = 1.0 / stiffness if stiffness else math.inf
    compliance = _cell_compliance(step)
    shift = _cell_shift(step)
    if step.options.continuum:
        shift += _grid_height(step, softness) + _kept_shape(step)
    area = _cell_area(step) + step.relaxation.area
    if step.options.continuum:
        area += continuum_area_error(step)
        area += area_of_force(step.fields, _attraction_force(step))
    area += _unknown_surroundings(step)
    if not fixed:
        height = shift + step.relaxation.height
        area = _within_cell(step, area)
        return Errors(area, unbalanced, height, height + lowest)
    if given_depth:
        shift, lowest = shift + lowest, 0.0
    force = _force_change(shift, softness + compliance)
    area += area_of_force(step.fields, force)
    return Errors(_within_cell(step, area), step.relaxation.force + force, 0.0, lowest)


def _within_cell(step: RelaxedStep, area: float) -> float:
    """Return an error of the area, at most that of a periodic cell (Å^2)."""
    if not step.halfspace.periodic:
        return area
    return min(area, step.fields.cell_area * step.fields.gap.size)


def _force_change(shift: float, compliance: float) -> float:
    """Return the force by a shift of a contact without images (eV/Å)."""
    if not shift:
        return 0.0
    return shift / compliance if compliance else math.inf


def continuum_area_error(step: RelaxedStep) -> float:
    """Return the error of the area of the continuum that the grid makes (Å^2)."""
    if step.edge_area is not None:
        of_grid = step.edge_area.error
    else:
        stiffness = step.contact.interaction.stiffness_at_contact
        modulus = step.halfspace.contact_modulus
        softness = modulus / stiffness if stiffness else math.inf
        of_grid = grid_error(step.perimeter, step.fields.cell_area, softness)
    return of_grid + step.options.lost_slope * step.fields.contact_area


def _unknown_surroundings(step: RelaxedStep) -> float:
    """Return the error of the area by the edges of a scan without a period (Å^2)."""
    halfspace, count = step.halfspace, step.fields.gap.size
    removed, force = step.problem.topography.rough.edge_change, step.fields.normal_force
    if not (removed and step.touches):
        return 0.0
    nominal, area = count * step.fields.cell_area, step.fields.contact_area
    part = math.pi * halfspace.contact_modulus * removed * math.sqrt(nominal)
    part = min(part / force, 1.0) if force > 0.0 else 1.0
    patches = max(math.pi * step.perimeter**2 / (64.0 * area), 1.0)
    return _EDGE_FACTOR * min(area, nominal - area) * part / math.sqrt(patches)


def _grid_height(step: RelaxedStep, softness: float) -> float:
    """Return the error of the height under a load by the grid (Å)."""
    error, halfspace = _edge_force(step) * softness, step.halfspace
    if halfspace.periodic:
        softness = 1.0 / (math.sqrt(_loaded_area(step)[0]) * halfspace.contact_modulus)
    return error + _grid_force(step) * softness


def _grid_force(step: RelaxedStep) -> float:
    """Return the error of the force at a given height by the grid (eV/Å)."""
    fields, halfspace, spacing = step.fields, step.halfspace, step.halfspace.spacing
    (area, perimeter), periodic = _loaded_area(step), halfspace.periodic
    error = _FORCE_FACTOR[periodic] * perimeter * spacing**2 / area**1.5
    if not periodic:
        radius, modulus = math.sqrt(area / math.pi), halfspace.solid.wave_modulus
        long, longer, short = (
            float(modulus(q)) for q in (1.0 / radius, 0.5 / radius, math.pi / spacing)
        )
        stiffening = max(1.0 + math.log2(longer / long), 1.0)
        error *= _profile_factor(step) * stiffening**2
        error += _COMPLIANCE_FACTOR * (spacing / radius) ** 3 * long / short
    return error * fields.total_magnitude


def _loaded_area(step: RelaxedStep) -> tuple[float, float]:
    """Return area and perimeter of the contact, without it of the attracted atoms."""
    if step.touches:
        return step.fields.contact_area, step.perimeter
    attracted, halfspace = step.fields.pressure < 0.0, step.halfspace
    sides = float(open_sides(attracted, halfspace.periodic).sum())
    area = float(np.count_nonzero(attracted)) * step.fields.cell_area
    return area, sides * halfspace.spacing


def _edge_force(step: RelaxedStep) -> float:
    """Return the error of the force that does not follow from a smooth edge (eV/Å)."""
    fields, edge = step.fields, step.edge_area
    error = _attraction_force(step)
    if edge is not None:
        error += fields.normal_force * edge.corner_error / (2.0 * fields.contact_area)
        if edge.plastic_error:
            error += fields.hardness * edge.plastic_error
    return error


def _attraction_force(step: RelaxedStep) -> float:
    """Return the error of the force where an attraction ends between points (eV/Å)."""
    wall, fields = step.contact.interaction, step.fields
    if not wall.attractive or (step.touches and not wall.hard):
        return 0.0
    _, attraction = step.contact.wall(np.maximum(fields.gap, 0.0))
    largest = max(abs(np.diff(attraction, axis=k)).max(initial=0.0) for k in (0, 1))
    points = _loaded_area(step)[1] / step.halfspace.spacing
    return _ATTRACTION_FACTOR * math.sqrt(points) * float(largest) * fields.cell_area


def _kept_shape(step: RelaxedStep) -> float:
    """Return the error of the height by a plastic shape from earlier steps (Å)."""
    fields, halfspace = step.fields, step.halfspace
    if fields.kept_depth is None or not fields.kept_depth.any():
        return 0.0
    flowed = fields.kept_depth > 0.0
    perimeter = halfspace.spacing * open_sides(flowed, halfspace.periodic).sum()
    width = math.sqrt(np.count_nonzero(flowed) * fields.cell_area)
    error = _SHAPE_FACTOR * fields.hardness * perimeter * halfspace.spacing
    return float(error) / (halfspace.contact_modulus * width)


def _profile_factor(step: RelaxedStep) -> float:
    """Return by how much the error of the force is larger than under a sphere."""
    fields, wall = step.fields, step.contact.interaction
    if not wall.purely_hard or wall.plastic:
        return 1.0
    depth = step.contact.first_contact - step.height
    finest = step.halfspace.spacing / math.sqrt(fields.contact_area)
    linear = abs(step.response.force) * depth
    if not linear > 0.0:  # the height of the first contact, or a contact above it
        return 1.0
    return max(1.0, 1.0 / (3.0 * max(1.0 - fields.normal_force / linear, finest)))


def _lowest_point(step: RelaxedStep) -> float:
    """Return the error of the lowest point of the indenter by the grid (Å)."""
    if not step.options.continuum:
        return 0.0
    return lowest_point_error(step.contact.heights, step.halfspace.periodic)


def _cell_compliance(step: RelaxedStep) -> float:
    """Return the shift of the height by the images of a cell per force (Å^2/eV)."""
    modulus = step.halfspace.contact_modulus
    return _SUM_OF_INVERSES / (math.pi * modulus * step.cell_side)


def _cell_shift(step: RelaxedStep) -> float:
    """Return the shift of the height by the images of a cell (Å)."""
    fields, side = step.fields, step.cell_side
    if side == math.inf:
        return 0.0
    x, y = step.positions
    moment = fields.pressure.sum(axis=1) @ x**2 + fields.pressure.sum(axis=0) @ y**2
    forces = fields.normal_force * _SUM_OF_INVERSES / side
    forces -= moment * fields.cell_area * _SUM_OF_CUBES / (4.0 * side**3)
    return abs(float(forces)) / (math.pi * step.halfspace.contact_modulus)


def _cell_area(step: RelaxedStep) -> float:
    """Return the area that the images of a periodic cell take (Å^2)."""
    side = step.cell_side
    if side == math.inf:
        return 0.0
    radius = step.problem.topography.apex_radius
    curvature = (
        _SUM_OF_CUBES * abs(step.fields.normal_force) / (2.0 * math.pi * side**3)
    )
    part = 2.0 / 3.0 * radius * curvature / step.halfspace.contact_modulus
    area, cell = step.fields.contact_area, step.fields.cell_area
    correction = area - continuum_area(area, step.perimeter, math.sqrt(cell))
    return part * area + _PART_OF_CORRECTION * correction + 0.5 * cell
