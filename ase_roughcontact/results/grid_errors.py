r"""Errors of a contact of the continuum by the grid on which it is calculated.

The page "Estimated errors" of the guide has the equations with measurements for
their factors. Symbols: :math:`\Delta x` is the spacing of the grid, A the area of the
contact, :math:`S_d` its perimeter along the lines of the grid, N the normal force and H
the hardness.
"""

from __future__ import annotations

import math

import numpy as np

from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.theory.counted_area import grid_error, open_sides
from ase_roughcontact.topography.lowest_point import lowest_point_error

# Factor of the error of the force on a free half space, measured on rough spheres by
# examples/benchmarks/grid_error.py.
_FREE_FORCE_FACTOR = 0.04
# Factor of the error of the force on a periodic half space, measured on rough flats.
_PERIODIC_FORCE_FACTOR = 0.006
# Factor of the error of the force by the compliance of long waves, measured on spheres
# and incompressible layers with thicknesses of 0.5 to 2 spacings.
_COMPLIANCE_FACTOR = 0.015
# Factor of the error of the force under edges between faces, such as of a pyramid,
# beside a smooth profile: 3.2 to 4.2 on pyramids with contacts of 30 to 100 points.
_EDGES_FACTOR = 4.0
# Factor of the error of the force where an attraction ends between two points: 0.10 to
# 0.17 on smooth spheres under Dugdale walls with zones of 6 to 22 spacings.
_ATTRACTION_FACTOR = 0.1
# Factor of the error of the height by a plastic shape, measured on rough spheres and
# flats after loading to 1 to 100 % of plastic contact.
_SHAPE_FACTOR = 0.005


def continuum_area_error(step: RelaxedStep) -> float:
    """Return the error of the area of the continuum by the grid (Å^2)."""
    if step.edge_area is not None:
        error = step.edge_area.error
    else:
        stiffness = step.contact.wall.stiffness_at_contact
        modulus = step.halfspace.contact_modulus
        compliance = modulus / stiffness if stiffness else math.inf
        error = grid_error(step.perimeter, step.fields.cell_area, compliance)
    return error + step.options.lost_slope * step.fields.contact_area


def height_error(step: RelaxedStep, compliance: float) -> float:
    r"""Return the error of the height under a load by the grid (Å).

    It is the error of the force at a given height times the compliance dZ/dN of the
    contact, and on a periodic half space `smooth_edge_force_error` times
    :math:`1/(E^* \sqrt{A})`; plus `shape_error`.

    Parameters
    ----------
    step : RelaxedStep
    compliance : float
        Compliance dZ/dN of the contact (Å^2/eV).

    Returns
    -------
    float
    """
    error, halfspace = edge_force_error(step) * compliance, step.halfspace
    if halfspace.periodic:
        area, _ = _loaded_area(step)
        compliance = 1.0 / (halfspace.contact_modulus * math.sqrt(area))
    return error + smooth_edge_force_error(step) * compliance + shape_error(step)


def smooth_edge_force_error(step: RelaxedStep) -> float:
    r"""Return the error of the force at a given height, of a smooth edge (eV/Å).

    .. math:: \delta N = \sum |p| a_0^2 \left[c\, \frac{S_d \Delta x^2}{A^{3/2}} s^2 f
              + 0.015 \left(\frac{\Delta x}{a}\right)^3
              \frac{E^*(1/a)}{E^*(\pi/\Delta x)}\right]

    with c = 0.04, the factor f of `profile_factor` and the exponent s of the stiffness
    of layers on a free half space of radius :math:`a = \sqrt{A/\pi}`; on a periodic one
    c = 0.006, s = f = 1, and there is no second term; four times as much under edges
    between faces of the indenter.
    """
    fields, halfspace, spacing = step.fields, step.halfspace, step.halfspace.spacing
    area, perimeter = _loaded_area(step)
    factor = _PERIODIC_FORCE_FACTOR if halfspace.periodic else _FREE_FORCE_FACTOR
    error = factor * perimeter * spacing**2 / area**1.5
    if not halfspace.periodic:
        radius, modulus = math.sqrt(area / math.pi), halfspace.solid.wave_modulus
        long = float(modulus(1.0 / radius))
        longer = float(modulus(0.5 / radius))
        short = float(modulus(math.pi / spacing))
        exponent = max(1.0 + math.log2(longer / long), 1.0)
        error *= profile_factor(step) * exponent**2
        error += _COMPLIANCE_FACTOR * (spacing / radius) ** 3 * long / short
    if step.problem.topography.has_edges:
        error *= _EDGES_FACTOR
    return error * fields.total_magnitude


