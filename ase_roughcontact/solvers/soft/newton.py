r"""Newton-Krylov solver for soft walls, with or without attraction.

The unknowns are the elastic pressure :math:`q` on the window and the height :math:`Z`
of the indenter; see `energy` for the energy :math:`E(q, Z)` that is minimised.

1. Without a start, solve the same contact on every other atom, and so on, to a loose
   tolerance, and interpolate its pressure.
2. Calculate the opening :math:`G q` by a convolution and the forces on the atoms and
   the indenter from it. Stop if the largest one is below the tolerance.
3. Make a Newton step; see `newton_step`.
4. Under a repulsive wall, move the indenter alone if only its force exceeds the
   tolerance.
5. Repeat 3 and 4 until the forces are below the tolerance, then return to 2. If no
   step lowers the energy, return to 2 once from the best state.

References
----------
J. Nocedal, S. J. Wright, Numerical Optimization (2006), Ch. 7 (inexact Newton methods).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Generator, Iterator
from dataclasses import replace
from itertools import islice

import numpy as np

from ase_roughcontact._util.validation import finite, positive
from ase_roughcontact.contact import Contact
from ase_roughcontact.contact.support import External, Support
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.solvers.coarsening import can_coarsen, coarsen, refine
from ase_roughcontact.solvers.hard.active_set import active_set, check_height
from ase_roughcontact.solvers.options import NewtonKrylovOptions
from ase_roughcontact.solvers.relaxation import (
    Relaxation,
    SolverRelaxer,
    checked_start,
    counts_pairs,
    force_per_gap,
    gap_tolerance,
    indenter_stiffness,
    precision_advice,
)
from ase_roughcontact.solvers.soft.energy import ContactEnergy, EnergyState
from ase_roughcontact.solvers.soft.indenter_height import (
    balance_load,
    first_height,
    supports_indenter,
)
from ase_roughcontact.solvers.soft.newton_step import NewtonStepper
from ase_roughcontact.solvers.status import CONVERGED, UNFINISHED, Status, StatusKind

# Residual pressure at which coarse grids stop, in contact moduli.
_COARSE_RESIDUAL = 0.1
# Largest number of steps on a coarse grid.
_MAX_COARSE_STEPS = 300
# Violation of the constraint of a hard wall before the first update of the reaction, in
# spacings.
_FIRST_VIOLATION = 0.03
# Largest force at which the reaction is updated, in units of the force that removes the
# last violation.
_REACTION_FORCING = 3.0
# Number of steps without progress after which the solver stops.
_MAX_STALLED = 5
# Number of steps between two checks for slow progress.
_CHECKED_STEPS = 50
# Smallest decrease of the energy between two checks, in units of its rounding error,
# unless the largest force has halved.
_MIN_DECREASE = 1e8
# Number of updates of the reaction that must reduce the violation.
_CHECKED_UPDATES = 30
# Largest ratio of the violations after and before these updates.
_MAX_VIOLATION_RATIO = 0.99
# Ratio of the violations after and before an update, above which the stiffness D is
# increased. Near an instability, the augmented Lagrangian has a minimum, and updates
# converge, only if D is large enough.
_SLOW_UPDATE_RATIO = 0.7
# Factor by which D is increased.
_STIFFNESS_FACTOR = 3.0

#: The energy does not decrease along any step.
NO_DESCENT = StatusKind(
    "stalled at a force of {force:.2g}{force_unit}: no step lowers the energy"
)
#: Neither the wall nor a spring resists a free indenter.
NOT_HELD = StatusKind(
    "stalled at a force of {force:.2g}{force_unit}: nothing holds the indenter",
    "press it down, or fix its height",
)
#: The energy decreases less than its rounding errors.
ROUNDING = StatusKind(
    "stalled at a force of {force:.2g}{force_unit}: rounding errors hide any further "
    "decrease of the energy",
    "allow a larger force",
)
#: The energy decreases, but too slowly.
TOO_SLOW = StatusKind(
    "stalled at a force of {force:.2g}{force_unit}: the energy decreases too slowly to "
    "matter",
    "allow a larger force",
)
#: The wall returned values that are not finite.
NOT_FINITE = StatusKind(
    "stalled at a force of {force:.2g}{force_unit}: energy or pressure of the wall are "
    "not finite"
)
#: Updates of the reaction of a hard wall do not converge.
OVERLAPS = StatusKind(
    "stalled: updates of the reaction do not decrease overlaps with the hard wall"
)

# Options if none are given.
_DEFAULTS = NewtonKrylovOptions()


@counts_pairs
def newton_krylov(
    contact: Contact,
    *,
    height: float,
    external: External | None,
    start: np.ndarray | None,
    tolerance: float,
    options: NewtonKrylovOptions = _DEFAULTS,
) -> Generator[Relaxation, None, None]:
    """Relax the contact of a soft wall, step by step.

    Parameters
    ----------
    contact : Contact
        Contact with a soft wall, or a hard wall with attraction.
    height : float
        Height of the indenter (length): fixed, or the initial one if there is a load.
    external : callable, optional
        Energy and force, positive upward, of load and springs on the indenter at a
        height. By default the height is fixed.
    start : ndarray, shape (n, m), optional
        Initial pressure. By default coarser grids give the initial pressure, and under
        a load also the initial height; they also do if the start is too far from the
        load (see `NewtonKrylovOptions`).
    tolerance : float
        Largest force that may be left on an atom, and on the indenter unless its height
        is fixed (force).
    options : NewtonKrylovOptions, optional
        Options of the algorithm.

    Yields
    ------
    Relaxation
        The start, and the state after each step. The last one is converged, or has a
        message with the reason why there is no further step. The energy rises only with
        `invertible` walls, and by updates of the reaction of a hard wall.

    Raises
    ------
    ValueError
        If the wall is hard without attraction, the start does not have the shape of the
        window, a number is not finite, or no load reaches the height of a periodic
        surface with a hard wall.
    """
    if contact.wall.purely_hard:
        raise ValueError("a hard wall has no gradient: relax it with ActiveSet")
    finite(height=height)
    positive(tolerance=tolerance)
    if contact.wall.hard and external is None:
        check_height(contact, height)
    start = checked_start(contact, start)
    energy = ContactEnergy.of(contact, Support.of(external))
    state = None if start is None else EnergyState(energy, start, height)
    if state is None or _is_far(state, options):
        state = _cold_start(energy, height, options)
    if contact.wall.hard:
        state = state.again(energy.with_reaction(state))
    states = _relax(state, tolerance, options)
    del state  # frees memory
    yield from states


def default_relaxer(wall: Interaction) -> SolverRelaxer:
    """Return a relaxer by `active_set` or `newton_krylov`, depending on the wall."""
    return SolverRelaxer(active_set if wall.purely_hard else newton_krylov)


def _is_far(state: EnergyState, options: NewtonKrylovOptions) -> bool:
    """Return whether the load of a start is so wrong that coarser grids are better."""
    energy = state.function
    if energy.support.fixed:
        return False
    if energy.wall.attractive:
        distance = abs(state.load_residual) / indenter_stiffness(energy.contact)
        return distance > options.max_indenter_move * energy.contact.halfspace.spacing
    load = energy.external(state.height)[1]
    return abs(state.load_residual) > options.max_load_change * abs(load)


def _cold_start(
    energy: ContactEnergy, height: float, options: NewtonKrylovOptions
) -> EnergyState:
    """Return the state found on coarser grids."""
    shape = energy.contact.halfspace.shape
    pressure = np.zeros(shape)
    if can_coarsen(energy.contact, options.coarsest):
        coarse = ContactEnergy.of(coarsen(energy.contact), energy.support)
        state = _cold_start(coarse, height, options)
        tolerance = _COARSE_RESIDUAL * coarse.area
        tolerance *= coarse.contact.halfspace.contact_modulus
        states = islice(_relax(state, tolerance, options), _MAX_COARSE_STEPS)
        found = deque(states, maxlen=1).pop()
        height, pressure = found.height, refine(found.pressure, shape)
    elif not energy.support.fixed:
        height = first_height(energy, height)
    return EnergyState(energy, pressure, height)


def _relax(
    state: EnergyState, tolerance: float, options: NewtonKrylovOptions
) -> Iterator[Relaxation]:
    """Relax on one grid."""
    halfspace = state.function.contact.halfspace
    newton = NewtonStepper(halfspace, options)
    updates = _ReactionUpdates(state.function, tolerance, options)
    progress, restarted = _Progress(state), False
    while True:
        if state.error <= updates.target == tolerance and not state.exact:
            state = EnergyState(state.function, state.pressure, state.height)
            state = balance_load(state, tolerance)
            progress.keep(state)
        if state.error <= updates.target:
            updated = updates.updated(state)
            if updated is None or updates.stuck:
                yield _relaxation(state, OVERLAPS if updated else CONVERGED)
                return
            state, progress = updated, _Progress(updated)
            continue
        yield _relaxation(state)
        new = newton.step(state, tolerance)
        if new is not None:
            new = balance_load(new, tolerance)
            progress.add(state, new)
            state = new
        elif state.function.support.fixed or supports_indenter(state):
            progress.obstacle = NO_DESCENT
        else:
            progress.obstacle = NOT_HELD
        if progress.obstacle:
            function = replace(state.function, inverse=False)
            state = EnergyState(function, *progress.best)
            if restarted and not state.error <= tolerance:
                break
            newton.restart()
            progress, restarted = _Progress(state), True
    kind, advice = progress.obstacle, precision_advice(halfspace)
    if not math.isfinite(state.error):
        kind, advice = NOT_FINITE, ""
    yield _relaxation(state, kind, advice)


def _relaxation(
    state: EnergyState, kind: StatusKind = UNFINISHED, advice: str = ""
) -> Relaxation:
    status = Status(kind, {"force": state.error}, advice)
    return Relaxation(state.pressure, state.height, state.energy, state.error, status)


class _ReactionUpdates:
    """Updates of the reaction of a hard wall between Newton steps; see `energy`.

    Attributes
    ----------
    target : float
        Largest force at which the reaction is updated. It is the tolerance of the
        result for a soft wall, and before the last update.
    """

    def __init__(
        self, energy: ContactEnergy, tolerance: float, options: NewtonKrylovOptions
    ) -> None:
        halfspace, self._tolerance = energy.contact.halfspace, tolerance
        self._gap = gap_tolerance(halfspace, tolerance, options.largest_gap)
        self._forcing = _REACTION_FORCING * force_per_gap(halfspace)
        self._violations: list[float] = []
        self.target = tolerance
        if energy.reaction is not None:
            self._aim(_FIRST_VIOLATION * halfspace.spacing)

    def updated(self, state: EnergyState) -> EnergyState | None:
        """Return the state with an updated reaction; None if it was the solution."""
        energy, violation = state.function.updated(state)
        if self._violations and violation > _SLOW_UPDATE_RATIO * self._violations[-1]:
            energy = replace(energy, stiffness=_STIFFNESS_FACTOR * energy.stiffness)
        self._violations.append(violation)
        if self.target == self._tolerance and violation <= self._gap:
            return None
        self._aim(violation if violation > self._gap else 0.0)
        return state.again(energy)

    @property
    def stuck(self) -> bool:
        """Whether the last updates have not decreased the violation."""
        early = self._violations[:-_CHECKED_UPDATES]
        late = self._violations[-_CHECKED_UPDATES:]
        return bool(early) and min(late) >= _MAX_VIOLATION_RATIO * min(early)

    def _aim(self, violation: float) -> None:
        self.target = max(self._tolerance, self._forcing * violation)


class _Progress:
    """Best state so far, and a check that steps make progress.

    Attributes
    ----------
    best : (ndarray, float)
        Pressure and height of the state of the lowest energy, or of the smallest error
        among equal energies.
    obstacle : StatusKind or None
        Reason why there is no progress; None while there is.
    """

    def __init__(self, state: EnergyState) -> None:
        self.keep(state)
        self.obstacle: StatusKind | None = None
        self._checkpoint = state.energy, state.error
        self._steps = self._idle = 0

    def keep(self, state: EnergyState) -> None:
        """Keep a state as the best one."""
        self.best, self._error = (state.pressure, state.height), state.error

    def add(self, old: EnergyState, new: EnergyState) -> None:
        """Take a step into account."""
        lower = new.energy < old.energy - old.rounding
        better = lower or new.error < 0.9 * self._error
        self._idle = 0 if better else self._idle + 1
        if lower or new.error < self._error:
            self.keep(new)
        if self._idle > _MAX_STALLED:
            self.obstacle = ROUNDING
        self._steps += 1
        if self._steps % _CHECKED_STEPS == 0:
            energy, error = self._checkpoint
            self._checkpoint = new.energy, new.error
            fall = energy - new.energy
            slow = fall < _MIN_DECREASE * new.rounding
            if slow and new.error > 0.5 * error:
                rounded = fall <= _CHECKED_STEPS * new.rounding
                self.obstacle = ROUNDING if rounded else TOO_SLOW
