r"""Time step of a contact with friction that depends on slip rate and state.

Two stages, each of the time :math:`\gamma \Delta t` with :math:`\gamma = 1 -
1/\sqrt{2}`, solve for the rates at :math:`\gamma \Delta t` and :math:`\Delta t`. The
rate is :math:`V_1` for the time :math:`(1 - \gamma) \Delta t`, and then :math:`V_2`: a
method of second order, which damps fast changes as the implicit Euler method does, and
after which the tractions fulfil the law. The state of friction is integrated exactly
for these rates. Rates and state at the end of a stage are solved for in turn.

The error of the slip follows from the change of the rates, with the rate at the start
of the step,

.. math:: e = \frac{\Delta t}{12} \left|\frac{V_2 - V_1}{1 - \gamma} -
          \frac{V_1 - V_0}{\gamma}\right| ,

and the error of the step is the change of friction by it, relative to the friction:
directly, and by the elastic force.

On a solid that creeps, tractions and pressures are taken as linear in time over each
stage from the start of the step. This is a contact with a more compliant solid, whose
past displaces the surface; see `contact.creep`. The error of it, relative to the
friction and to the pressure, follows from the bend between both stages, and is added.

References
----------
R. Alexander, SIAM J. Numer. Anal. 14, 1006 (1977), for the stages.
N. Lapusta et al., J. Geophys. Res. 105, 23765 (2000), for the state.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ase_roughcontact.contact.creep import (
    CreepLoad,
    dissipated_by,
    interpolation_error,
    stored_by_past,
)
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.interactions.rate_and_state import RateFriction
from ase_roughcontact.solvers.lateral.rate_slip import (
    RateProblem,
    RateSolution,
    solve_rates,
)
from ase_roughcontact.solvers.lateral.slip import Drive

#: Part of the step of a stage.
STAGE = 1.0 - math.sqrt(0.5)
# Error of the slip, relative to the second difference of the rates times the time.
_ERROR = 1.0 / 12.0
# Residual of the tractions, relative to the tolerance of the steps.
_RELATIVE_RESIDUAL = 3e-2
# Change of friction at which rates and state agree, relative to the tolerance.
_AGREEMENT = 3e-2
# Largest ratio of successive changes by which they are extrapolated.
_MAX_RATIO = 0.9
# Largest number of solutions in turn for rates and state.
_MAX_ALTERNATIONS = 12


@dataclass(frozen=True, eq=False)
class RateContact:
    """Contact with friction that depends on slip rate and state, at a time.

    Attributes
    ----------
    law : RateFriction
    pressure : ndarray, shape (n, m)
        Pressures; atoms without a positive one have no friction (pressure).
    tractions : ndarray, shape (2, n, m)
        Tractions (pressure).
    rates : ndarray, shape (2, n, m)
        Slip rates (length/time).
    history : mapping of str to ndarray of shape (n, m)
        Histories of the law.
    past : sequence of ndarray of shape (2, n, m)
        Tractions of the past, one for each term of the creep; see `CreepLoad`.
    """

    law: RateFriction
    pressure: np.ndarray
    tractions: np.ndarray
    rates: np.ndarray
    history: Mapping[str, np.ndarray]
    past: Sequence[np.ndarray] = ()

    def load_on(self, halfspace: LateralHalfSpace) -> CreepLoad:
        """Return tractions with their displacements: one FFT pair for each of them."""
        depth, *others = map(halfspace.displacement, (self.tractions, *self.past))
        return CreepLoad(self.tractions, depth, self.past, others)

    @property
    def friction(self) -> np.ndarray:
        """Bound of the law at the slip rates, without damping, shape (n, m)."""
        return self._friction(np.hypot(*self.rates), self.history)

    def aged(self, rates: np.ndarray, duration: float) -> dict[str, np.ndarray]:
        """Return the histories after a time at given rates, shape (2, n, m)."""
        return self.law.aged(self.history, np.hypot(*rates), duration)

    def _friction(
        self, rate: np.ndarray, history: Mapping[str, np.ndarray]
    ) -> np.ndarray:
        unknown = np.full(rate.shape, np.nan)
        pressure = np.maximum(self.pressure, 0.0)
        return self.law.bound(
            pressure, unknown, rate, math.nan, history, unknown, unknown
        )

    def change_of_friction(self, other: Mapping[str, np.ndarray]) -> np.ndarray:
        """Return the change of the friction by other histories, shape (n, m)."""
        return self._friction(np.hypot(*self.rates), other) - self.friction


@dataclass(frozen=True, eq=False)
class RateStep:
    """Contact after a time step.

    Attributes
    ----------
    contact : RateContact
        Contact at the end of the step.
    shift : ndarray, shape (2,)
        Displacement of the indenter by a spring or a given force (length).
    mean_force : ndarray, shape (2,)
        Mean of the sums of the tractions during the step (pressure).
    dissipated, crept : float
        Energies lost by slip and radiation, and in the solid that creeps (pressure
        length, summed over cells).
    load : CreepLoad
        Tractions at the end with their displacements.
    error : float
        Error of the step, relative to the friction; infinite if it has not converged.
    residual : float
        Residual of the displacements; see `RateSolution`.
    steps : int
        Steps of Newton's method.
    pairs : float
        FFT pairs of two components, normalised to pairs on the grid.
    """

    contact: RateContact
    shift: np.ndarray
    mean_force: np.ndarray
    dissipated: float
    crept: float
    load: CreepLoad
    error: float
    residual: float
    steps: int
    pairs: float


def elastic_energy(load: CreepLoad, creep: Creep | None) -> float:
    """Return the energy stored under a load (pressure length, summed over cells)."""
    energy = 0.5 * float((load.present * load.depth).sum())
    return energy + stored_by_past(load, creep) if creep else energy


def step_in_time(
    halfspace: LateralHalfSpace,
    start: RateContact,
    drive: Drive,
    duration: float,
    tolerance: float,
    pressures: tuple[np.ndarray, np.ndarray] | None = None,
    creep: Creep | None = None,
) -> RateStep:
    """Return a contact after a time step.

    Parameters
    ----------
    halfspace : LateralHalfSpace
        Lateral compliance of the surface; instantaneous, if it creeps.
    start : RateContact
        Contact at the start.
    drive : Drive
        Change of the load over the step, at a constant rate.
    duration : float
        Time.
    tolerance : float
        Largest error that is asked for; the solver leaves a small part of it.
    pressures : (ndarray, ndarray), each of shape (n, m), optional
        Pressures after `STAGE` of the duration and at the end; by default the pressure
        does not change.
    creep : Creep, optional
        Creep of the solid.

    Returns
    -------
    RateStep
    """
    before, time = halfspace.transformed, STAGE * duration
    middle, last = pressures or (start.pressure, start.pressure)
    load = start.load_on(halfspace)
    creeps = creep.over(time) if creep else None
    problem = RateProblem(
        halfspace,
        start.law,
        middle,
        start.history,
        load.total_depth - load.held_depth(creeps) + STAGE * drive.imposed,
        time,
        drive.support(STAGE, np.zeros(2)),
        creeps.compliance if creeps else 1.0,
    )
    guess = RateSolution(
        start.tractions + time / problem.self_compliance * start.rates,
        start.tractions,
        start.rates,
        np.zeros(2),
        0.0,
        0,
    )
    contact = replace(start, pressure=middle)
    first, _, agreed = _stage(contact, problem, guess, tolerance)
    rest = (1.0 - STAGE) * duration
    creeps = creep.over(duration) if creep else None
    problem = replace(
        problem,
        pressure=last,
        imposed=load.total_depth
        - load.held_depth(creeps)
        + drive.imposed
        - rest * first.rates,
        support=drive.support(1.0, np.zeros(2)),
        compliance=creeps.compliance if creeps else 1.0,
    )
    contact = replace(start, pressure=last, history=start.aged(first.rates, rest))
    guess = _extrapolated(start, first, time / problem.self_compliance)
    second, history, found = _stage(contact, problem, guess, tolerance)
    agreed = agreed and found
    end = load.after(creeps, second.tractions, halfspace.displacement(second.tractions))
    contact = replace(
        contact,
        tractions=second.tractions,
        rates=second.rates,
        history=history,
        past=end.past,
    )
    parts = (1.0 - STAGE) * first.tractions, STAGE * second.tractions
    lost = (parts[0] * first.rates + parts[1] * second.rates).sum()
    error = math.inf
    if agreed:
        error = _error(halfspace, start, contact, first, drive, duration)
        if creep:
            tractions = start.tractions, first.tractions, second.tractions
            error += _creep_error(creep, duration, tractions)
            error += _creep_error(creep, duration, (start.pressure, middle, last))
    return RateStep(
        contact,
        second.shift,
        (parts[0] + parts[1]).sum(axis=(1, 2)),
        duration * float(lost),
        dissipated_by(load, end, creep, duration) if creep else 0.0,
        end,
        error,
        max(first.residual, second.residual),
        first.steps + second.steps,
        (halfspace.transformed - before) / math.prod(halfspace.grid),
    )


def _creep_error(
    creep: Creep, duration: float, loads: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> float:
    """Return the error of loads taken as linear in time, relative to their sum."""
    start, middle, end = loads
    total = float(abs(end).sum())
    if not total:
        return 0.0
    bend = 2.0 * ((end - middle) / (1.0 - STAGE) - (middle - start) / STAGE)
    change, bent = float(abs(end - start).sum()), float(abs(bend).sum())
    return interpolation_error(creep, duration, change, bent) / total


def _extrapolated(
    start: RateContact, first: RateSolution, compliance: float
) -> RateSolution:
    """Return a guess for the end of a step from its start and its first stage."""
    tractions, rates = (
        old + (new - old) / STAGE
        for old, new in (
            (start.tractions, first.tractions),
            (start.rates, first.rates),
        )
    )
    # a slip rate along the traction, as the law has it
    along = (rates * tractions).sum(axis=0) > 0.0
    rates = np.where(along, rates, first.rates)
    trial = tractions + compliance * rates
    return replace(first, trial=trial, rates=rates, shift=first.shift / STAGE)


def _stage(
    contact: RateContact, problem: RateProblem, guess: RateSolution, tolerance: float
) -> tuple[RateSolution, dict[str, np.ndarray], bool]:
    """Return rates and state at the end of a stage, and whether they agree."""
    residual = _RELATIVE_RESIDUAL * tolerance
    history, last = contact.aged(guess.rates, problem.duration), np.zeros(())
    for _ in range(_MAX_ALTERNATIONS):
        guess = solve_rates(replace(problem, history=history), guess, residual)
        if not guess.residual <= residual:
            return guess, history, False
        found = contact.aged(guess.rates, problem.duration)
        at = replace(contact, history=history, rates=guess.rates)
        change = at.change_of_friction(found)
        if abs(change).sum() <= _AGREEMENT * tolerance * at.friction.sum():
            return guess, found, True
        further = 0.0
        if last.any():  # the changes are nearly a geometric series
            ratio = float((last * change).sum() / (last * last).sum())
            further = ratio / (1.0 - ratio) if 0.0 < ratio < _MAX_RATIO else 0.0
        last = np.zeros(()) if further else change
        history = {
            name: values + further * (values - history[name])
            for name, values in found.items()
        }
    return guess, history, False


def _error(
    halfspace: LateralHalfSpace,
    start: RateContact,
    end: RateContact,
    first: RateSolution,
    drive: Drive,
    duration: float,
) -> float:
    """Return the error of a step, relative to the friction."""
    # an atom that comes into contact had no slip rate
    touched = start.pressure > 0.0
    bend = (end.rates - first.rates) / (1.0 - STAGE)
    bend = bend - touched * (first.rates - start.rates) / STAGE
    slip = _ERROR * duration * np.hypot(*bend)
    friction = end.friction
    total = float(friction.sum())
    if not total:
        return 0.0 if not slip.any() else math.inf
    # the state after this slip, and the deflection by the friction
    perturbed = end.law.aged(end.history, slip / duration, duration)
    still = end.law.aged(end.history, np.zeros(slip.shape), duration)
    at = replace(end, history=still)
    by_state = float(abs(at.change_of_friction(perturbed)).sum()) / total
    along = np.stack([friction, np.zeros(friction.shape)])
    deflection = float((friction * halfspace.displacement(along)[0]).sum()) / total
    if drive.supports is not None and drive.supports[1].stiffness:
        deflection += total / drive.supports[1].stiffness
    return by_state + float((friction * slip).sum()) / (total * deflection)
