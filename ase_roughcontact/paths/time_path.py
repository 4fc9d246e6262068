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
start of a path the largest pressures and energies are those of one step from rest to
the largest target, which is relaxed for this estimate.

A step of a larger error is repeated at half the duration, and so is one in which the
pressures change much. Durations are those of a part of the schedule divided by powers
of two, so that half spaces of few compliances are needed. The solver leaves a tenth of
the tolerance.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np

from ase_roughcontact._util.identity import differences
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import positive
from ase_roughcontact.contact import State
from ase_roughcontact.contact.creep import PRESSURE_RATE, dissipated_energy
from ase_roughcontact.elasticity.lattice import carried
from ase_roughcontact.paths.path_records import TimeStep
from ase_roughcontact.paths.path_steps import DescribedSteps, LastStep, PathSteps
from ase_roughcontact.paths.relaxed import RelaxedStep
from ase_roughcontact.paths.schedule import Part, Schedule
from ase_roughcontact.paths.time_balance import energy_balance, work_between

# Powers of two by which the duration of a part is divided: at least, and at most. An
# oscillation has at least that many steps in a cycle.
_LEAST, _MOST = 3, 40
_STEPS_PER_CYCLE = 32
# Largest change of the pressures in a step, relative to their largest sum, so that
# force and area are resolved where they change faster than the solid creeps; and power
# of two beyond which parts are not divided for it, as the contact may jump.
_LARGEST_CHANGE, _FINEST = 0.1, 16
# Error that the solver of a step may leave, relative to the tolerance.
_SOLVER_PART = 0.1
# Creep compliance over a step below which the solid hardly creeps in it.
_INSTANTANEOUS = 1.1
# Class of results with which nothing is evaluated.
_RELAXED: Any = RelaxedStep
# Controls whose smallest target presses most.
_LOWERED = "heights", "bases"
# Part of the errors of successive steps that add up.
_ADDED = 0.25
# A contact is lost if it lacks more than this part of a tension.
_LOST_PART = 0.1
# A step is followed by one of twice its duration if its error is below this part of the
# tolerance: it grows eightfold.
_GROWTH = 0.1


@dataclass
class _Position:
    """Where the last time step of a path has ended.

    Attributes
    ----------
    part : int
        Part of the schedule.
    level, done : int
        Steps of the part that are done, in units of ``2**-level`` of its duration.
    may_grow : bool
        Whether the error of the last step allows a longer one.
    elapsed : float
        Duration of the last step (time).
    pressure : float
        Largest sum of the magnitudes of the pressures so far (pressure).
    energy : float
        Largest work or dissipated energy so far, or estimate of it (energy).
    work, dissipated : float
        Work on the indenter and dissipated energy so far (energy).
    """

    part: int = -1
    level: int = 0
    done: int = 0
    may_grow: bool = False
    elapsed: float = 0.0
    pressure: float = 0.0
    energy: float = 0.0
    work: float = 0.0
    dissipated: float = 0.0


