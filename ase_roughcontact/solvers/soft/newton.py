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

# Residual pressure at which coarse grids stop, in contact moduli, and their steps.
_COARSE_RESIDUAL, _COARSE_STEPS = 0.1, 300
# Under a hard wall, the reaction is updated when the largest force is that of the first
# violation of the constraint, in spacings, and then of the last one, times this factor.
_FIRST_VIOLATION, _REACTION_FORCING = 0.03, 3.0
# Number of steps without progress after which the solver stops.
_PATIENCE = 5
# Interval of steps at which slow progress is checked, and the smallest decrease of the
# energy in it, in units of its rounding error, unless the largest force has halved.
_STAGNATION_STEPS, _STAGNATION_FALL = 50, 1e8

#: Kinds of a status without a further step.
NO_DESCENT = StatusKind(
    "stalled at a force of {force:.2g}{force_unit}: no step lowers the energy"
)
NOT_HELD = StatusKind(
    "stalled at a force of {force:.2g}{force_unit}: nothing holds the indenter",
    "press it down, or fix its height",
)
ROUNDING = StatusKind(
    "stalled at a force of {force:.2g}{force_unit}: rounding errors hide any further "
    "decrease of the energy",
    "allow a larger force",
)
TOO_SLOW = StatusKind(
    "stalled at a force of {force:.2g}{force_unit}: the energy decreases too slowly to "
    "matter",
    "allow a larger force",
)
NOT_FINITE = StatusKind(
    "stalled at a force of {force:.2g}{force_unit}: energy or pressure of the wall are "
    "not finite"
)
OVERLAPS = StatusKind(
    "stalled: updates of the reaction do not decrease overlaps with the hard wall"
)
# Number of updates of the reaction that must reduce the violation to this part.
_UPDATES, _LEAST_PROGRESS = 30, 0.99
# An update that leaves more than this part of the violation makes the wall stiffer, by
# this factor: near an instability, the minimum is one of the augmented Lagrangian, and
# updates converge, only if it is stiff enough.
_SLOW_UPDATE, _STIFFER = 0.7, 3.0

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
        Contact with any wall but the hard one.
    height : float
        Height of the indenter (length): fixed, or the initial one if there is a load.
    external : callable, optional
        Energy and force, positive upward, of load and springs on the indenter at a
        height. By default the height is fixed.
    start : ndarray, shape (n, m), optional
        Initial pressure. By default it comes from coarser grids, and with a load the
        initial height, too; likewise if the start is too far from the load (see
        `NewtonKrylovOptions`).
    tolerance : float
        Largest force on an atom, and on the indenter unless its height is fixed, at
        which to stop.
    options : NewtonKrylovOptions, optional
        Options of the algorithm.

    Yields
    ------
    Relaxation
        The start, and the state after each step. The last one is converged, or has a
        message with the reason why there is no further step. The energy never rises,
        except with `invertible` walls, and that of the augmented Lagrangian by an
        update of the reaction of a hard wall.

    Raises
    ------
    ValueError
        If the wall is hard without attraction, the start does not have the shape of the
        window, a number is not finite, or no load reaches the height of a periodic
        surface with a hard wall.
    """
    if contact.interaction.purely_hard:
        raise ValueError("a hard wall has no gradient: relax it with ActiveSet")
    finite(height=height)
    positive(tolerance=tolerance)
    if contact.interaction.hard and external is None:
        check_height(contact, height)
    start = checked_start(contact, start)
    energy = ContactEnergy.of(contact, Support.of(external))
    state = None if start is None else EnergyState(energy, start, height)
    if state is None or _is_far(state, options):
        state = _cold_start(energy, height, options)
    if contact.interaction.hard:
        state = state.again(energy.with_reaction(state))
    states = _relax(state, tolerance, options)
    del state  # its arrays may be large
    yield from states


def default_relaxer(wall: Interaction) -> SolverRelaxer:
    """Return `active_set` for a hard wall without attraction, else `newton_krylov`."""
    return SolverRelaxer(active_set if wall.purely_hard else newton_krylov)


def _is_far(state: EnergyState, options: NewtonKrylovOptions) -> bool:
    """Return whether coarser grids are a better start, since the load differs much."""
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
        states = islice(_relax(state, tolerance, options), _COARSE_STEPS)
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
        Largest force that may be left before the next update; the tolerance of the
        result before the last one, and always for a soft wall.
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
        if self._violations and violation > _SLOW_UPDATE * self._violations[-1]:
            energy = replace(energy, stiffness=_STIFFER * energy.stiffness)
        self._violations.append(violation)
        if self.target == self._tolerance and violation <= self._gap:
            return None
        self._aim(violation if violation > self._gap else 0.0)
        return state.again(energy)

    @property
    def stuck(self) -> bool:
        """Whether the last updates have not decreased the violation."""
        late, early = self._violations[-_UPDATES:], self._violations[:-_UPDATES]
        return bool(early) and min(late) >= _LEAST_PROGRESS * min(early)

    def _aim(self, violation: float) -> None:
        self.target = max(self._tolerance, self._forcing * violation)


class _Progress:
    """The best state so far, and whether the steps still make progress.

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
        if self._idle > _PATIENCE:
            self.obstacle = ROUNDING
        self._steps += 1
        if self._steps % _STAGNATION_STEPS == 0:
            energy, error = self._checkpoint
            self._checkpoint = new.energy, new.error
            fall = energy - new.energy
            slow = fall < _STAGNATION_FALL * new.rounding
            if slow and new.error > 0.5 * error:
                rounded = fall <= _STAGNATION_STEPS * new.rounding
                self.obstacle = ROUNDING if rounded else TOO_SLOW
