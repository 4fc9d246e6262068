"""Sliding paths of a scene: there and back against friction."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice, zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS, with_unit
from ase_roughcontact._util.validation import (
    FloatArray,
    integer,
)
from ase_roughcontact.analysis.path_values import loop_energies, static_friction
from ase_roughcontact.interactions.rate_and_state import check_without_rate
from ase_roughcontact.loading.trajectory import frames_of_steps, places_of_steps
from ase_roughcontact.path_kinds.sliding.lateral_path import LateralPath
from ase_roughcontact.path_kinds.sliding.record import SlidingStep
from ase_roughcontact.path_kinds.sliding.results import RESULTS
from ase_roughcontact.path_kinds.sliding.specification import (
    SlidingSpecification,
)
from ase_roughcontact.path_kinds.sliding.steps import SlidingSteps
from ase_roughcontact.paths.path_steps import PathSteps
from ase_roughcontact.results.record import LoadStep, columns_of
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.path_kind import MAX_STEPS
from ase_roughcontact.stepping.step import Stepper

# Largest number of maps in a figure.
_MAX_MAPS = 4
# Smallest lateral force, relative to the largest friction, that is not rounding.
_MIN_RELATIVE_FORCE = 1e-6


@dataclass(frozen=True)
class Sliding(LateralPath):
    """``[path]`` of kind "sliding": lateral targets between which the indenter moves.

    See `LateralPath`. The load, penetration or height has one value, or one for each
    lateral target.
    """

    kind = "sliding"
    record = SlidingStep
    captions = {
        "friction.png": "Lateral force over displacement, and areas of stick and slip "
        "over the distance travelled; dotted: the path turns.",
        "tractions.png": "Lateral tractions at some displacements; blue: atoms that "
        "stick; orange: atoms that slip.",
    }
    results = RESULTS
    main_result = "static_friction"
    aliases = {**LateralPath.aliases, "steps": "steps_per_move"}

    steps_per_move: int = 10

    @property
    def columns(self) -> dict[str, str]:  # type: ignore[override]
        """Columns of the printed table, with their labels."""
        spring, oblique = bool(self.bases), bool(self.direction)
        columns = dict[str, str]()
        for axis in "xy" if oblique else "x":
            if spring:
                columns[f"base_{axis}"] = f"base {axis}"
            columns[f"lateral_{axis}"] = axis
            columns[f"lateral_force_{axis}"] = f"force {axis}"
        if not oblique:
            columns["stick_area"] = "stick"
        if not (oblique or spring):
            columns["lateral_stiffness"] = "stiffness"
        if not (oblique and spring):
            columns["normal_force"] = "load"
        columns["slip_area"] = "slip"
        columns["dissipated_energy"] = "lost"
        return columns

    def targets(self, bodies: Bodies) -> FloatArray:
        """Return the normal targets of the steps; see `PathKind.targets`."""
        control, found = self.controlled, self.normal_targets(bodies)
        turns = self.turns(bodies)
        if integer("steps_per_move", self.steps_per_move, 1) * len(turns) > MAX_STEPS:
            raise ValueError(f"a path has at most {MAX_STEPS} steps, got more")
        if len(found) not in (1, len(turns)):
            raise ValueError(
                f"give one of {control.plural}, or one for each of the {len(turns)} "
                f"{self.lateral_control.name}, got {len(found)}"
            )
        return self._between(np.broadcast_to(found, turns.shape))

    def _between(self, turns: FloatArray) -> FloatArray:
        """Return the values at all steps."""
        moves, steps = len(turns) - 1, self.steps_per_move
        at = np.arange(steps * moves + 1) / steps
        return np.interp(at, np.arange(len(turns)), turns)

    def check(self, bodies: Bodies) -> None:
        """Raise an error if the friction needs a path in time; see `LateralPath`."""
        super().check(bodies)
        check_without_rate(bodies.friction.law_on(bodies.spacing))

    def describe(self, bodies: Bodies) -> str:
        """Return a text on the plan, with the number of steps."""
        key = self.lateral_control.name
        time = "the time of friction is of the same order"
        if bodies.friction.coupled:
            time = "friction, coupled to the pressure, takes several times as long"
        if bodies.friction.law_on(bodies.spacing).weakens:
            time = (
                "friction that depends on slip takes up to three times as long, and "
                "some fifty times in steps with an instability"
            )
        return (
            f"Sliding in {self.count(bodies)} steps, {self.steps_per_move} between two "
            f"of the {key}. The states at the normal targets are planned; {time}:"
        )

    def specification(self, bodies: Bodies) -> SlidingSpecification:
        """Return the path in ASE's units.

        Raises
        ------
        ValueError
            If a key is missing or invalid.
        """
        return SlidingSpecification(
            targets=self.targets(bodies),
            friction=bodies.friction.law_on(bodies.spacing),
            lateral=np.outer(self._between(self.turns(bodies)), self.towards),
            control=self.lateral_control,
            spring=self.lateral_stiffness,
            coupling=bodies.friction.coupling,
        )

    def steps_of(self, bodies: Bodies, stepper: Stepper) -> PathSteps:
        """Return the driver that moves the indenter."""
        return SlidingSteps(stepper, self.specification(bodies))

    def summary(self, bodies: Bodies, states: Sequence[LoadStep]) -> dict[str, str]:
        """Return static friction, the energy of the last loop, and the stiffness."""
        steps: Any = states
        touching = [step for step in steps if step.repulsive_atoms]
        if not touching:
            return {"static friction": "none: no atom is in contact"}
        friction, energies = static_friction(steps), loop_energies(steps)
        found = {
            "static friction": with_unit(friction, "nN")
            if math.isfinite(friction)
            else "not reached: some atoms stick in all steps",
            "lost energy": with_unit(steps[-1].dissipated_energy, "eV"),
        }
        if len(energies):
            of_loop = with_unit(energies[-1], "eV")
            found["lost energy"] += f", {of_loop} of it in the last loop"
        if jumps := [step for step in touching if step.instabilities]:
            count = sum(step.instabilities for step in jumps)
            number = "one instability" if count == 1 else f"{count} instabilities"
            found["released energy"] = (
                f"{with_unit(jumps[-1].released_energy, 'eV')} in {number}, the first "
                f"in step {jumps[0].step}"
            )
        last = touching[-1]
        if "lateral_stiffness" not in columns_of(type(last)):
            return found
        lateral, normal = last.lateral_stiffness, last.contact_stiffness
        ratio = "the normal one is not defined, as the contact is at an instability"
        if normal > 0.0:
            ratio = f"{lateral / normal:.4g} times the normal one"
        along = " along x" * bool(self.direction)
        found["stiffness without slip"] = f"{with_unit(lateral, 'N/m')}{along}, {ratio}"
        return found

    def draw(
        self,
        bodies: Bodies,
        states: Sequence[Any],
        folder: Path,
        ending: str = "png",
    ) -> Iterator[str]:
        """Draw friction loop, areas, and maps of tractions."""
        # imports matplotlib
        from ase_roughcontact.path_kinds.sliding import figures

        name = f"friction.{ending}"
        figures.draw_friction(folder / name, states, self.towards)
        yield name
        file = folder / "sweep.traj"
        with_frame = places_of_steps(file)
        shown = self.partly_slipping([s for s in states if s.step in with_frame])
        if shown:
            frames = list(frames_of_steps(file, [state.step for state in shown]))
            titles = [self._title(state) for state in shown]
            name = f"tractions.{ending}"
            figures.draw_tractions(folder / name, frames, titles, bodies.scanned)
            yield name

    def partly_slipping(self, states: Sequence[Any]) -> list[Any]:
        """Return a few states with tractions in order, with the most partial slip.

        First one of each move between two turns, then a second one; of equal tractions
        only one.
        """
        distinct = dict[tuple[str, str], Any]()
        for state in states:
            if state.lateral_energy:
                force = math.hypot(state.lateral_force_x, state.lateral_force_y)
                same = f"{force:.2g}", f"{state.stick_area:.1g}"
                distinct.setdefault(same, state)
        best = sorted(distinct.values(), key=lambda s: -s.stick_area * s.slip_area)
        moves = defaultdict[int, list[Any]](list)
        for state in best:
            moves[(state.step - 1) // self.steps_per_move].append(state)
        in_turn = filter(None, chain(*zip_longest(*moves.values())))
        return sorted(islice(in_turn, _MAX_MAPS), key=lambda s: s.step)

    def _title(self, state: Any) -> str:
        """Return displacement and lateral force along the path."""
        at = self.towards @ [state.lateral_x, state.lateral_y] / UNITS["nm"]
        force = self.towards @ [state.lateral_force_x, state.lateral_force_y]
        if abs(force) < _MIN_RELATIVE_FORCE * state.largest_friction:
            force = 0.0
        text = f"{round(at, 9) + 0.0:.3g} nm, {force / UNITS['nN']:.3g} nN"
        return text.replace("-", "\N{MINUS SIGN}")
