r"""Estimated errors of area, force and height of a relaxed step.

They add up from three sources:

- *Tolerance.* With the changes :math:`\lambda = dg/dZ` and :math:`x = dp/dZ` of a
  relaxed contact by a unit of height, the forces :math:`f_i` and gaps :math:`g_i` that
  the relaxation leaves change the normal force to first order by

  .. math:: \delta N = \sum_i f_i\,(1 - \lambda_i), \qquad
            \delta N = a_0^2 \sum_{p > 0} x_i\, g_i

  under soft and hard walls.
- *Grid*, if the continuum is asked for. Errors of the area are those of
  `edge_error` or `grid_error`. On a grid of spacing :math:`\Delta x` the height
  under a load is wrong by about

  .. math:: \frac{0.04\, \Delta x^2 S_d}{A^{3/2}\, dN/dZ} a_0^2 \sum |p|, \qquad
            \frac{0.006\, \Delta x^2 S_d}{A^2 E^*} a_0^2 \sum |p|

  in a free and a periodic half space, with the area A and its perimeter :math:`S_d`:
  attraction adds to the forces that a grid can't resolve, and next to an instability
  the contact is compliant. Under a given penetration its zero, the lowest point of the
  indenter, is found to a quarter of the second differences there.
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
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ase_roughcontact.paths.relaxed_contact import RelaxedContact
from ase_roughcontact.theory.counted_area import grid_error
from ase_roughcontact.theory.edge_area import edge_error

# Factor of the error of the height by the grid: measured on rough spheres and flats by
# examples/benchmarks/grid_error.py.
_HEIGHT_FACTOR = {False: 0.04, True: 0.006}  # free and periodic half space
# Part of the sum of second differences by which the lowest point of a grid is too high
# on average.
_LOWEST_POINT = 1.0 / 24.0
# Sums over a square lattice, of 1/r with a uniform background and of 1/r^3.
_SUM_OF_INVERSES, _SUM_OF_CUBES = 3.900265, 9.033622
#: Largest diameter of an adhesive contact over the side of its periodic cell, at which
#: the errors were within twice the estimate: examples/benchmarks/answer_errors.py.
LARGEST_PART_OF_CELL = 0.85
# Relative rounding error of the sum of the forces.
_ROUNDING = 1e-13


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
    """

    area: float
    force: float
    height: float


def estimated_errors(step: RelaxedContact) -> Errors:
    """Return the estimated errors of area, force and height.

    Parameters
    ----------
    step : RelaxedContact

    Returns
    -------
    Errors
        Under a given load the error of the force is what the indenter's balance lacks;
        at a given height that of the height is zero. That of the area of a periodic
        cell is at most the cell. All are NaN at an instability, and where an adhesive
        contact nearly touches its images.
    """
    unbalanced = abs(float(step.forces[-1, 2]))
    if not step.touches:
        return Errors(0.0, unbalanced, 0.0)
    attractive = step.contact.interaction.attractive
    if attractive and step.part_of_cell > LARGEST_PART_OF_CELL:
        return Errors(math.nan, math.nan, math.nan)
    stiffness = abs(step.response.force)
    # all atoms in contact may be in plastic contact
    softness = 1.0 / stiffness if stiffness else math.inf
    relaxation = _relaxation(step)
    compliance = _cell_compliance(step)
    shift = _cell_shift(step)
    if step.continuum:
        shift += _grid_height(step)
    area = _cell_area(step) + _area_change(step, relaxation)
    if step.continuum:
        area += continuum_area_error(step)
    if step.control == "loads":
        height = shift + (relaxation + unbalanced) * softness
        return Errors(_within_cell(step, area), unbalanced, height)
    force = _force_change(shift, softness + compliance)
    area += _area_change(step, force)
    return Errors(_within_cell(step, area), relaxation + force, 0.0)


def _within_cell(step: RelaxedContact, area: float) -> float:
    """Return an error of the area, at most that of a periodic cell (Å^2)."""
    if not step.halfspace.periodic:
        return area
    return min(area, step.state.cell_area * step.state.gap.size)


def _area_change(step: RelaxedContact, force: float) -> float:
    """Return the area that carries a force, at most all of the contact (Å^2)."""
    area, pressure = step.state.contact_area, step.state.contact_pressure
    # the attraction of a wall may cancel its reaction
    return force / pressure if force < pressure * area else area


