"""Paths in time of a scene with a viscoelastic solid."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.rounding import ROUNDING
from ase_roughcontact._util.units import FORCES, UNITS, with_unit
from ase_roughcontact._util.validation import (
    finite_array,
    nonnegative,
)
from ase_roughcontact.analysis.path_values import dynamic_stiffness, tension_at_turn
from ase_roughcontact.contact.control import BASE, LOAD, PENETRATION
from ase_roughcontact.path_kinds.time.record import TimeStep
from ase_roughcontact.path_kinds.time.results import RESULTS
from ase_roughcontact.path_kinds.time.specification import (
    TimeSpecification,
    check_cantilever,
)
from ase_roughcontact.path_kinds.time.steps import TimeSteps
from ase_roughcontact.paths.path_steps import PathSteps
from ase_roughcontact.paths.schedule import Schedule
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.path_kind import (
    PathKind,
    Steps,
    TargetPath,
    check_deepest,
    rates_of,
    stiffness_of,
    turn_text,
    write_curve,
)
from ase_roughcontact.stepping.step import Stepper
from ase_roughcontact.theory import JKR, ShapeTheory

# Number of time steps for a change of the target, as measured for smooth spheres (13 to
# 69). Attraction adds hundreds to thousands, most at slow rates.
_CHANGE_STEPS = 30
# Number of time steps for a hold, as measured for smooth spheres (8 to 44).
_HOLD_STEPS = 20
# Number of time steps for a cycle, as measured for smooth spheres (43 to 57).
_CYCLE_STEPS = 45
# Tolerance below which these numbers grow.
_USUAL_TOLERANCE = 1e-3
# Advice for a loop with a rate and a cantilever.
_CANTILEVER_ADVICE = (
    ': in place of a loop at a rate give kind = "time" and bases, heights of the base '
    'such as ["20 nm", "-50 nm", "200 nm"]'
)
# Branches of a path, by the sign of the change of a target that presses more.
_BRANCHES = {1.0: "approach", 0.0: "dwell", -1.0: "retraction"}


@dataclass(frozen=True)
class Timed(TargetPath):
    """``[path]`` of kind "time": targets and times (s), or rates (nm/s, nN/s).

    One rate applies to all changes of the target, or there is one for each of them.
    """

    kind = "time"
    record = TimeStep
    units = {
        "cantilever_stiffness": "N/m",
        "times": "s",
        "dwell": "s",
        "frequency": "Hz",
    }
    aliases = {"cantilever": "cantilever_stiffness"}
    in_order = True
    in_time = True
    controls = (*PathKind.controls, BASE)
    captions = {
        "time.png": "Force and contact area over time and over depth; theory over "
        "time: areas of elastic contacts under the force at each time; arrows: "
        "direction of the path.",
        "cantilever.png": "Force of the cantilever over the distance of its base.",
    }
    results = RESULTS

    loads: tuple | None = None
    penetrations: tuple | None = None
    heights: tuple | None = None
    bases: tuple | None = None
    deepest: float | str | None = None
    times: tuple | None = None
    rate: float | str | tuple | None = None
    dwell: float = 0.0
    amplitude: float | str | None = None
    frequency: float | None = None
    cycles: int = 3
    tolerance: float = TimeSpecification.tolerance
    cantilever_stiffness: float | None = None

    @property
    def columns(self) -> dict[str, str]:  # type: ignore[override]
        """Columns of the printed table, with their labels."""
        on_cantilever = self.controlled == BASE
        columns = {"time": "time"}
        if on_cantilever:
            columns |= {"base": "base", "deflection": "deflection"}
        columns |= {"penetration": "depth", "normal_force": "force"}
        columns["contact_area"] = "area"
        if not on_cantilever:
            columns["energy"] = "energy"
        columns["dissipation"] = "power"
        return columns

    @property
    def stiffness(self) -> float | None:
        """Stiffness of the cantilever (eV/Å^2); None without one."""
        stiffness = stiffness_of("cantilever_stiffness", self.cantilever_stiffness)
        try:
            check_cantilever(self.controlled, stiffness)
        except ValueError as error:
            advice = "" if self.deepest is None else _CANTILEVER_ADVICE
            raise ValueError(f"{error}{advice}") from error
        return stiffness

    @classmethod
    def own_entries(cls, entries: Mapping[str, Any]) -> Mapping[str, Any]:
        """Return a loop at a rate as a path in time; see `PathKind.own_entries`."""
        if entries.get("kind") != "loop" or entries.get("rate") is None:
            return entries
        return {**entries, "kind": cls.kind}

    @classmethod
    def renamed(cls, entries: Mapping[str, Any]) -> dict[str, Any]:
        """Return the entries; a loop at a rate has no targets, see `TargetPath`."""
        found = super().renamed(entries)
        key = PENETRATION.plural
        if found.get("deepest") is not None and found.get(key) == []:
            del found[key]
        return found

    @property
    def control(self) -> str:
        """Name of the quantity with given targets; of a loop the penetration."""
        return super().control if self.deepest is None else PENETRATION.name

    def check(self, bodies: Bodies) -> None:
        """Raise an error if the solid needs another kind of path."""
        if bodies.solid.creep is None:
            raise ValueError(
                "a path in time, such as a loop with a rate, needs a viscoelastic "
                "solid: give relaxation_moduli and relaxation_times in [substrate]"
            )

    def schedule(self, bodies: Bodies) -> Schedule:
        """Return the targets (Å or eV/Å) as a function of time (s).

        Raises
        ------
        ValueError
            If a key is missing or invalid.
        """
        unit, units = self.unit, self.units_of_targets(bodies)
        key = self.target_key
        path = self.in_unit([key, "deepest", "amplitude"], bodies)
        given = self._loop(bodies, path) if path.deepest is not None else path.values
        values = (UNITS[unit] * finite_array(key, list(given or ()))).tolist()
        if not values:
            raise ValueError(
                f"give {key}, between which the path goes, or for a loop at a rate "
                "deepest, the penetration at which it turns"
            )
        if (self.times is None) == (self.rate is None):
            raise ValueError(f"give either times, one for each of {key}, or a rate")
        nonnegative(dwell=self.dwell)
        if self.times is None:
            schedule = self._at_rates(values, units)
        elif self.dwell:
            raise ValueError(f"a dwell needs a rate: repeat one of {key} in times")
        else:
            times = finite_array("times", list(self.times)).tolist()
            schedule = Schedule.through(times, values)
        if (path.amplitude is None) != (self.frequency is None):
            raise ValueError("an oscillation needs both amplitude and frequency (Hz)")
        if self.frequency is not None:
            schedule = schedule.oscillate(
                UNITS[unit] * float(path.amplitude or 0.0), self.frequency, self.cycles
            )
        if not schedule.duration:
            raise ValueError(
                f"the path takes no time: give {key} that differ, such as [0, 20], or "
                "later times"
            )
        return schedule

    def specification(self, bodies: Bodies) -> TimeSpecification:
        """Return the schedule and the tolerance; see `schedule` for errors."""
        return TimeSpecification(self.schedule(bodies), self.tolerance)

    def _loop(self, bodies: Bodies, path: Timed) -> list[float]:
        """Return the penetrations (Å) of a loop, from which nothing interacts."""
        self.check(bodies)
        targets = [each.plural for each in self.controls]
        given = [key for key in targets if getattr(self, key) is not None]
        if given:
            raise ValueError(
                f"a loop at a rate has deepest in place of targets: omit {given[0]}"
            )
        wall, creep, deepest = bodies.wall, bodies.solid.creep, float(path.deepest or 0)
        check_deepest(bodies, self.deepest, deepest)
        if creep is None or not creep.relaxed or not wall.reach < math.inf:
            raise ValueError(
                "a loop at a rate needs a solid that relaxes to a modulus, and a wall "
                "of a finite range: give penetrations"
            )
        neck = 0.0
        if wall.attractive and not bodies.is_flat:
            # of the largest work of adhesion of a crack on the relaxed solid
            work = wall.work_of_adhesion / creep.relaxed
            modulus = creep.relaxed * bodies.solid.contact_modulus
            jkr: JKR | ShapeTheory
            if bodies.shape is not None:
                jkr = ShapeTheory(bodies.shape, modulus, work)
            else:
                jkr = JKR(bodies.radius, modulus, work)
            neck = -jkr.pull_off_penetration
        return [-wall.reach, deepest, -(wall.reach + neck)]

    def _at_rates(self, values: list[float], units: Mapping[str, float]) -> Schedule:
        """Return the schedule at given rates, with a dwell at the deepest target."""
        unit = "nN" if "nN" in units else "nm"
        rates = rates_of(self, len(values) - 1, units, unit)
        schedule = Schedule(values[0])
        for rate, (before, value) in zip(rates, pairwise(values), strict=True):
            schedule = schedule.ramp(value, rate=rate)
            if self.dwell and value == self.deepest_of(values) and value != before:
                schedule = schedule.hold(self.dwell)
        return schedule

    def planned(self, bodies: Bodies) -> PathKind:
        """Return the path of one step, to the largest target."""
        schedule, unit = self.specification(bodies).schedule, UNITS[self.unit]
        targets = [schedule.first, *(part.end for part in schedule.parts)]
        deepest = self.deepest_of(targets)
        if self.stiffness is None:
            return Steps.at(self.controlled, [deepest / unit])
        # a tip on the surface, or a rigid cantilever, whichever has the smaller force
        depth = max(bodies.wall.contact_distance - deepest, 0.0)
        load = min(self.stiffness * depth, bodies.force_at(depth))
        return Steps.at(LOAD, [load / UNITS["nN"]])

    def expected_count(self, bodies: Bodies) -> int:
        """Return the number of time steps, to a factor of two without attraction."""
        return round(1.0 + sum(self.expected_counts(bodies)))

    def expected_counts(self, bodies: Bodies) -> list[float]:
        """Return the numbers of time steps to expect in the parts of the schedule."""
        finer = max(1.0, _USUAL_TOLERANCE / self.tolerance) ** (1 / 3)
        counts = []
        for _, start, part in self.schedule(bodies).timed_parts():
            if part.amplitude:
                counts.append(_CYCLE_STEPS * part.frequency * part.duration)
            else:
                usual = _HOLD_STEPS if part.end == start else _CHANGE_STEPS
                counts.append(finer * usual)
        return counts

    def describe(self, bodies: Bodies) -> str:
        """Return a text on the plan, with the duration and the number of steps."""
        creep = bodies.solid.creep
        grows = ""
        if self.unit in FORCES and creep is not None and creep.relaxed:
            factor = creep.relaxed ** (-2.0 / 3.0)
            grows = f"; under a load its area grows up to {factor:.2g} times by creep"
        jumps = ""
        if bodies.wall.attractive:
            jumps = ", and where the contact snaps in or off: thousands at slow rates"
        return (
            f"Path of {self.schedule(bodies).duration:.4g} s, in about "
            f"{self.expected_count(bodies)} time steps ({_CHANGE_STEPS} for a change "
            f"of the target, {_HOLD_STEPS} for a dwell, {_CYCLE_STEPS} a cycle, more "
            f"with a small tolerance{jumps}). All are counted as large as the deepest "
            f"state, in a solid with the instantaneous modulus{grows}:"
        )

    def steps_of(self, bodies: Bodies, stepper: Stepper) -> PathSteps:
        """Return the steps that follow the schedule."""
        return TimeSteps(stepper, self.specification(bodies))

    @property
    def springs(self) -> dict[str, Any]:
        """Stiffness of the cantilever as it is written beside the results."""
        return {"cantilever": self.stiffness or 0.0}

    def summary(self, bodies: Bodies, states: Sequence[LoadStep]) -> dict[str, str]:
        """Return largest forces, and the energies lost."""
        steps: Any = states
        forces = [step.normal_force for step in steps]
        dissipated = sum(step.dissipated_energy for step in steps)
        jumps = [step.lost_energy for step in steps if step.lost_energy]
        found = {
            "time steps": f"{len(steps) - 1}, all in curve.csv",
            "largest force": with_unit(max(forces), "nN"),
            "dissipated energy": f"{with_unit(dissipated, 'eV')}, by the solid",
        }
        if bodies.wall.attractive:
            found["pull-off force"] = with_unit(max(0.0, -min(forces)), "nN")
        if (turn := self._turn(bodies, states)) is not None:
            found["turn"] = turn_text(turn)
        if jumps:
            found["lost energy"] = (
                f"{with_unit(sum(jumps), 'eV')}, in {len(jumps)} instabilities at the "
                "instantaneous modulus"
            )
        if self.frequency is not None:
            with suppress(ValueError):  # of a path that is not finished
                stiffness = dynamic_stiffness(steps, self.frequency)
                found["dynamic stiffness"] = (
                    f"storage {with_unit(stiffness.real, 'N/m')}, "
                    f"loss {with_unit(stiffness.imag, 'N/m')}, at {self.frequency:g} Hz"
                )
        return found

    def warnings(self, bodies: Bodies, states: Sequence[LoadStep]) -> tuple[str, ...]:
        """Return why the pull-off force is a lower bound; see `PathKind.warnings`."""
        turn = self._turn(bodies, states)
        if turn is None or turn.normal_force >= 0.0:
            return ()
        least = min(state.normal_force for state in states)
        return (tension_at_turn(turn, -least),)

    def _turn(self, bodies: Bodies, states: Sequence[LoadStep]) -> LoadStep | None:
        """Return the last state before the retraction with the largest tension.

        None if the largest tension does not belong to a retraction.
        """
        branches = self.branch_names(bodies, states)
        forces = [state.normal_force for state in states]
        last = int(np.argmin(forces))
        if forces[last] >= 0.0 or branches[last] != "retraction":
            return None
        while last and branches[last] == "retraction":
            last -= 1
        return states[last]

    def draw(
        self,
        bodies: Bodies,
        states: Sequence[Any],
        folder: Path,
        ending: str = "png",
    ) -> Iterator[str]:
        """Draw force and area over time and depth; write the force curve."""
        from ase_roughcontact.path_kinds.time import figures  # imports matplotlib

        branches = self.branch_names(bodies, states)
        limits = {
            bodies.labelled(f"{limit.name}: theory, {name} modulus"): limit
            for name, limit in bodies.sphere_limits.items()
        }
        theory = bodies.forces_over_depth(limits, states)
        over_depth, over_time = {}, {}
        forces = np.array([state.normal_force for state in states])
        for label, (depth, force) in theory.items():
            area_under = limits[label].contact_area
            stable = slice(int(force.argmin()), None)  # contacts under a given force
            over_depth[label] = depth[stable], area_under(force[stable])
            over_time[label] = area_under(forces)
        name = f"time.{ending}"
        figures.draw_time_path(
            folder / name, states, branches, theory, over_depth, over_time
        )
        yield name
        if self.stiffness is not None:
            columns: dict[str, list[float]] = {
                "time": [state.time for state in states],
                "distance": [state.base for state in states],
                "deflection": [state.deflection for state in states],
                "force": [state.normal_force for state in states],
            }
            write_curve(folder / "cantilever.csv", branches, columns)
            name = f"cantilever.{ending}"
            figures.draw_cantilever_path(folder / name, states, branches)
            yield name

    def branch_names(self, bodies: Bodies, states: Sequence[Any]) -> list[str]:
        """Return the name of the branch of each state; see `PathKind`."""
        parts = list(self.schedule(bodies).timed_parts())
        inward = self.deepest_of([-1.0, 1.0])  # sign of targets that press more
        names, begins = [], []
        for begin, start, part in parts:
            begins.append(begin)
            if part.amplitude:
                names.append("oscillation")
            else:
                names.append(_BRANCHES[np.sign(part.end - start) * inward])
        times = np.array([state.time for state in states]) * (1.0 - ROUNDING)
        return [names[i - 1] for i in np.searchsorted(begins, times).clip(1)]