def profile_factor(step: RelaxedStep) -> float:
    r"""Return the ratio of an error of the force to the error under a sphere.

    It is 1 under walls that are soft, attract or have a hardness, and else

    .. math:: \max\left(1, \frac{n + 1}{3}\right), \qquad
              n + 1 = \left(1 - \frac{N}{\delta\, dN/d\delta}\right)^{-1}
              \le \frac{A^{1/2}}{\Delta x}

    under a profile r^n at the penetration :math:`\delta` (I. N. Sneddon, Int. J. Eng.
    Sci. 3, 47 (1965)).
    """
    fields, wall = step.fields, step.contact.wall
    if not wall.purely_hard or wall.plastic:
        return 1.0
    depth = step.contact.first_contact - step.height
    finest = step.halfspace.spacing / math.sqrt(fields.contact_area)
    linear = abs(step.response.force) * depth
    if not linear > 0.0:  # the height of the first contact, or a contact above it
        return 1.0
    return max(1.0, 1.0 / (3.0 * max(1.0 - fields.normal_force / linear, finest)))


def edge_force_error(step: RelaxedStep) -> float:
    r"""Return the error of the force by corners and plastic edges (eV/Å).

    .. math:: \delta N = \frac{N}{2 A}\, \delta A_c + H\, \delta A_p

    with the errors of the area at corners of the indenter, :math:`\delta A_c`, and of
    plastic contact, :math:`\delta A_p`; plus `attraction_force_error`.
    """
    fields, edge = step.fields, step.edge_area
    error = attraction_force_error(step)
    if edge is not None:
        error += fields.normal_force * edge.corner_error / (2.0 * fields.contact_area)
        if edge.plastic_error:
            error += fields.hardness * edge.plastic_error
    return error


def attraction_force_error(step: RelaxedStep) -> float:
    r"""Return the error of the force where an attraction ends between points (eV/Å).

    .. math:: \delta N = 0.1 \left(S_d\, \Delta x^3\right)^{1/2} \Delta p_a

    with the largest difference :math:`\Delta p_a` of the attraction of neighbours.
    """
    wall, fields = step.contact.wall, step.fields
    if not wall.attractive or (step.touches and not wall.hard):
        return 0.0
    _, attraction = step.contact.evaluate_wall(np.maximum(fields.gap, 0.0))
    largest = max(abs(np.diff(attraction, axis=k)).max(initial=0.0) for k in (0, 1))
    _, perimeter = _loaded_area(step)
    points = perimeter / step.halfspace.spacing
    return _ATTRACTION_FACTOR * math.sqrt(points) * float(largest) * fields.cell_area


def shape_error(step: RelaxedStep) -> float:
    r"""Return the error of the height by a plastic shape from earlier steps (Å).

    .. math:: \delta Z = 0.005\, \frac{H S_f\, \Delta x}{E^* \sqrt{A_f}}

    with the area :math:`A_f` that has flowed and its perimeter :math:`S_f`.
    """
    fields, halfspace = step.fields, step.halfspace
    if fields.kept_depth is None or not fields.kept_depth.any():
        return 0.0
    flowed = fields.kept_depth > 0.0
    perimeter = halfspace.spacing * open_sides(flowed, halfspace.periodic).sum()
    width = math.sqrt(np.count_nonzero(flowed) * fields.cell_area)
    error = _SHAPE_FACTOR * fields.hardness * perimeter * halfspace.spacing
    return float(error) / (halfspace.contact_modulus * width)


def zero_error(step: RelaxedStep) -> float:
    """Return the error of the lowest point of the indenter (Å).

    It is the zero of the penetration; see `lowest_point_error`.
    """
    if not step.grid_model.is_continuum:
        return 0.0
    return lowest_point_error(step.contact.heights, step.halfspace.periodic)


def _loaded_area(step: RelaxedStep) -> tuple[float, float]:
    """Return area and perimeter of the contact, or of the attracted atoms without one.

    Units are Å^2 and Å.
    """
    if step.touches:
        return step.fields.contact_area, step.perimeter
    attracted, halfspace = step.fields.pressure < 0.0, step.halfspace
    sides = float(open_sides(attracted, halfspace.periodic).sum())
    area = float(np.count_nonzero(attracted)) * step.fields.cell_area
    return area, sides * halfspace.spacing