@dataclass
class TimeSteps(PathSteps):
    """Time steps whose durations follow from an estimate of their errors.

    The first state, and those at the end of each time step.

    Parameters
    ----------
    stepper : Stepper
    schedule : Schedule
    tolerance : float
        See `time_path`.
    """

    kind = TimeStep
    schedule: Schedule
    tolerance: float = 1e-3
    position: _Position = field(default_factory=_Position)

    def __post_init__(self) -> None:
        """Check that the solid creeps."""
        positive(tolerance=self.tolerance)
        solid = self.stepper.problem.solid
        self._last: tuple[float, TimeStep] | None = None
        if solid.creep is None:
            raise ValueError(
                f"a path in time needs a Viscoelastic solid, got {solid!r}"
            )
        self.creep = solid.creep
        self.stepper.limit_error(_SOLVER_PART * self.tolerance)

    @property
    def target(self) -> float:
        """Target of the last step."""
        return self._last[0] if self._last else 0.0

    def differences(self, path: dict[str, Any], number: int) -> list[str]:
        """Return in what the description of a step differs; see `PathSteps`."""
        if "schedule" not in path:
            return ["its path is not one in time"]
        old, done = path["schedule"], path["position"]["part"] + 1
        new = self.schedule.todict()
        # the path may have been extended at its end
        old, new = ({**s, "parts": list(s["parts"])[:done]} for s in (old, new))
        return differences(
            {"tolerance": path["tolerance"], "schedule": old, **path["system"]},
            {"tolerance": self.tolerance, "schedule": new, **self.system},
        )

    def remaining(self, last: LastStep | None) -> DescribedSteps:
        """Yield the states after the last one that is done; see `PathSteps`."""
        if last is not None:
            self.stepper.restart_from(last.state)
            self.position = _Position(**last.path["position"])
            self._last = last.path["target"], last.step
        schedule = {"schedule": self.schedule.todict(), "tolerance": self.tolerance}
        for step in self.states():
            position = asdict(self.position)
            yield step, self.described(self.target, **schedule, position=position)

    def states(self) -> Generator[TimeStep, None, None]:
        """Yield the states of the schedule from the present position on."""
        position, schedule = self.position, self.schedule
        if self._last is None:
            self._estimate_scales()
            yield self._sudden(schedule.first, 0.0)
        for number, (begin, start, part) in enumerate(schedule.timed_parts()):
            if number < position.part:
                continue
            if number > position.part:
                position.part, position.done = number, 0
                position.level = self._first_level(part)
                self.stepper.remember(PRESSURE_RATE, None)
                if part.duration == 0.0:
                    position.level, position.done = 0, 1
                    yield self._sudden(part.end, begin)
            if part.duration > 0.0:
                yield from self._part(begin, start, part)

    def _part(
        self, begin: float, start: float, part: Part
    ) -> Generator[TimeStep, None, None]:
        """Yield the remaining states of a part of the schedule."""
        at, least = self.position, _least_level(part)
        at.level = max(at.level, least)
        while at.done < 2**at.level:
            if at.may_grow and at.level > least and at.done % 2 == 0:
                at.level, at.done, at.may_grow = at.level - 1, at.done // 2, False
            before, elapsed = self.stepper.state, part.duration / 2**at.level
            between = 0.5 * (elapsed + at.elapsed)
            if PRESSURE_RATE not in before.history:
                between = 0.25 * elapsed
                self._estimate_rate(begin, start, part)
            fraction = (at.done + 1) / 2**at.level
            target = part.target(start, fraction)
            moment = begin + fraction * part.duration
            step, unbalanced = self._step(target, moment, elapsed)
            rate = self._rate(before, elapsed)
            error = max(self._error(rate, elapsed, between), unbalanced)
            change = self._change(before, rate, elapsed)
            coarse = change > _LARGEST_CHANGE and at.level < _FINEST
            if (error > self.tolerance or coarse) and at.level < _MOST:
                self.stepper.restart_from(before)
                at.level, at.done, at.may_grow = at.level + 1, 2 * at.done, False
                continue
            self._check_held(target, step, before)
            at.done += 1
            at.may_grow = (
                error < _GROWTH * self.tolerance and change < 0.5 * _LARGEST_CHANGE
            )
            at.elapsed = elapsed
            self.stepper.remember(PRESSURE_RATE, rate)
            yield self._accepted(target, step)

    def _sudden(self, target: float, time: float) -> TimeStep:
        """Return the state after a sudden change of the target."""
        before = self.stepper.state
        step, _ = self._step(target, time, 0.0)
        self._check_held(target, step, before)
        return self._accepted(target, step)

    def _check_held(self, target: float, step: TimeStep, before: State) -> None:
        """Raise `RuntimeError` if the surface does not hold the indenter at a load."""
        lost = step.normal_force - target > _LOST_PART * abs(target)
        if self.stepper.control != "loads" or step.converged or not lost:
            return
        self.stepper.restart_from(before)
        raise RuntimeError(
            f"the contact is lost at the time {step.time:g}: it holds no tension of "
            f"{-target:g} eV/Å ({-target / UNITS['nN']:g} nN). The steps before are "
            "kept; end the loads there, or give heights or the base of a cantilever"
        )

    def _step(
        self, target: float, time: float, elapsed: float
    ) -> tuple[TimeStep, float]:
        """Return a step with its energies, and the error of their balance.

        Energy that is missing although the solid hardly creeps in so short a step, and
        the work is known, was lost in an instability, and is no error.
        """
        before, last = self.stepper.state, self._last
        number = last[1].step + 1 if last else 0
        step = self.stepper.step(
            number, target, self.record, moment=time, elapsed=elapsed
        )
        if last is None:
            return step, 0.0
        if elapsed:
            energy = dissipated_energy(before, self.stepper.state, self.creep, elapsed)
            energy *= self.stepper.contact.halfspace.cell_area
            step = replace(step, dissipated_energy=energy)
        missing, uncertainty = energy_balance(self.stepper, last, (target, step))
        error = self._energy_error(missing, step)
        unexplained = missing > uncertainty and error > self.tolerance
        lost = missing if unexplained else 0.0
        instantaneous = self.creep.compliance(elapsed) < _INSTANTANEOUS
        known = instantaneous and uncertainty < self.tolerance * lost
        return replace(step, lost_energy=lost), 0.0 if known else error

    def _energy_error(self, missing: float, step: TimeStep) -> float:
        """Return a missing energy relative to the largest energy of the path so far."""
        at, work = self.position, 0.0
        if self._last is not None:
            work = abs(at.work + work_between(self._last[1], step))
        scale = max(at.energy, work, at.dissipated + step.dissipated_energy)
        return _part_of(abs(missing), scale)

    def _rate(self, before: State, elapsed: float) -> np.ndarray:
        """Return the rate of the pressure in the last step."""
        new = self.stepper.state
        return (new.pressure - before.on(new.window).pressure) / elapsed

    def _estimate_rate(self, begin: float, start: float, part: Part) -> None:
        """Remember the rate in the first half of the next step, which is relaxed.

        It stands for the rate of a last step where a part of the schedule begins.
        """
        before, at = self.stepper.state, self.position
        fraction, half = (
            (at.done + 0.5) / 2**at.level,
            part.duration / 2 ** (at.level + 1),
        )
        target, moment = part.target(start, fraction), begin + fraction * part.duration
        self.stepper.step(0, target, _RELAXED, moment=moment, elapsed=half)
        rate = self._rate(before, half)
        rate = carried(rate, self.stepper.state.window, before.window)
        self.stepper.restart_from(before)
        self.stepper.remember(PRESSURE_RATE, rate)

    def _error(self, rate: np.ndarray, elapsed: float, between: float) -> float:
        """Return the estimated error of a step, some time after the last rate."""
        last, times = self.stepper.state.history[PRESSURE_RATE], self.creep.times
        curvature = float(abs(rate - last).sum()) / between
        change = elapsed * float(abs(rate).sum())
        bend = elapsed**2 * curvature
        x = elapsed / np.array(times)
        steps = _part_of(change, bend)  # over which the pressures bend
        repeated = np.maximum(_ADDED * np.minimum(1.0 / x, steps), 1.0)
        weights = np.array(self.creep.compliances) * x / (12.0 + 2.0 * x**2)
        weight = float(weights @ repeated)
        weight += self.creep.flow * elapsed / 12.0 * max(_ADDED * steps, 1.0)
        return _part_of(weight * bend, self._pressure())

    def _change(self, before: State, rate: np.ndarray, elapsed: float) -> float:
        """Return the change of the pressures in a step, relative to the largest sum."""
        if not before.pressure.any():
            return 0.0
        return _part_of(elapsed * float(abs(rate).sum()), self._pressure())

    def _pressure(self) -> float:
        """Return the largest sum of the pressures so far."""
        now = float(abs(self.stepper.state.pressure).sum())
        return max(self.position.pressure, now)

    def _accepted(self, target: float, step: TimeStep) -> TimeStep:
        at = self.position
        at.pressure = self._pressure()
        if self._last is not None:
            at.work += work_between(self._last[1], step)
        at.dissipated += step.dissipated_energy
        at.energy = max(at.energy, abs(at.work), at.dissipated)
        self._last = target, step
        return step

    def _estimate_scales(self) -> None:
        """Estimate the largest pressures and energies of the path from one step.

        The step takes the surface from rest to the largest target, in the time in which
        the path gets there.
        """
        sign = -1.0 if self.stepper.control in _LOWERED else 1.0
        target, time = self.schedule.largest(sign)
        before = self.stepper.state
        with suppress(ValueError, RuntimeError, MemoryError):  # of the path itself
            relaxed = self.stepper.step(0, target, _RELAXED, moment=time, elapsed=time)
            self.position.pressure = float(abs(relaxed.fields.pressure).sum())
            self.position.energy = abs(relaxed.fields.energy)
        self.stepper.restart_from(before)

    def _first_level(self, part: Part) -> int:
        """Return the power of two that divides a part into steps of the shortest time.

        That is, of the solid, or of the part if this is shorter.
        """
        flow = [1.0 / self.creep.flow] if self.creep.flow else []
        shortest = min([*self.creep.times, *flow])
        level = math.ceil(math.log2(max(part.duration / shortest, 1.0)))
        return min(max(level, _least_level(part)), _MOST)


def _part_of(value: float, scale: float) -> float:
    """Return a value relative to a scale, which is zero only if the value is."""
    return value / scale if scale else 0.0


def _least_level(part: Part) -> int:
    """Return the smallest power of two by which a part is divided."""
    cycles = part.frequency * part.duration
    return max(_LEAST, math.ceil(math.log2(max(_STEPS_PER_CYCLE * cycles, 1.0))))
