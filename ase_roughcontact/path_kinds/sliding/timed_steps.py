"""Sliding in time, with friction that depends on the slip rate and on a state.

The normal target is constant, and lateral tractions leave the pressure as it is. On a
viscoelastic solid the contact creeps under the pressure, and with the same creep under
the tractions, as Poisson's ratio does not change in time. Each
step has a duration at which its error is within the tolerance, see
`solvers.lateral.rate_step`; durations are the duration of a part of the schedule
divided by powers of two. Slip that becomes unstable is fast: without radiation damping
its rate grows without limit, and the path ends.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from ase_roughcontact._util.rounding import ROUNDING
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.contact import ContactState, State
from ase_roughcontact.contact.support import LateralSupport
from ase_roughcontact.elasticity.lattice import Box, carried
from ase_roughcontact.interactions.local_friction import LocalFriction
from ase_roughcontact.interactions.rate_and_state import SLIP_RATES
from ase_roughcontact.path_kinds.sliding.surface import (
    SlidingSurface,
    carried_vectors,
    past_entries,
    past_of,
)
from ase_roughcontact.path_kinds.sliding.timed_record import (
    TimedLateralState,
    TimedSlidingStep,
)
from ase_roughcontact.path_kinds.sliding.timed_specification import (
    TimedSlidingSpecification,
)
from ase_roughcontact.paths.path_steps import PathStep, PathSteps
from ase_roughcontact.paths.restart import Restart
from ase_roughcontact.paths.schedule import Part
from ase_roughcontact.paths.schedule_steps import (
    MAX_LEVEL,
    SchedulePosition,
    changes_of_schedule,
)
from ase_roughcontact.solvers.lateral.friction import FrictionSolution
from ase_roughcontact.solvers.lateral.rate_step import (
    STAGE,
    RateContact,
    RateStep,
    step_in_time,
)
from ase_roughcontact.solvers.lateral.slip import Drive
from ase_roughcontact.solvers.status import CONVERGED, Status
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.stepping.retraction import relax_in_contact
from ase_roughcontact.stepping.step import Stepper

# Power of two by which the duration of a part is divided at first.
_FIRST_LEVEL = 4
# Smallest power of two by which it is divided.
_LEAST_LEVEL = 2
# Largest power of two by which it is divided if damping keeps the rate finite: from
# minutes of a hold to picoseconds of a slip.
_MAX_DAMPED_LEVEL = 50
# Error that the solver of a contact that creeps may leave, relative to the tolerance.
_SOLVER_ERROR = 0.03
# Smallest number of steps in a cycle of an oscillation.
_MIN_CYCLE_STEPS = 32


class TimedSlidingSteps(PathSteps):
    """Steps in time of a contact with friction that depends on the slip rate.

    Parameters
    ----------
    stepper : Stepper
    given : TimedSlidingSpecification
        The path, with a normal target of the stepper's control.

    Raises
    ------
    NotImplementedError
        If the solid has no lateral components.
    """

    kind = TimedSlidingStep
    position = SchedulePosition

    def __init__(self, stepper: Stepper, given: TimedSlidingSpecification) -> None:
        self.creep = stepper.problem.solid.creep
        if self.creep:
            stepper = stepper.limited(_SOLVER_ERROR * given.tolerance)
        super().__init__(stepper)
        self.given = given
        self._surface = SlidingSurface(stepper.problem, given.friction)

    @property
    def parameters(self) -> dict[str, Any]:
        """Friction, spring and direction; see `PathSteps`."""
        return self.given.parameters

    @property
    def specification(self) -> dict[str, Any]:
        """Schedule, its quantity, normal target and tolerance; see `PathSteps`."""
        return {
            "schedule": self.given.schedule.todict(),
            "lateral": self.given.control.name,
            "target": self.given.target,
            "tolerance": self.given.tolerance,
        }

    def differences(self, done: Restart) -> list[str]:
        """Return the differences of the finished steps; see `PathSteps`."""
        old = {name: done.path[name] for name in self.specification}
        count = done.steps[-1].position["part"] + 1
        return changes_of_schedule(old, self.specification, count)

    def steps(
        self, last: PathStep, record: type[Any]
    ) -> Iterator[tuple[PathStep, RelaxedStep]]:
        """Yield the states after the last one that is done; see `PathSteps`."""
        at = last
        if at.record is None:
            at, left = self._first(at, record)
            yield at, left
        parts = self.given.schedule.timed_parts()
        for number, (begin, first, part) in enumerate(parts):
            if number < at.position.part:
                continue
            if number > at.position.part:
                level = max(_FIRST_LEVEL, _least_level(part))
                at = replace(at, position=at.position.in_part(number, level))
            while not at.position.ended:
                at, left = self._next(at, record, begin, first, part)
                yield at, left

    def _first(self, at: PathStep, record: type[Any]) -> tuple[PathStep, RelaxedStep]:
        """Return the state at the start, of a contact at rest or of a given one."""
        begun, given = perf_counter(), self.given
        relaxed = self._pressed(at, 0.0, 0.0)
        friction, box, contact = self._contact(at, relaxed)
        target = given.schedule.first * given.towards
        force = relaxed.fields.cell_area * contact.tractions.sum(axis=(1, 2))
        displacement = target if given.control.held else np.zeros(2)
        if given.spring:
            displacement = target - force / given.spring
        if given.control.free and not np.allclose(
            force, target, rtol=ROUNDING, atol=ROUNDING
        ):
            held = float(force @ given.towards)
            raise ValueError(
                f"forces must begin at the lateral force of the contact, {held:g} eV/Å "
                f"({held / UNITS['nN']:g} nN), got {given.schedule.first:g} eV/Å"
            )
        if given.control.free and not contact.pressure.any():
            raise ValueError(
                "no atom in contact can carry lateral forces: press the indenter on "
                "the surface, or give displacements"
            )
        load = contact.load_on(self._surface.halfspace(box.shape))
        step = RateStep(
            contact, np.zeros(2), np.zeros(2), 0.0, 0.0, load, 0.0, 0.0, 0, 0.0
        )
        lateral = self._lateral(
            at, relaxed, friction, box, step, displacement, target, 0.0, 0.0
        )
        return self._accepted(at.position, record, relaxed, lateral, begun)

    def _next(
        self,
        at: PathStep,
        record: type[Any],
        begin: float,
        first: float,
        part: Part,
    ) -> tuple[PathStep, RelaxedStep]:
        """Return the next state in a part of the schedule."""
        begun, given = perf_counter(), self.given
        position = at.position.grown(_least_level(part))
        pressed = None if self.creep else self._pressed(at, begin, 0.0)
        while True:
            fractions = position.fractions
            before, after = (
                part.target(first, each) * given.towards for each in fractions
            )
            duration = part.duration / 2**position.level
            time = begin + fractions[1] * part.duration
            relaxed = pressed or self._pressed(at, time, duration)
            friction, box, contact = self._contact(at, relaxed)
            drive = self._drive(at, relaxed, contact, after - before, after)
            step = step_in_time(
                self._surface.halfspace(box.shape),
                self._started(at, contact, box),
                drive,
                duration,
                given.tolerance,
                self._pressures(at, contact, box, time, duration),
                self.creep,
            )
            if step.error <= given.tolerance:
                break
            damped = given.friction.damping > 0.0
            if position.level >= (_MAX_DAMPED_LEVEL if damped else MAX_LEVEL):
                raise RuntimeError(_unstable(at.record, given.friction.damping))
            position = position.halved()
        old = np.array([at.record.lateral_x, at.record.lateral_y])
        displacement = after if given.control.held else old + step.shift
        driven = displacement - old if given.control.free else after - before
        work = relaxed.fields.cell_area * float(step.mean_force @ driven)
        lateral = self._lateral(
            at, relaxed, friction, box, step, displacement, after, time, work
        )
        position = position.advanced(step.error, given.tolerance)
        return self._accepted(position, record, relaxed, lateral, begun)

    def _pressed(self, at: PathStep, time: float, elapsed: float) -> RelaxedStep:
        """Return the normal contact at a time, some time after the last step."""
        number, target = at.number + 1, self.given.target
        if self.creep is None:
            return relax_in_contact(self.stepper, at.state, target, number)
        return self.stepper.relax(
            at.state, target, number=number, moment=time, elapsed=elapsed
        )

    def _started(self, at: PathStep, contact: RateContact, box: Box) -> RateContact:
        """Return the contact with the pressure at the start of a step."""
        if self.creep is None:
            return contact
        fields = self.stepper.restored(at.state).fields
        return replace(contact, pressure=_pressure(fields, at.state.window, box))

    def _pressures(
        self, at: PathStep, contact: RateContact, box: Box, time: float, elapsed: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the pressures at the ends of both stages of a step."""
        if self.creep is None:
            return contact.pressure, contact.pressure
        rest = (1.0 - STAGE) * elapsed
        middle = self._pressed(at, time - rest, STAGE * elapsed)
        found = _pressure(middle.fields, middle.state.window, box)
        return found, contact.pressure

    def _contact(
        self, at: PathStep, relaxed: RelaxedStep
    ) -> tuple[LocalFriction, Box, RateContact]:
        """Return friction, the box of all tractions, and the contact on it."""
        before = at.state
        friction, box, tractions = self._surface.on_box(relaxed, before)
        none = np.zeros(before.window.shape)
        rates = [before.history.get(name, none) for name in SLIP_RATES]
        history = {}
        for entry in friction.law.histories:
            known = friction.history.get(entry.name)
            unknown = np.full(friction.pressure.shape, entry.first)
            history[entry.name] = unknown if known is None else known
        contact = RateContact(
            self.given.friction,
            np.where(friction.contact, friction.pressure, 0.0),
            tractions,
            carried_vectors(rates, before.window, box),
            history,
            self._past(before, box),
        )
        return friction, box, contact

    def _past(self, before: State, box: Box) -> list[np.ndarray]:
        """Return the tractions of the past on a box, one for each term of the creep."""
        if self.creep is None:
            return []
        past = [carried_vectors(each, before.window, box) for each in past_of(before)]
        none = np.zeros((2, *box.shape))
        return past or [none] * self.creep.terms

    def _drive(
        self,
        at: PathStep,
        relaxed: RelaxedStep,
        contact: RateContact,
        change: np.ndarray,
        target: np.ndarray,
    ) -> Drive:
        """Return the change of the load over a step, to a target."""
        given, area = self.given, relaxed.fields.cell_area
        still = np.zeros(contact.tractions.shape)
        if given.control.held:
            return Drive(still + change[:, None, None])
        force, spring = target, given.spring or 0.0
        if spring:
            old = np.array([at.record.lateral_x, at.record.lateral_y])
            force = spring * (target - old)
        before = contact.tractions.sum(axis=(1, 2)).tolist()
        after = (force / area).tolist()
        stiffness = spring / area
        supports = (
            LateralSupport((before[0], before[1]), stiffness),
            LateralSupport((after[0], after[1]), stiffness),
        )
        return Drive(still, supports)

    def _lateral(
        self,
        at: PathStep,
        relaxed: RelaxedStep,
        friction: LocalFriction,
        box: Box,
        step: RateStep,
        displacement: np.ndarray,
        target: np.ndarray,
        time: float,
        work: float,
    ) -> TimedLateralState:
        """Return the lateral state after a step."""
        given, last, contact = self.given, at.record, step.contact
        halfspace = self._surface.halfspace(box.shape)
        area, touching = relaxed.fields.cell_area, contact.pressure > 0.0
        history = {
            entry.name: np.where(touching, contact.history[entry.name], entry.entering)
            for entry in friction.law.histories
        }
        origin = given.schedule.first * given.towards if given.control.held else 0.0
        solution = FrictionSolution(
            contact.tractions,
            touching,
            step.load.total_depth,
            step.shift,
            step.residual,
            Status(CONVERGED),
            step.steps,
            step.pairs,
        )
        return TimedLateralState(
            box=box,
            halfspace=halfspace,
            friction=replace(friction, history=history),
            bounds=contact.friction,
            displacement=displacement,
            moved=displacement - origin,
            base=target if given.spring else np.full(2, np.nan),
            dissipated=(last.dissipated_energy if last else 0.0)
            + area * step.dissipated,
            released=0.0,
            instabilities=0,
            solution=solution,
            cell_area=area,
            time=time,
            rates=contact.rates,
            load=step.load,
            creep=self.creep,
            crept=(last.creep_loss if last and self.creep else 0.0) + area * step.crept,
            work=(last.work if last else 0.0) + work,
            time_error=step.error,
            spring=given.spring or 0.0,
        )

    def _accepted(
        self,
        position: SchedulePosition,
        record: type[Any],
        relaxed: RelaxedStep,
        lateral: TimedLateralState,
        begun: float,
    ) -> tuple[PathStep, RelaxedStep]:
        """Return a step that is kept, with the history that the surface keeps."""
        seconds = perf_counter() - begun
        relaxed = replace(relaxed, lateral=lateral, seconds=seconds)
        window = relaxed.state.window
        history = self._surface.history(lateral, window)
        for name, values in zip(SLIP_RATES, lateral.rates, strict=True):
            history[name] = carried(values, lateral.box, window)
        history |= past_entries(lateral.load.past, lateral.box, window)
        left = self.stepper.commit(relaxed, **history)
        target = {"target": self.given.target}
        return PathStep(record.of(relaxed), left.state, target, position), left


def _pressure(fields: ContactState, window: Box, box: Box) -> np.ndarray:
    """Return the pressure of the atoms in contact on a box."""
    return carried(np.where(fields.contact, fields.pressure, 0.0), window, box)


def _least_level(part: Part) -> int:
    """Return the smallest power of two by which a part is divided."""
    count = max(_MIN_CYCLE_STEPS * part.frequency * part.duration, 1.0)
    return max(_LEAST_LEVEL, int(np.ceil(np.log2(count))))


def _unstable(last: TimedSlidingStep, damping: float) -> str:
    """Return why a step can't be made."""
    known = (
        f"the slip is unstable at the time {last.time:g} s: its rate, "
        f"{last.slip_rate / UNITS['nm']:.3g} nm/s, grows within too short a time. The "
        "steps before are kept; "
    )
    if damping:
        return known + "give a larger tolerance"
    return known + "give damping by radiation, or a stiffer spring"
