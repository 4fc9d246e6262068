r"""Paths in time: contacts of viscoelastic solids, in time steps of controlled error.

Between two states the pressure is taken as linear in time. The error that its curvature
leaves in the pressures :math:`q_k` that the surface remembers (see `contact.creep`) is

.. math:: \epsilon = \frac{\sum_k J_k\, \kappa(\Delta t/\theta_k)\, n_k\,
          \Delta t^2 \sum_i |\ddot p_i|}{\max_t \sum_i |p_i|}, \qquad
          \kappa(x) = \frac{x}{12 + 2 x^2},

with the second derivative from the rates of this step and of the last one: it includes
atoms that open or close between them. Where a part of the schedule begins, the rate in
the first half of the step stands for the last one, and the first step is as long as the
shortest time of the solid. The errors of successive steps add up while the pressures
bend and the surface remembers,

.. math:: n_k = \max\left[1, \tfrac14 \min\left(\frac{\theta_k}{\Delta t},
          \frac{\sum_i |\dot p_i|}{\Delta t \sum_i |\ddot p_i|}\right)\right] .

As :math:`\epsilon` vanishes in steps that are much longer than the times of the series,
the `time_balance` of the energies has an error, too: it finds contacts that jump within
such a step. It is relative to the largest work or dissipated energy of the path. At the
start of a path the largest pressures and energies are taken from one step from rest to
the largest target, which is relaxed for this estimate.

A step of a larger error is repeated at half the duration, and so is one in which the
pressures change much. Durations are the duration of a part of the schedule divided by
powers of two, so that half spaces of few compliances are needed. The solver leaves a
tenth of the tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.contact import State
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.contact.creep import (
    PRESSURE_RATE,
    dissipated_energy,
    interpolation_error,
)
from ase_roughcontact.elasticity.lattice import carried
from ase_roughcontact.path_kinds.time.balance import energy_balance, work_between
from ase_roughcontact.path_kinds.time.record import TimeStep
from ase_roughcontact.path_kinds.time.specification import TimeSpecification
from ase_roughcontact.paths.path_steps import PathStep, PathSteps
from ase_roughcontact.paths.restart import Restart
from ase_roughcontact.paths.schedule import Part
from ase_roughcontact.paths.schedule_steps import (
    MAX_LEVEL,
    SchedulePosition,
    changes_of_schedule,
)
from ase_roughcontact.stepping.relaxed import RelaxedStep

# Smallest power of two by which the duration of a part is divided.
_MIN_LEVEL = 3
# Smallest number of steps in a cycle of an oscillation.
_MIN_CYCLE_STEPS = 32
# Largest change of the pressures in a step, relative to their largest sum, so that
# force and area are resolved where they change faster than the solid creeps.
_MAX_PRESSURE_CHANGE = 0.1
# Largest power of two by which a part is divided for this change: the contact may jump.
_MAX_CHANGE_LEVEL = 16
# Error that the solver of a step may leave, relative to the tolerance.
_SOLVER_ERROR = 0.1
# Largest creep compliance over a step in which the solid hardly creeps.
_MAX_INSTANTANEOUS_COMPLIANCE = 1.1
# Largest part of a tension that is not carried by a contact that is not lost.
_MAX_UNCARRIED_PART = 0.1


@dataclass(frozen=True)
class TimePosition(SchedulePosition):
    """Position of the end of a time step in its path.

    Attributes
    ----------
    elapsed : float
        Duration of the last step (time).
    pressure : float
        Largest sum of the magnitudes of the pressures so far (pressure).
    energy : float
        Largest work or dissipated energy so far, or estimate of it (energy).
    work, dissipated : float
        Work on the indenter and dissipated energy so far (energy).
    """

    elapsed: float = 0.0
    pressure: float = 0.0
    energy: float = 0.0
    work: float = 0.0
    dissipated: float = 0.0


@dataclass
class TimeSteps(PathSteps):
    """Time steps with durations that follow from an estimate of their errors.

    These are the first state, and the states at the end of each time step.

    Parameters
    ----------
    stepper : Stepper
    given : TimeSpecification
        Schedule and tolerance.
    """

    kind = TimeStep
    position = TimePosition
    given: TimeSpecification

    def __post_init__(self) -> None:
        """Check that the solid creeps, and let the solver leave less than the steps."""
        solid = self.stepper.problem.solid
        if solid.creep is None:
            raise ValueError(
                f"a path in time needs a Viscoelastic solid, got {solid!r}"
            )
        self.creep = solid.creep
        self.stepper = self.stepper.limited(_SOLVER_ERROR * self.given.tolerance)

    @property
    def specification(self) -> dict[str, Any]:
        """Schedule and tolerance; see `PathSteps`."""
        return {
            "schedule": self.given.schedule.todict(),
            "tolerance": self.given.tolerance,
        }

    def differences(self, done: Restart) -> list[str]:
        """Return the differences of the finished steps; see `PathSteps`."""
        old = {name: done.path[name] for name in self.specification}
        count = done.steps[-1].position["part"] + 1
        return changes_of_schedule(old, self.specification, count)

    def start(self, state: State) -> PathStep:
        """Return the start of the path, with estimated scales; see `PathSteps`."""
        return PathStep(None, state, {}, self._first_position(state))

    def steps(
        self, last: PathStep, record: type[Any]
    ) -> Iterator[tuple[PathStep, RelaxedStep]]:
        """Yield the states after the last one that is done; see `PathSteps`."""
        at = last
        if at.record is None:
            at, left = self._sudden(at, record, self.given.schedule.first, 0.0)
            yield at, left
        for number, (begin, first, part) in enumerate(
            self.given.schedule.timed_parts()
        ):
            if number < at.position.part:
                continue
            if number > at.position.part:
                level = self._first_level(part) if part.duration else 0
                position = at.position.in_part(number, level)
                state = at.state.keeping(**{PRESSURE_RATE: None})
                at = replace(at, position=position, state=state)
                if part.duration == 0.0:
                    at = replace(at, position=replace(position, done=1))
                    at, left = self._sudden(at, record, part.end, begin)
                    yield at, left
            if part.duration > 0.0:
                for new, left in self._part(at, record, begin, first, part):
                    at = new
                    yield at, left

    def _part(
        self, at: PathStep, record: type[Any], begin: float, first: float, part: Part
    ) -> Iterator[tuple[PathStep, RelaxedStep]]:
        """Yield the remaining states of a part of the schedule."""
        least = _least_level(part)
        position = replace(at.position, level=max(at.position.level, least))
        while not position.ended:
            position = position.grown(least)
            elapsed = part.duration / 2**position.level
            fraction = position.fractions[1]
            target = part.target(first, fraction)
            moment = begin + fraction * part.duration
            state, between = at.state, 0.5 * (elapsed + position.elapsed)
            if PRESSURE_RATE not in state.history:
                between = 0.25 * elapsed
                half = part.target(first, fraction - 0.5 / 2**position.level)
                rate = self._rate_at_first(state, half, moment, elapsed)
                state = state.keeping(**{PRESSURE_RATE: rate})
            relaxed, result, unbalanced = self._step(
                replace(at, state=state), record, target, moment, elapsed
            )
            rate = _rate(state, relaxed.state, elapsed)
            largest = max(position.pressure, _sum_of(relaxed.state.pressure))
            error = self._error(relaxed.state, rate, elapsed, between)
            error = max(_part_of(error, largest), unbalanced)
            change = 0.0
            if state.pressure.any():
                change = _part_of(elapsed * _sum_of(rate), largest)
            coarse = (
                change > _MAX_PRESSURE_CHANGE and position.level < _MAX_CHANGE_LEVEL
            )
            if (error > self.given.tolerance or coarse) and position.level < MAX_LEVEL:
                position = position.halved()
                continue
            self._check_held(target, result)
            small = change < 0.5 * _MAX_PRESSURE_CHANGE
            position = position.advanced(error, self.given.tolerance)
            may_grow = position.may_grow and small
            position = replace(position, may_grow=may_grow, elapsed=elapsed)
            left = self.stepper.commit(relaxed, **{PRESSURE_RATE: rate})
            at = self._accepted(position, at.record, target, left, result)
            position = at.position
            yield at, left

    def _sudden(
        self, at: PathStep, record: type[Any], target: float, time: float
    ) -> tuple[PathStep, RelaxedStep]:
        """Return the state after a sudden change of the target."""
        relaxed, result, _ = self._step(at, record, target, time, 0.0)
        self._check_held(target, result)
        left = self.stepper.commit(relaxed)
        return self._accepted(at.position, at.record, target, left, result), left

    def _accepted(
        self,
        position: TimePosition,
        last: TimeStep | None,
        target: float,
        left: RelaxedStep,
        result: TimeStep,
    ) -> PathStep:
        """Return a step that is kept, with its position."""
        work = position.work + (work_between(last, result) if last else 0.0)
        dissipated = position.dissipated + result.dissipated_energy
        position = replace(
            position,
            pressure=max(position.pressure, _sum_of(left.state.pressure)),
            work=work,
            dissipated=dissipated,
            energy=max(position.energy, abs(work), dissipated),
        )
        return PathStep(result, left.state, {"target": target}, position)

    def _check_held(self, target: float, step: TimeStep) -> None:
        """Raise `RuntimeError` if the surface does not hold the indenter at a load."""
        lost = step.normal_force - target > _MAX_UNCARRIED_PART * abs(target)
        if self.stepper.control != LOAD or step.converged or not lost:
            return
        raise RuntimeError(
            f"the contact is lost at the time {step.time:g}: it holds no tension of "
            f"{-target:g} eV/Å ({-target / UNITS['nN']:g} nN). The steps before are "
            "kept; end the loads there, or give heights or the base of a cantilever"
        )

    def _step(
        self,
        at: PathStep,
        record: type[Any],
        target: float,
        time: float,
        elapsed: float,
    ) -> tuple[RelaxedStep, TimeStep, float]:
        """Return a step, its result with energies, and the error of their balance.

        Energy that is missing although the solid hardly creeps in so short a step, and
        the work is known, was lost in an instability, and is no error.
        """
        relaxed = self.stepper.relax(
            at.state, target, number=at.number + 1, moment=time, elapsed=elapsed
        )
        result = record.of(relaxed)
        if at.record is None:
            return relaxed, result, 0.0
        if elapsed:
            energy = dissipated_energy(at.state, relaxed.state, self.creep, elapsed)
            energy *= relaxed.halfspace.cell_area
            result = replace(result, dissipated_energy=energy)
        missing, uncertainty = energy_balance(
            self.stepper, (at.target["target"], at.record), (target, result)
        )
        error = _energy_error(at.position, at.record, result, missing)
        unexplained = missing > uncertainty and error > self.given.tolerance
        lost = missing if unexplained else 0.0
        instantaneous = self.creep.compliance(elapsed) < _MAX_INSTANTANEOUS_COMPLIANCE
        known = instantaneous and uncertainty < self.given.tolerance * lost
        error = 0.0 if known else error
        return relaxed, replace(result, lost_energy=lost), error

    def _rate_at_first(
        self, state: State, target: float, moment: float, elapsed: float
    ) -> np.ndarray:
        """Return the rate in the first half of a step, which is relaxed.

        It stands for the rate of a last step where a part of the schedule begins.

        Parameters
        ----------
        state : State
            State at the beginning of the step.
        target : float
            Target after half of the step.
        moment, elapsed : float
            Time at the end of the step, and its duration.
        """
        half = 0.5 * elapsed
        relaxed = self.stepper.relax(state, target, moment=moment - half, elapsed=half)
        rate = _rate(state, relaxed.state, half)
        return carried(rate, relaxed.state.window, state.window)

    def _error(
        self, state: State, rate: np.ndarray, elapsed: float, between: float
    ) -> float:
        """Return the estimated error of the pressures of a step.

        Parameters
        ----------
        state : State
            Relaxed state, with the last rate.
        rate : ndarray, shape (n, m)
            Rate of the pressure in the step.
        elapsed, between : float
            Duration of the step, and time between both rates.
        """
        curvature = _sum_of(rate - state.history[PRESSURE_RATE]) / between
        change = elapsed * _sum_of(rate)
        return interpolation_error(self.creep, elapsed, change, elapsed**2 * curvature)

    def _first_position(self, start: State) -> TimePosition:
        """Return the first position, with an estimate of pressures and energies.

        They are taken from one step from rest to the largest target, in the time in
        which the path gets there.
        """
        target, time = self.given.schedule.largest(self.stepper.control.deeper)
        position = TimePosition()
        with suppress(ValueError, RuntimeError, MemoryError):  # of the path itself
            relaxed = self.stepper.relax(start, target, moment=time, elapsed=time)
            position = replace(
                position,
                pressure=_sum_of(relaxed.fields.pressure),
                energy=abs(relaxed.fields.energy),
            )
        return position

    def _first_level(self, part: Part) -> int:
        """Return the power of two that divides a part into steps of the shortest time.

        That is, of the solid, or of the part if this is shorter.
        """
        flow = [1.0 / self.creep.flow] if self.creep.flow else []
        shortest = min([*self.creep.times, *flow])
        level = math.ceil(math.log2(max(part.duration / shortest, 1.0)))
        return min(max(level, _least_level(part)), MAX_LEVEL)


def _energy_error(
    at: TimePosition, last: TimeStep, step: TimeStep, missing: float
) -> float:
    """Return a missing energy relative to the largest energy of the path so far."""
    work = abs(at.work + work_between(last, step))
    scale = max(at.energy, work, at.dissipated + step.dissipated_energy)
    return _part_of(abs(missing), scale)


def _rate(before: State, after: State, elapsed: float) -> np.ndarray:
    """Return the rate of the pressure between two states, on the window of the last."""
    return (after.pressure - before.on(after.window).pressure) / elapsed


def _sum_of(values: np.ndarray) -> float:
    """Return the sum of magnitudes."""
    return float(abs(values).sum())


def _part_of(value: float, scale: float) -> float:
    """Return a value relative to a scale, which is zero only if the value is."""
    return value / scale if scale else 0.0


def _least_level(part: Part) -> int:
    """Return the smallest power of two by which a part is divided."""
    cycles = part.frequency * part.duration
    return max(_MIN_LEVEL, math.ceil(math.log2(max(_MIN_CYCLE_STEPS * cycles, 1.0))))
