r"""Active-set solver for the contact of a hard wall with the half space.

Find the pressure :math:`p` on the window and the height :math:`Z` of the indenter with

.. math:: g = Z + h + G p \ge 0, \qquad p \ge 0, \qquad g p = 0,

where :math:`Z`, the load :math:`a_0^2 \sum p`, or stiffness and end of a spring are
given, see `linear_support`. With a hardness :math:`H` of the wall, :math:`p \le H`, and
:math:`g \le 0` where :math:`p = H`. The solution is the minimum of the convex energy
:math:`\tfrac12 p \cdot G p + (Z + h) \cdot p` over these pressures.

1. Without a start, take the pressure of a full contact if nearly all of it is positive.
   Otherwise solve the same contact on every other atom, and so on, to a loose
   tolerance, and interpolate its pressure.
2. On a free half space, crop the window to the atoms that the rigid indenter overlaps:
   no other atom can touch.
3. Solve the contact on this window; see `defect_correction`.
4. If more atoms can touch at the resulting height, return to 2 with the result.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Generator, Iterator
from dataclasses import replace

import numpy as np

from ase_roughcontact._util.validation import finite, positive
from ase_roughcontact.contact import Contact
from ase_roughcontact.contact.state import without_rounding
from ase_roughcontact.contact.support import External
from ase_roughcontact.elasticity.circulant import covering_model
from ase_roughcontact.elasticity.lattice import Box, carried
from ase_roughcontact.solvers.coarsening import (
    can_coarsen,
    coarsen,
    crop,
    reachable,
    refine,
)
from ase_roughcontact.solvers.hard.defect_correction import defect_correction
from ase_roughcontact.solvers.hard.linear_support import LinearSupport
from ase_roughcontact.solvers.options import ActiveSetOptions
from ase_roughcontact.solvers.relaxation import (
    Relaxation,
    checked_start,
    counts_pairs,
    force_per_gap,
    gap_tolerance,
)
from ase_roughcontact.solvers.status import UNFINISHED, Status

# Largest violation at the end on coarse grids, in spacings.
_COARSE_VIOLATION = 0.07
# Smallest fraction of atoms with a positive pressure in a full contact for which this
# pressure is the start.
_MIN_POSITIVE_FRACTION = 0.8
# Largest fraction of the atoms of a window to which the window is cropped.
_MAX_CROPPED_FRACTION = 0.5

# Options if none are given.
_DEFAULTS = ActiveSetOptions()


@counts_pairs
def active_set(
    contact: Contact,
    *,
    height: float,
    external: External | None,
    start: np.ndarray | None,
    tolerance: float,
    options: ActiveSetOptions = _DEFAULTS,
) -> Generator[Relaxation, None, None]:
    """Relax the contact of a hard wall, step by step.

    Parameters
    ----------
    contact : Contact
        Contact with a `HardWall`.
    height : float
        Height of the indenter (length): fixed, or the initial one if there is a load.
    external : callable, optional
        Energy and force of load and springs on the indenter at a height; the force is
        constant or linear in the height. By default the height is fixed.
    start : ndarray, shape (n, m), optional
        Initial pressure, up to a constant if periodic. By default coarser grids give
        it.
    tolerance : float
        Largest remaining force, which would close the gap of an atom in contact, or
        remove an overlap. Gaps in contact and overlaps are also at most 1e-6 spacings
        (see `ActiveSetOptions`).
    options : ActiveSetOptions, optional
        Options of the algorithm.

    Yields
    ------
    Relaxation
        The start, and the state after each step. The last one is converged, or has a
        message. All of them carry the load up to rounding errors.

    Raises
    ------
    ValueError
        If the wall is not hard or is attractive, the start does not have the shape of
        the window, the load is negative, not linear in the height or larger than the
        hardness times the area, or no load reaches the height of a periodic surface.
    """
    _check(contact, height, external is None, tolerance)
    support = LinearSupport.of(contact, height, external)
    halfspace = contact.halfspace
    start = checked_start(contact, start)
    if start is not None:
        start = _nonnegative(contact, start)
    if support.load is not None:
        check_capacity(contact, support.load)
    least = force_per_gap(halfspace) * options.largest_gap * halfspace.spacing
    if support.load is not None and support.load <= least:
        # carried by the lowest atom, which coarser grids may not contain
        height, start = -float(contact.heights.min()), np.zeros(halfspace.shape)
        support = LinearSupport(height, support.load or None)
    gap = gap_tolerance(halfspace, tolerance, options.largest_gap)
    states = _solve(contact, support, start, gap, options)
    del start  # its memory is needed
    for state in states:
        energy = state.energy + contact.plastic_work
        if external is not None:
            if state.converged:
                force = halfspace.cell_area * float(state.pressure.sum())
                support.check(external, state.height, force)
            energy += external(state.height)[0]
        yield replace(state, energy=energy)


def _check(contact: Contact, height: float, fixed: bool, tolerance: float) -> None:
    """Raise `ValueError` if the solver does not support the contact."""
    wall = contact.wall
    if not wall.purely_hard:
        raise ValueError(f"ActiveSet is for the hard wall, got {wall}")
    finite(height=height)
    positive(tolerance=tolerance)
    if fixed:
        check_height(contact, height)


def check_height(contact: Contact, height: float) -> None:
    """Raise `ValueError` if all loads give full contact of a periodic surface."""
    elastic = not contact.wall.plastic
    periodic = contact.halfspace.periodic
    full_contact = 0.0 - float(contact.heights.mean())  # not -0
    if periodic and elastic and height <= full_contact:
        raise ValueError(
            f"height must be above {full_contact:g}, at which all of the periodic "
            f"surface is in contact under any load, got {height:g}: give a load instead"
        )


def check_capacity(contact: Contact, load: float) -> None:
    """Raise `ValueError` if a load is larger than the hardness times the area."""
    hardness, halfspace = contact.wall.hardness, contact.halfspace
    area = halfspace.cell_area * math.prod(halfspace.shape)
    if load > hardness * area:
        raise ValueError(
            f"the load {load:g} is larger than the hardness {hardness:g} times the "
            f"area {area:g} of the window, {hardness * area:g}: give a smaller load or "
            "a larger window"
        )


def _nonnegative(contact: Contact, start: np.ndarray) -> np.ndarray:
    """Return an initial pressure without rounding errors, zero out of contact."""
    if contact.halfspace.periodic:
        start = start - start.min()
    return without_rounding(start).clip(0.0)


def _solve(
    contact: Contact,
    support: LinearSupport,
    start: np.ndarray | None,
    tolerance: float,
    options: ActiveSetOptions,
) -> Iterator[Relaxation]:
    """Solve on a window, cropped where possible."""
    halfspace, load = contact.halfspace, support.load
    height = support.height  # a guess under a load
    if start is None and load is not None:
        start = _full_contact(contact, load)
    if start is None and can_coarsen(contact, options.coarsest):
        gap = 2.0 * _COARSE_VIOLATION * halfspace.spacing
        states = _solve(coarsen(contact), support, None, gap, options)
        coarse = deque(states, maxlen=1).pop()
        start = refine(coarse.pressure, halfspace.shape)
        if load is not None or support.compliance:
            height = coarse.height - gap
        del coarse  # its memory is needed
    elif start is not None:
        height += support.compliance * halfspace.cell_area * float(start.sum())
    can_crop = not (halfspace.periodic or halfspace.solid.bulges)
    box = window = Box((0, 0), halfspace.shape)
    if start is not None and can_crop:
        box = reachable(contact, height, start)
        capacity = contact.wall.hardness * box.size * halfspace.cell_area
        carries = load is None or load <= capacity
        box = _worthwhile(box, window) if carries else window
    while True:
        part = None if start is None else start[box.slices]
        states = defect_correction(
            crop(contact, box), support, part, tolerance, options
        )
        del part, start  # their memory is needed
        for state in states:
            needed = box
            if state.converged and can_crop:
                needed = box.union(reachable(contact, state.height))
            pressure = state.pressure
            if box != window:
                pressure = carried(pressure, box, window)
            status = state.status
            if state.converged and needed != box:
                status = Status(UNFINISHED)
            yield replace(state, pressure=pressure, status=status)
        if needed == box:
            return
        start, box = pressure, _worthwhile(needed, window)  # a larger box


def _full_contact(contact: Contact, load: float) -> np.ndarray | None:
    """Return the pressure of a full contact without tensions.

    Return None if too few atoms would be in elastic contact, or the load is too small
    to close all gaps.
    """
    halfspace, heights = contact.halfspace, contact.heights
    mean = load / (halfspace.cell_area * heights.size)
    depth = mean * halfspace.self_compliance * max(heights.shape)
    if depth < np.ptp(heights):
        return None
    model = covering_model(halfspace, Box((0, 0), heights.shape))
    uneven = model.stiffness(heights - heights.mean()) / model.self_compliance
    pressure = (mean - uneven).astype(float)
    elastic = (pressure > 0.0) & (pressure <= contact.wall.hardness)
    full = np.count_nonzero(elastic) >= _MIN_POSITIVE_FRACTION * pressure.size
    return pressure.clip(0.0) if full else None


def _worthwhile(box: Box, window: Box) -> Box:
    """Return a box if it is small enough to crop the window to it, or the window."""
    return box if box.size <= _MAX_CROPPED_FRACTION * window.size else window
