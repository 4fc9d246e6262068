"""Estimated errors of area, force, height and penetration of a relaxed step.

They add up from the relaxation, see `RelaxationErrors`, from the grid if the continuum
is asked for, and from the surroundings of the contact. The page "Estimated errors" of
the guide has the equations.
"""

from __future__ import annotations

import math
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact.contact.control import PENETRATION
from ase_roughcontact.results.grid_errors import (
    attraction_force_error,
    continuum_area_error,
    height_error,
    zero_error,
)
from ase_roughcontact.results.surroundings_errors import (
    LARGEST_PART_OF_CELL,
    cell_area_error,
    cell_compliance,
    cell_shift,
    scan_edges_error,
)
from ase_roughcontact.stepping.relaxation_errors import area_of_force
from ase_roughcontact.stepping.relaxed import RelaxedStep

# Reason for unknown errors of a contact that nearly touches its images.
_NEAR_IMAGES = (
    "an adhesive contact that nearly touches its images in the periodic cell may be in "
    "another state: give a larger shape"
)
# Reason for unknown errors of a state without a contact stiffness.
_INSTABILITY = (
    "the contact stiffness is not known, as at an instability, where the state is no "
    "minimum"
)
# Reason for unknown errors of a plastic flat that may carry any of many loads.
_FULL_CONTACT = (
    "at the height of full contact a periodic surface has the same height under all "
    "loads until it yields: give a load"
)


class Errors(NamedTuple):
    """Estimated errors of a result; NaN where they are not known.

    Attributes
    ----------
    area : float
        Error of the contact area (Å^2).
    force : float
        Error of the normal force (eV/Å).
    height : float
        Error of the height (Å).
    penetration : float
        Error of the penetration (Å).
    unknown : str
        Why some errors are not known; else empty.
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


# Errors of relaxed steps, for which several columns ask.
_errors_by_step: WeakKeyDictionary[RelaxedStep, Errors] = WeakKeyDictionary()


def errors_of(step: RelaxedStep) -> Errors:
    """Return the estimated errors of a step, with the errors by a scan.

    They are estimated once for each step.
    """
    if step not in _errors_by_step:
        errors, scan_errors = estimated_errors(step), step.options.scan_errors
        if scan_errors:
            errors = errors.plus(scan_errors(step))
        _errors_by_step[step] = errors
    return _errors_by_step[step]


def estimated_errors(step: RelaxedStep) -> Errors:
    """Return the estimated errors of area, force, height and penetration.

    Parameters
    ----------
    step : RelaxedStep

    Returns
    -------
    Errors
        Under a given load the error of the force is the residual of the force balance
        of the indenter; at a given height the error of the height is zero. The error of
        the area of a periodic cell is at most the cell. Errors of quantities that are
        not prescribed are NaN at an instability and at the height of full contact, and
        all errors where an adhesive contact nearly touches its images.
    """
    if not (step.touches or step.fields.attractive_atoms):
        return _errors_without_contact(step)
    attractive = step.contact.wall.attractive
    if attractive and step.part_of_cell > LARGEST_PART_OF_CELL:
        return Errors.not_known(_NEAR_IMAGES)
    if math.isnan(step.response.force):
        return _unknown_errors(step, _INSTABILITY)
    if step.relaxation.unknown:
        return _unknown_errors(step, step.relaxation.unknown)
    if step.run.support.fixed and _is_at_full_contact(step):
        return _unknown_errors(step, _FULL_CONTACT)
    stiffness = abs(step.response.force)
    # all atoms in contact may be in plastic contact
    compliance = 1.0 / stiffness if stiffness else math.inf
    area = cell_area_error(step) + step.relaxation.area + scan_edges_error(step)
    height = cell_shift(step)
    if step.grid_model.is_continuum:
        height += height_error(step, compliance)
        area += continuum_area_error(step)
        area += area_of_force(step.fields, attraction_force_error(step))
    penetration = zero_error(step)
    if not step.run.support.fixed:
        height += step.relaxation.height
        area = _within_cell(step, area)
        return Errors(area, step.run.unbalanced, height, height + penetration)
    if step.control == PENETRATION:  # the height has the error of the zero
        height, penetration = height + penetration, 0.0
    force = _force_change(height, compliance + cell_compliance(step))
    area = _within_cell(step, area + area_of_force(step.fields, force))
    return Errors(area, step.relaxation.force + force, 0.0, penetration)


def _errors_without_contact(step: RelaxedStep) -> Errors:
    """Return the errors of a step without an interaction."""
    errors = step.relaxation
    force = errors.force if step.run.support.fixed else step.run.unbalanced
    return Errors(errors.area, force, 0.0, _given_zero_error(step), errors.unknown)


def _unknown_errors(step: RelaxedStep, reason: str) -> Errors:
    """Return errors that are not known, except of quantities that are prescribed."""
    unknown = Errors.not_known(reason)
    if not step.run.support.fixed:
        return unknown._replace(force=step.run.unbalanced)
    return unknown._replace(height=0.0, penetration=_given_zero_error(step))


def _is_at_full_contact(step: RelaxedStep) -> bool:
    """Return whether the height is the one of full contact without yielding."""
    contact = step.contact
    if not (contact.halfspace.periodic and contact.wall.purely_hard):
        return False
    above = step.height + float(contact.heights.mean())
    return abs(above) <= LENGTH_ROUNDING * contact.halfspace.spacing


def _given_zero_error(step: RelaxedStep) -> float:
    """Return the error of a penetration that follows from a given height (Å)."""
    return 0.0 if step.control == PENETRATION else zero_error(step)


def _within_cell(step: RelaxedStep, area: float) -> float:
    """Return an error of the area, at most the area of a periodic cell (Å^2)."""
    if not step.halfspace.periodic:
        return area
    return min(area, step.fields.cell_area * step.fields.gap.size)


def _force_change(shift: float, compliance: float) -> float:
    """Return the change of the force by a shift of the height (eV/Å)."""
    if not shift:
        return 0.0
    return shift / compliance if compliance else math.inf
