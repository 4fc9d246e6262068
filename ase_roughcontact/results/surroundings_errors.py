r"""Errors by the surroundings of a contact: images in a periodic cell, edges of a scan.

Images of the contact in a square cell of side L shift the height, and press the
surroundings down. The page "Estimated errors" of the guide has the equations.
"""

from __future__ import annotations

import math

from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.theory.counted_area import continuum_area

# Sum of 1/r over a square lattice with a uniform background.
_SUM_OF_INVERSES = 3.900265
# Sum of 1/r^3 over a square lattice.
_SUM_OF_CUBES = 9.033622
# Error of the area by the waves of a cell, in parts of the correction of a count.
_PART_OF_CORRECTION = 0.1
# Factor of the error of the area by the edges of a scan without a period: twice the
# error covers nine of ten differences to scans that are continued by reflection, of 64
# and 128 points, Hurst exponents 0.5 and 0.8, and areas of 0.5, 2 and 10 %.
_EDGE_FACTOR = 1.0 / 3.0
#: Largest diameter of an adhesive contact over the side of its periodic cell, at which
#: the errors were within twice the estimate: examples/benchmarks/answer_errors.py.
LARGEST_PART_OF_CELL = 0.85


def cell_compliance(step: RelaxedStep) -> float:
    r"""Return the shift of the height by the images of a cell per force (Å^2/eV).

    It is :math:`3.9003/(\pi E^* L)`, zero without images.
    """
    modulus = step.halfspace.contact_modulus
    return _SUM_OF_INVERSES / (math.pi * modulus * step.cell_side)


def cell_shift(step: RelaxedStep) -> float:
    r"""Return the shift of the height by the images of a cell (Å).

    .. math:: \frac{1}{\pi E^*} \left(\frac{3.9003\, N}{L}
              - \frac{9.0336\, M}{4 L^3}\right), \qquad M = a_0^2 \sum p\, r^2
    """
    fields, side = step.fields, step.cell_side
    if side == math.inf:
        return 0.0
    x, y = step.positions
    moment = fields.pressure.sum(axis=1) @ x**2 + fields.pressure.sum(axis=0) @ y**2
    forces = fields.normal_force * _SUM_OF_INVERSES / side
    forces -= moment * fields.cell_area * _SUM_OF_CUBES / (4.0 * side**3)
    return abs(float(forces)) / (math.pi * step.halfspace.contact_modulus)


def cell_area_error(step: RelaxedStep) -> float:
    r"""Return the error of the area by the images of a cell (Å^2).

    .. math:: \frac{\delta A}{A} = \frac{2}{3}\, \frac{9.0336\, R N}{2 \pi E^* L^3}

    plus a tenth of the correction of a counted area and half a point.
    """
    side = step.cell_side
    if side == math.inf:
        return 0.0
    force, radius = abs(step.fields.normal_force), step.problem.topography.apex_radius
    curvature = _SUM_OF_CUBES * force / (2.0 * math.pi * side**3)
    part = 2.0 / 3.0 * radius * curvature / step.halfspace.contact_modulus
    area, cell = step.fields.contact_area, step.fields.cell_area
    correction = area - continuum_area(area, step.perimeter, math.sqrt(cell))
    return part * area + _PART_OF_CORRECTION * correction + 0.5 * cell


def scan_edges_error(step: RelaxedStep) -> float:
    r"""Return the error of the area by the edges of a scan without a period (Å^2).

    It is pressed without a smooth surface of rms height s. With the perimeter
    :math:`S_d` of the contact there are about :math:`n = \pi S_d^2/(64 A)` patches in
    the cell of side L:

    .. math:: \delta A = \frac{\min(A, L^2 - A)}{3 \sqrt{n}}
              \min\left(1, \frac{\pi E^* s L}{N}\right)
    """
    halfspace, count = step.halfspace, step.fields.gap.size
    removed, force = step.problem.topography.rough.edge_change, step.fields.normal_force
    if not (removed and step.touches):
        return 0.0
    nominal, area = count * step.fields.cell_area, step.fields.contact_area
    part = math.pi * halfspace.contact_modulus * removed * math.sqrt(nominal)
    part = min(part / force, 1.0) if force > 0.0 else 1.0
    patches = max(math.pi * step.perimeter**2 / (64.0 * area), 1.0)
    return _EDGE_FACTOR * min(area, nominal - area) * part / math.sqrt(patches)
