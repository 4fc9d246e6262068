"""Sliding paths in time of a scene, with rate and state friction."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.units import FORCES, UNITS, with_unit
from ase_roughcontact._util.validation import finite_array, positive
from ase_roughcontact.analysis.path_values import friction_coefficients
from ase_roughcontact.interactions.rate_and_state import RateFriction, check_rate
from ase_roughcontact.path_kinds.sliding.lateral_path import LateralPath
from ase_roughcontact.path_kinds.sliding.timed_record import TimedSlidingStep
from ase_roughcontact.path_kinds.sliding.timed_results import RESULTS
from ase_roughcontact.path_kinds.sliding.timed_specification import (
    TimedSlidingSpecification,
)
from ase_roughcontact.path_kinds.sliding.timed_steps import TimedSlidingSteps
from ase_roughcontact.paths.path_steps import PathSteps
from ase_roughcontact.paths.schedule import Part, Schedule
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.path_kind import PathKind, Steps, rates_of
from ase_roughcontact.scene.section import lengths
from ase_roughcontact.stepping.step import Stepper

# Number of time steps for a change of the lateral target, at the usual tolerance: the
# mean of 35 to 99 for smooth spheres without stick-slip.
_CHANGE_STEPS = 60
# Number of time steps for a hold: the mean of 45 to 61.
_HOLD_STEPS = 50


@dataclass(frozen=True)
class TimedSliding(LateralPath):
    """``[path]`` of kind "sliding-in-time": lateral targets at times or rates.

    See `LateralPath`. The load, penetration or height has one value. Times are in
    seconds, one for each lateral target from zero on; rates in nm/s or nN/s.
    """

    kind = "sliding-in-time"
    record = TimedSlidingStep
    units = {**LateralPath.units, "times": "s"}
    in_time = True
    captions = {
        "friction.png": "Friction coefficient and slip rate over time.",
    }
    results = RESULTS
    main_result = "largest_friction_coefficient"

    times: tuple | None = None
    rate: float | str | tuple | None = None
    tolerance: float = TimedSlidingSpecification.tolerance

    @property
    def columns(self) -> dict[str, str]:  # type: ignore[override]
        """Columns of the printed table, with their labels."""
        columns = {"time": "time"}
        if self.bases:
            columns["base_x"] = "base x"
        columns |= {"lateral_x": "x", "lateral_force_x": "force x"}
        if not self.bases:
            columns["normal_force"] = "load"
        return columns | {
            "slip_rate": "rate",
            "friction_state": "state",
            "dissipated_energy": "lost",
        }

    def check(self, bodies: Bodies) -> None:
        """Raise an error unless the friction depends on the slip rate."""
        super().check(bodies)
        if not isinstance(bodies.friction.law_on(bodies.spacing), RateFriction):
            raise ValueError(
                f'kind = "{self.kind}" needs friction that depends on the slip rate: '
                'give kind = "rate-and-state" in [friction], or kind = "sliding"'
            )
        if bodies.friction.coupled:
            raise ValueError(
                "sliding in time neglects the coupling of normal and lateral motion: "
                'leave out coupling = "solved"'
            )
        positive(tolerance=self.tolerance)

    def lateral_schedule(self, bodies: Bodies) -> Schedule:
        """Return the lateral targets (Å or eV/Å) as a function of time (s).

        Raises
        ------
        ValueError
            If a key is missing or invalid.
        """
        targets = self.turns(bodies).tolist()
        if (self.times is None) == (self.rate is None):
            raise ValueError("give either times, one for each lateral target, or rate")
        if self.times is not None:
            times = finite_array("times", list(self.times)).tolist()
            return Schedule.through(times, targets)
        force = self.lateral_control.unit in FORCES
        units = FORCES if force else lengths(bodies.spacing)
        rates = rates_of(self, len(targets) - 1, units, "nN" if force else "nm")
        schedule = Schedule(targets[0])
        for rate, (before, target) in zip(rates, pairwise(targets), strict=True):
            if target == before:
                raise ValueError(
                    "a hold, which repeats a lateral target, needs times in place of "
                    "rate: one time for each target, such as [0, 10, 20]"
                )
            schedule = schedule.ramp(target, rate=rate)
        return schedule

    def schedule(self, bodies: Bodies) -> Schedule:
        """Return the normal target over the time; see `PathKind.schedule`."""
        (target, *others) = self.normal_targets(bodies).tolist()
        if others:
            raise ValueError(
                f"give one of {self.target_key}, which is held in time, got "
                f"{1 + len(others)}"
            )
        lateral = self.lateral_schedule(bodies)
        parts = [Part(part.duration, target) for part in lateral.parts]
        return Schedule(target, parts)

    def specification(self, bodies: Bodies) -> TimedSlidingSpecification:
        """Return the path in ASE's units.

        Raises
        ------
        ValueError
            If a key is missing or invalid.
        """
        x, y = self.towards.tolist()
        return TimedSlidingSpecification(
            target=self.schedule(bodies).first,
            friction=check_rate(bodies.friction.law_on(bodies.spacing)),
            schedule=self.lateral_schedule(bodies),
            control=self.lateral_control,
            spring=self.lateral_stiffness,
            direction=(x, y),
            tolerance=self.tolerance,
        )

    def steps_of(self, bodies: Bodies, stepper: Stepper) -> PathSteps:
        """Return the driver that moves the indenter."""
        return TimedSlidingSteps(stepper, self.specification(bodies))

    def planned(self, bodies: Bodies) -> PathKind:
        """Return the path of one step, at the normal target."""
        target = self.specification(bodies).target
        return Steps.at(self.controlled, [target / UNITS[self.unit]])

    def expected_counts(self, bodies: Bodies) -> list[float]:
        """Return the numbers of time steps to expect in the parts of the schedule."""
        usual = TimedSlidingSpecification.tolerance
        finer = (usual / self.tolerance) ** (1 / 3)
        return [
            finer * (_HOLD_STEPS if part.end == start else _CHANGE_STEPS)
            for _, start, part in self.lateral_schedule(bodies).timed_parts()
        ]

    def expected_count(self, bodies: Bodies) -> int:
        """Return the number of time steps, without stick-slip."""
        return round(1.0 + sum(self.expected_counts(bodies)))

    def describe(self, bodies: Bodies) -> str:
        """Return a text on the plan, with the duration and the number of steps."""
        duration, count = self.schedule(bodies).duration, self.expected_count(bodies)
        return (
            f"Sliding for {duration:.4g} s, in about {count} time steps "
            f"({_CHANGE_STEPS} for a change of the target, {_HOLD_STEPS} for a hold, "
            "more with a small tolerance and for each slip of stick-slip). The state "
            "at the normal target is planned; friction takes some ten times as long:"
        )

    def summary(self, bodies: Bodies, states: Sequence[LoadStep]) -> dict[str, str]:
        """Return friction coefficients, rates, and energies."""
        steps: Any = states
        if not any(step.repulsive_atoms for step in steps):
            return {"friction": "none: no atom is in contact"}
        last, coefficients = steps[-1], friction_coefficients(steps)
        fastest = float(np.nanmax([step.slip_rate for step in steps]))
        return {
            "time steps": f"{len(steps) - 1}, all in curve.csv",
            "largest friction": f"{coefficients.max():.4g} times the normal force",
            "last friction": f"{coefficients[-1]:.4g} times the normal force",
            "largest slip rate": with_unit(fastest, "nm/s"),
            "lost energy": with_unit(last.dissipated_energy, "eV"),
        }

    def draw(
        self,
        bodies: Bodies,
        states: Sequence[Any],
        folder: Path,
        ending: str = "png",
    ) -> Iterator[str]:
        """Draw friction and slip rate over time."""
        # imports matplotlib
        from ase_roughcontact.path_kinds.sliding import timed_figures

        name = f"friction.{ending}"
        timed_figures.draw_sliding_in_time(folder / name, states)
        yield name
