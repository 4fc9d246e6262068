r"""Paths in time: contacts of viscoelastic solids, in time steps of controlled error.

Between two states the pressure is taken as linear in time. The error that its curvature
leaves in the pressures :math:`q_k` that the surface remembers (see `contact.creep`) is

.. math:: \epsilon = \frac{\sum_k J_k\, \kappa(\Delta t/\theta_k)\,
          \Delta t^2 \sum_i |\ddot p_i|}{\max_t \sum_i |p_i|}, \qquad
          \kappa(x) = \frac{x}{12 + 2 x^2},

with the second derivative from the rates of this step and of the last one: it includes
atoms that open or close between them. A step of a larger error is repeated at half the
duration. Durations are those of a part of the schedule divided by powers of two, so
that few elastic solids are met.
"""

from __future__ import annotations

import math
from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import positive
from ase_roughcontact.contact import State
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.lattice import Box, carried
from ase_roughcontact.paths.output import Output, open_output
from ase_roughcontact.paths.record import LoadStep, TimeStep
from ase_roughcontact.paths.schedule import Part, Schedule
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.paths.validity import ValidityReport

# Powers of two by which the duration of a part is divided: at least, at its beginning,
# and at most. An oscillation has that many steps in a cycle.
_LEAST, _FIRST, _MOST = 3, 10, 40
_STEPS_PER_CYCLE = 32
# A step is followed by one of twice its duration if its error is below this part of the
# tolerance: it grows eightfold.
_GROWTH = 0.1


def follow_schedule(
    stepper: Stepper,
    schedule: Schedule,
    output: Output | None = None,
    *,
    tolerance: float = 1e-3,
    validity: str = "warn",
) -> Generator[LoadStep, None, None]:
    """Follow a schedule from a surface at rest; see `time_path` for the parameters.

    Yields
    ------
    LoadStep
        After it is written: the first state, and those at the end of each time step.
    """
    positive(tolerance=tolerance)
    output, report = output or Output(record=TimeStep), ValidityReport(validity)
    creep = stepper.problem.solid.creep
    if creep is None:
        raise ValueError(
            f"a path in time needs a Viscoelastic solid, got {stepper.problem.solid!r}"
        )
    steps = _TimeSteps(stepper, creep, tolerance, output.record)
    with open_output(output, stepper) as (_, write):
        for step in steps.states(schedule):
            write(step)
            report(step.step, step.validity)
            yield step


@dataclass
class _TimeSteps:
    """Time steps whose durations follow from an estimate of their errors."""

    stepper: Stepper
    creep: Creep
    tolerance: float
    record: type[LoadStep] = TimeStep

    def __post_init__(self) -> None:
        self._number, self._largest = 0, 0.0
        # of the pressure in the last step, with its window
        self._rate: tuple[np.ndarray, Box] | None = None
        self._elapsed, self._may_grow = 0.0, False

    def states(self, schedule: Schedule) -> Generator[LoadStep, None, None]:
        """Yield the states of a schedule."""
        yield self._accepted(self._step(schedule.first, 0.0, 0.0))
        for begin, start, part in schedule.timed_parts():
            self._rate = None
            if part.duration == 0.0:
                yield self._accepted(self._step(part.end, begin, 0.0))
            else:
                yield from self._part(begin, start, part)

    def _part(
        self, begin: float, start: float, part: Part
    ) -> Generator[LoadStep, None, None]:
        """Yield the states of a part of the schedule."""
        cycles = part.frequency * part.duration
        least = max(_LEAST, math.ceil(math.log2(max(_STEPS_PER_CYCLE * cycles, 1.0))))
        level, done = max(_FIRST, least), 0  # done in units of 2**-level of the part
        while done < 2**level:
            while level > least and done % 2 == 0 and self._may_grow:
                level, done = level - 1, done // 2
                self._may_grow = False
            elapsed, before = part.duration / 2**level, self.stepper.state
            fraction = (done + 1) / 2**level
            time = begin + fraction * part.duration
            step = self._step(part.target(start, fraction), time, elapsed)
            error = self._error(before, elapsed)
            if error > self.tolerance and level < _MOST:
                self.stepper.restart_from(before)
                level, done = level + 1, 2 * done
                continue
            done += 1
            self._may_grow = error < _GROWTH * self.tolerance
            self._keep_rate(before, elapsed)
            yield self._accepted(step)

    def _error(self, before: State, elapsed: float) -> float:
        """Return the estimated error of a step; zero without one before."""
        new = self.stepper.state
        scale = max(self._largest, float(abs(new.pressure).sum()))
        if self._rate is None or not scale:
            return 0.0
        last = carried(*self._rate, new.window)
        change = abs(self._rate_since(before, elapsed) - last).sum()
        curvature = 2.0 * float(change) / (elapsed + self._elapsed)
        x = elapsed / np.array(self.creep.times)
        weights = np.array(self.creep.compliances) * x / (12.0 + 2.0 * x**2)
        weight = float(weights.sum()) + self.creep.flow * elapsed / 12.0
        return weight * elapsed**2 * curvature / scale

    def _rate_since(self, before: State, elapsed: float) -> np.ndarray:
        new = self.stepper.state
        return (new.pressure - before.on(new.window).pressure) / elapsed

    def _keep_rate(self, before: State, elapsed: float) -> None:
        self._rate = self._rate_since(before, elapsed), self.stepper.state.window
        self._elapsed = elapsed

    def _step(self, target: float, time: float, elapsed: float) -> LoadStep:
        return self.stepper.step(
            self._number, target, self.record, moment=time, elapsed=elapsed
        )

    def _accepted(self, step: LoadStep) -> LoadStep:
        self._number += 1
        pressure = float(abs(self.stepper.state.pressure).sum())
        self._largest = max(self._largest, pressure)
        return step