def _force_change(shift: float, compliance: float) -> float:
    """Return the force by a shift of a contact without images (eV/Å)."""
    if not shift:
        return 0.0
    return shift / compliance if compliance else math.inf


def continuum_area_error(step: RelaxedContact) -> float:
    """Return the error of the area of the continuum that the grid makes (Å^2)."""
    if step.edge_area is not None:
        surface = step.atoms.calc.parameters["indenter"]
        rough = getattr(surface, "roughness", surface)
        wave = getattr(rough, "short_wavelength", math.inf)
        spacing = step.halfspace.spacing
        of_grid = edge_error(step.edge_area, step.perimeter, spacing, wave)
    else:
        of_grid = grid_error(
            step.perimeter,
            step.state.cell_area,
            step.coarse_area is not None,
            _softness(step),
        )
    return of_grid + step.lost_slope * step.state.contact_area


def _softness(step: RelaxedContact) -> float:
    """Return contact modulus over stiffness of a wall where it begins to repel (Å)."""
    wall = step.contact.interaction
    if wall.hard:
        return 0.0
    closest = np.array([np.nextafter(wall.contact_distance, 0.0)])
    stiffness = float(wall.evaluate(closest)[2][0])
    return step.halfspace.contact_modulus / stiffness


def _relaxation(step: RelaxedContact) -> float:
    """Return the error of the force at a fixed height, by the tolerance (eV/Å)."""
    state, response = step.state, step.response
    if np.isinf(response.force):  # full contact of a hard wall: no atom can open
        change = 0.0
    elif step.contact.interaction.hard:
        change = state.cell_area * np.sum(
            response.pressure * state.gap, where=state.contact
        )
    else:
        n, m = state.gap.shape
        forces = state.forces[:n, :m]
        change = np.sum(forces * (1.0 - response.gap))
    rounding = _ROUNDING * state.cell_area * abs(state.pressure).sum()
    return abs(float(change)) + float(rounding)


def _grid_height(step: RelaxedContact) -> float:
    """Return the error of the height under a load, or at a penetration (Å)."""
    halfspace, state = step.halfspace, step.state
    width = math.sqrt(state.contact_area)
    if halfspace.periodic:
        stiffness = halfspace.contact_modulus * width
    else:
        stiffness = abs(step.response.force)
    forces = float(abs(state.pressure).sum()) * state.cell_area
    error = forces * step.perimeter * halfspace.spacing**2 / (width**3 * stiffness)
    error *= _HEIGHT_FACTOR[halfspace.periodic]
    if step.control == "penetrations":
        error += _LOWEST_POINT * _second_differences(step.contact.heights)
    return error


def _second_differences(heights: np.ndarray) -> float:
    """Return the sum of second differences at the lowest point, zero at an edge."""
    i, j = divmod(int(heights.argmin()), heights.shape[1])
    around = heights[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2]
    if around.shape != (3, 3):
        return 0.0
    sides = around[[0, 2, 1, 1], [1, 1, 0, 2]]
    return float(sides.sum() - 4.0 * around[1, 1])


def _cell_compliance(step: RelaxedContact) -> float:
    """Return the shift of the height by the images of a cell per force (Å^2/eV)."""
    modulus = step.halfspace.contact_modulus
    return _SUM_OF_INVERSES / (math.pi * modulus * step.cell_side)


def _cell_shift(step: RelaxedContact) -> float:
    """Return the shift of the height by the images of a cell (Å)."""
    state, side = step.state, step.cell_side
    if side == math.inf:
        return 0.0
    x, y = step.positions
    moment = state.pressure.sum(axis=1) @ x**2 + state.pressure.sum(axis=0) @ y**2
    forces = state.normal_force * _SUM_OF_INVERSES / side
    forces -= moment * state.cell_area * _SUM_OF_CUBES / (4.0 * side**3)
    return abs(float(forces)) / (math.pi * step.halfspace.contact_modulus)


def _cell_area(step: RelaxedContact) -> float:
    """Return the area that the images of a periodic cell take (Å^2)."""
    side = step.cell_side
    if side == math.inf:
        return 0.0
    radius = step.atoms.calc.parameters["indenter"].radius
    curvature = _SUM_OF_CUBES * abs(step.state.normal_force) / (2.0 * math.pi * side**3)
    part = 2.0 / 3.0 * radius * curvature / step.halfspace.contact_modulus
    error = part * step.state.contact_area
    return error + grid_error(step.perimeter, step.state.cell_area, extrapolated=True)
