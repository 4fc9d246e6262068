r"""Contact of a hard wall with the half space: pressures that only push.

Find the pressure :math:`p` on the window and the indenter's height :math:`Z` with

.. math:: g = Z + h + G p \ge 0, \qquad p \ge 0, \qquad g p = 0,

and :math:`Z` or the load :math:`a_0^2 \sum p` given: the minimum of the convex energy
:math:`p \cdot G p/2 + (Z + h) \cdot p` over :math:`p \ge 0`.

On a free half space the window is cut to the atoms that the rigid indenter overlaps,
since no other can touch. Without a start, the problem is solved on every other atom
first, and so on. How it is solved on one grid is told in `descent`.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ase_roughcontact._util.validation import finite, finite_array, positive
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.coarsening import (
    can_coarsen,
    coarsen,
    crop,
    reachable,
    refine,
    whole,
)
from ase_roughcontact.solvers.defect_correction import Step, descend
from ase_roughcontact.solvers.relaxation import External, Relaxation, without_rounding

# Largest gap in contact, in spacings: of a result, and on coarser grids.
_GAP = 1e-6
_COARSE_GAP = 0.03
# Largest part of a window for which another half space is made: making it costs about
# as much as all exact convolutions of a solution.
_WORTH = 0.5


@dataclass(frozen=True)
class OptimalityResiduals:
    """How well the conditions of a hard contact hold.

    Attributes
    ----------
    gap_in_contact : float
        Largest gap of an atom under pressure, either way (length).
    penetration : float
        Deepest overlap of an atom without pressure (length).
    tension : float
        Largest negative pressure (pressure).
    load_error : float
        Difference of normal force and load, zero without a load (force).
    """

    gap_in_contact: float
    penetration: float
    tension: float
    load_error: float


def optimality_residuals(
    contact: Contact, pressure: np.ndarray, height: float, load: float | None = None
) -> OptimalityResiduals:
    """Check a solution afresh, by one convolution on the whole window.

    Parameters
    ----------
    contact : Contact
        Its wall is taken for hard.
    pressure : ndarray, shape (n, m)
        On the window, its mean included (pressure).
    height : float
        Of the indenter (length).
    load : float, optional
        What the pressure should add up to (force).

    Returns
    -------
    OptimalityResiduals
    """
    halfspace = contact.halfspace
    gap = height + contact.heights - halfspace.displacement(pressure)
    touching = pressure > 0.0
    force = float(pressure.sum()) * halfspace.cell_area
    return OptimalityResiduals(
        gap_in_contact=float(abs(gap[touching]).max(initial=0.0)),
        penetration=abs(float(gap.min(where=~touching, initial=0.0))),
        tension=abs(float(pressure.min(initial=0.0))),
        load_error=0.0 if load is None else abs(force - load),
    )


def active_set(
    contact: Contact,
    *,
    height: float,
    external: External | None,
    start: np.ndarray | None,
    tolerance: float,
) -> Generator[Relaxation, None, None]:
    """Relax the contact of a hard wall, step by step.

    Parameters
    ----------
    contact : Contact
        With a `HardWall`.
    height : float
        Of the indenter (length): fixed, or where to start from if there is a load.
    external : callable, optional
        Energy and force of the load on the indenter at a height; the force must be
        the same at every height. By default the height is fixed.
    start : ndarray, shape (n, m), optional
        Pressure to start from, up to a mean if periodic. By default it comes from
        coarser grids.
    tolerance : float
        Largest force that is left: that which closes the gap of an atom in contact, or
        of one that overlaps. However large it is, no gap in contact and no overlap is
        left larger than 1e-6 spacings.

    Yields
    ------
    Relaxation
        The start, and the state after each outer step. The last one is converged, or
        has a message. The load is always carried, to rounding.

    Raises
    ------
    ValueError
        If the wall is not hard, the start does not fit, the load pulls or depends on
        the height, or the height of a periodic surface is one that no load reaches.
    """
    _check(contact, height, external, tolerance)
    halfspace = contact.halfspace
    start = None if start is None else _clean(contact, start)
    load = None if external is None else -external(height)[1]
    force_per_gap = halfspace.cell_area / halfspace.self_compliance
    if load is not None and load <= force_per_gap * _GAP * halfspace.spacing:
        # a touch of the lowest point, of which coarser grids know nothing
        height, start = contact.first_contact, np.zeros(halfspace.shape)
        load = load or None
    gap = min(tolerance / force_per_gap, _GAP * halfspace.spacing)
    for step in _solve(contact, height, load, start, gap):
        energy = step.elastic_energy
        if external is not None:
            _check_load(external, (height, step.height))
            energy += external(step.height)[0]
        yield Relaxation(
            pressure=step.pressure,
            height=step.height,
            energy=energy,
            error=step.violation * force_per_gap,
            converged=step.converged,
            message=step.message,
            pairs=step.work / math.prod(halfspace.grid),
        )


def _check(
    contact: Contact, height: float, external: External | None, tolerance: float
) -> None:
    """Raise `ValueError` if there is no solution, or none that is found here."""
    if not contact.interaction.hard:
        raise ValueError(f"ActiveSet is for the hard wall, got {contact.interaction}")
    finite(height=height)
    positive(tolerance=tolerance)
    if external is not None:
        reach = float(np.ptp(contact.heights)) + contact.halfspace.spacing
        first = contact.first_contact
        _check_load(external, (height, first - reach, first + reach))
    elif contact.halfspace.periodic and height <= -contact.heights.mean():
        raise ValueError(
            f"height must be above {-contact.heights.mean():g}, at which all of the "
            f"periodic surface is in contact whatever the load, got {height:g}: give a "
            "load instead"
        )


def _check_load(external: External, heights: tuple[float, ...]) -> None:
    """Raise `ValueError` unless the load is the same at all heights, and pushes."""
    loads = [-external(height)[1] for height in heights]
    if not all(math.isclose(load, loads[0], rel_tol=1e-9) for load in loads):
        told = ", ".join(
            f"{load:g} at height {height:g}"
            for load, height in zip(loads, heights, strict=True)
        )
        raise ValueError(
            f"ActiveSet can't honour a spring on the indenter: the load is {told}; "
            "give a constant load, or fix the height"
        )
    if not 0.0 <= loads[0] < math.inf:
        raise ValueError(
            "a hard wall carries no tension: load must be finite and >= 0, "
            f"got {loads[0]:g}"
        )


def _clean(contact: Contact, start: np.ndarray) -> np.ndarray:
    """Pressure to start from: none in the open, whatever its mean and rounding."""
    start = finite_array("start", start)
    if start.shape != contact.heights.shape:
        raise ValueError(
            f"start must have the shape {contact.heights.shape} of the window, "
            f"got {start.shape}"
        )
    if contact.halfspace.periodic:
        start = start - start.min()
    return without_rounding(start).clip(0.0)


def _solve(
    contact: Contact,
    height: float,
    load: float | None,
    start: np.ndarray | None,
    tolerance: float,
) -> Iterator[Step]:
    """Outer steps on a window, to a gap; `height` is a guess if there is a load."""
    work = 0.0
    if start is None and can_coarsen(contact):
        coarse, work = _coarse(contact, height, load)
        start = refine(coarse.pressure, contact.halfspace.shape)
        if load is not None:
            height = coarse.height - coarse.violation
    box = whole(contact)
    if start is not None and _can_crop(contact):
        box = _worthwhile(contact, reachable(contact, height, start))
    while True:
        needed = box
        part = crop(contact, box)
        pressure = None if start is None else start[box.slices]
        for step in descend(part, height, load, pressure, tolerance):
            if step.converged and _can_crop(contact):
                # at its height, more atoms might touch
                needed = box.union(reachable(contact, step.height))
            converged = step.converged and needed == box
            step = replace(step, converged=converged, work=step.work + work)
            step = _placed(step, box, contact.halfspace.shape)
            yield step
            work = 0.0
        if needed == box:
            return
        start, height, box = step.pressure, step.height, _worthwhile(contact, needed)


def _can_crop(contact: Contact) -> bool:
    """Whether a part of the window can be all that is looked at."""
    return not contact.halfspace.periodic


def _worthwhile(contact: Contact, box: Box) -> Box:
    """Return the box if it is worth a half space of its own, or the whole window."""
    small = box.size <= _WORTH * contact.heights.size
    return box if small else whole(contact)


def _coarse(contact: Contact, height: float, load: float | None) -> tuple[Step, float]:
    """Last step on every other atom, and the work of all."""
    coarse = coarsen(contact)
    steps = list(
        _solve(coarse, height, load, None, _COARSE_GAP * coarse.halfspace.spacing)
    )
    return steps[-1], sum(step.work for step in steps)


def _placed(step: Step, box: Box, shape: tuple[int, int]) -> Step:
    """Step on the whole window instead of a box of it."""
    if step.pressure.shape == shape:
        return step
    pressure = np.zeros(shape)
    pressure[box.slices] = step.pressure
    return replace(step, pressure=pressure, displacement=None)
