r"""Errors of area, force and height that the relaxation of a step leaves.

With the changes :math:`\lambda = dg/dZ` and :math:`x = dp/dZ` of a relaxed contact by a
unit of height, the forces :math:`f_i` and gaps :math:`g_i` that the relaxation leaves
change the normal force at a fixed height to first order by

.. math:: \delta N = \sum_i f_i\,(1 - \lambda_i) + a_0^2 \sum_\text{touching} x_i\, g_i,

the second sum under hard walls only. The first order suffices if the magnitudes of
these terms, the magnitudes of the forces :math:`f_i`, and the residual of the
indenter's force balance are below 0.001 of the magnitudes of all forces of the wall.
Atoms that these forces and gaps could bring into contact or out of it are an error of
the area.

Otherwise the solver for the wall goes on from the state until the remaining forces are
a hundredth, and the errors are the differences to the solution. This is the case where
long waves have not relaxed: small forces on every atom, but of one sign on many. The
solver takes at most 200 steps, which the columns of iterations and FFT pairs leave out.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ase_roughcontact._util.kernels import max_abs, total, total_abs
from ase_roughcontact.contact import Contact, ContactState
from ase_roughcontact.solvers.relaxation import FORCE_ROUNDING, Run, force_per_gap
from ase_roughcontact.solvers.response import HeightResponse
from ase_roughcontact.solvers.soft.newton import default_relaxer

# Largest change of the force, relative to the forces of the wall, that is calculated to
# first order.
_MAX_FIRST_ORDER_CHANGE = 1e-3
# Remaining forces at which the solver stops, relative to the forces that remain in the
# state.
_REMAINING_PART = 0.01
# Largest number of steps of the solver.
_MAX_SOLVER_STEPS = 200
# Reason for unknown errors of constrained atoms.
_CONSTRAINED = "constraints hold atoms of the surface, which the solver would let go"
# Reason for unknown errors if the solver does not converge.
_NOT_CONVERGED = "the solver for the remaining forces has not converged"


class RelaxationErrors(NamedTuple):
    """Errors by the relaxation; NaN where they are not known.

    Attributes
    ----------
    area : float
        Error of the contact area (Å^2).
    force : float
        Error of the normal force; at a load, at the height that was reached (eV/Å).
    height : float
        Error of the height of a free indenter (Å).
    unknown : str
        Why the errors are not known; else empty.
    """

    area: float
    force: float
    height: float
    unknown: str = ""

    @classmethod
    def not_known(cls, reason: str) -> RelaxationErrors:
        """Return errors that are NaN, for a reason."""
        return cls(math.nan, math.nan, math.nan, reason)


def relaxation_errors(
    contact: Contact, run: Run, response: HeightResponse, gap_error: float
) -> RelaxationErrors:
    """Return the errors that a relaxation leaves.

    Parameters
    ----------
    contact : Contact
    run : Run
    response : HeightResponse
        The response of the state that was reached to a change of the height.
    gap_error : float
        Largest gap in contact with a hard wall, or overlap with it (Å).

    Returns
    -------
    RelaxationErrors
        NaN at an instability, if constraints hold atoms of the surface, and if the
        solver does not converge.
    """
    if run.constrained:
        return RelaxationErrors.not_known(_CONSTRAINED)
    fields, halfspace = run.fields, contact.halfspace
    of_wall, remaining = fields.total_magnitude, 0.0
    if fields.forces.any():
        remaining = total_abs(fields.forces)
    if not (of_wall or remaining):
        return RelaxationErrors(0.0, 0.0, 0.0)
    change, magnitude = _change_of_force(contact, fields, response)
    magnitude = max(magnitude, remaining)
    largest = max(run.max_force, force_per_gap(halfspace) * gap_error)
    rounding = FORCE_ROUNDING * halfspace.contact_modulus * fields.cell_area
    limit = _MAX_FIRST_ORDER_CHANGE * of_wall
    if largest > rounding and magnitude + run.unbalanced > limit:
        return _to_solution(contact, run, _REMAINING_PART * largest)
    force = abs(change) + FORCE_ROUNDING * of_wall
    compliance = 1.0 / abs(response.force) if response.force else math.inf
    moved = gap_error + (magnitude * compliance if magnitude else 0.0)
    area = area_of_force(fields, force) + _undecided_area(contact, fields, moved)
    return RelaxationErrors(area, force, (force + run.unbalanced) * compliance)


def area_of_force(fields: ContactState, force: float) -> float:
    """Return the area that carries a force, at most all of the contact (Å^2)."""
    area, pressure = fields.contact_area, fields.contact_pressure
    # the attraction of a wall may cancel its reaction
    return force / pressure if force < pressure * area else area


def _change_of_force(
    contact: Contact, fields: ContactState, response: HeightResponse
) -> tuple[float, float]:
    """Return the change of the force to first order, and the magnitudes of its terms.

    The latter are added (eV/Å).
    """
    change = magnitude = 0.0
    if np.isinf(response.force):  # full contact of a hard wall: no atom can open
        return change, magnitude
    if fields.forces.any():
        terms = 1.0 - response.gap  # displacement by a unit of height
        if fields.forces.shape != terms.shape:  # with the padding
            terms = contact.halfspace.grid_displacement(response.pressure)
        terms *= fields.forces
        change, magnitude = total(terms), total_abs(terms)
    if contact.wall.hard:
        touching = fields.contact
        terms = response.pressure[touching] * fields.gap[touching]
        change += fields.cell_area * total(terms)
        magnitude += fields.cell_area * total_abs(terms)
    return change, magnitude


def _undecided_area(contact: Contact, fields: ContactState, moved: float) -> float:
    """Return the area of atoms that could come into contact or out of it (Å^2).

    The remaining forces move them, and a distance changes their gaps as well.
    """
    (n, m), area = fields.gap.shape, fields.cell_area
    forces, compliance = fields.forces[:n, :m], contact.halfspace.self_compliance / area
    error = compliance * max_abs(forces) + moved
    if not error:
        return 0.0
    if contact.wall.hard:
        margin = area * fields.pressure
        margin += forces
        if contact.wall.attractive:
            margin -= area * contact.evaluate_wall(np.maximum(fields.gap, 0.0))[1]
        margin *= compliance
        margin -= fields.gap
    else:
        margin = fields.gap - contact.wall.contact_distance
    return area * float(np.count_nonzero(np.abs(margin, out=margin) <= error))


def _to_solution(contact: Contact, run: Run, tolerance: float) -> RelaxationErrors:
    """Return the differences to the state that the solver finds from here."""
    # the displacement of the pressure on the window, without forces on the padding
    start = replace(run.state, displacement=None)
    relaxer = default_relaxer(contact.wall)
    solved = relaxer(contact, start, run.support, tolerance, _MAX_SOLVER_STEPS)
    if not solved.converged:
        return RelaxationErrors.not_known(f"{_NOT_CONVERGED}: {solved.message}")
    return RelaxationErrors(
        area=abs(solved.fields.contact_area - run.fields.contact_area),
        force=abs(solved.fields.normal_force - run.fields.normal_force),
        height=abs(solved.state.height - run.state.height),
    )
