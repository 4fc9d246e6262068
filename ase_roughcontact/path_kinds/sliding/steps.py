r"""Sliding paths: contacts with friction under lateral displacements or forces.

Each step relaxes the contact along its normal, and then finds the lateral tractions at
its pressure, see `solve_friction`. That the tractions do not change the pressure, nor
the pressure the lateral displacement, is exact for a Poisson's ratio of 1/2, and else
Goodman's approximation; or both are repeated until they agree, see `coupling`. The
indenter keeps the heights it had before it slides: lateral displacements must be small
compared to the roughness.

If friction weakens by slip, a step may have instabilities, over which it goes on at the
next equilibrium, see `slip`.

References
----------
L. E. Goodman, J. Appl. Mech. 29, 515 (1962).
"""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from ase_roughcontact._util.rounding import ROUNDING
from ase_roughcontact.contact import State
from ase_roughcontact.contact.state import TRACTION_DEPTH
from ase_roughcontact.contact.support import LateralSupport
from ase_roughcontact.path_kinds.sliding.coupling import (
    FIRST_RESIDUAL,
    MAX_ALTERNATIONS,
    Coupling,
    disagreement,
    mixed,
)
from ase_roughcontact.path_kinds.sliding.lateral_state import LateralState
from ase_roughcontact.path_kinds.sliding.record import SlidingStep
from ase_roughcontact.path_kinds.sliding.specification import SlidingSpecification
from ase_roughcontact.path_kinds.sliding.surface import (
    SlidingSurface,
    carried_vectors,
)
from ase_roughcontact.paths.path_steps import NumberedSteps, PathStep
from ase_roughcontact.solvers.lateral.friction import FrictionOptions
from ase_roughcontact.solvers.lateral.slip import Drive, follow_slip, slip_at_bounds
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.stepping.retraction import relax_in_contact
from ase_roughcontact.stepping.step import Stepper


class _Move(NamedTuple):
    """Lateral target of a step, and the end of the last step.

    Attributes
    ----------
    target : ndarray, shape (2,)
        Lateral target along x and y.
    at : ndarray, shape (2,), or None
        Displacement of the indenter, None before the first step (Å).
    origin : ndarray, shape (2,)
        Displacement at which the indenter came down (Å).
    dissipated, released : float
        Energies lost by slip and released by instabilities so far (eV).
    """

    target: np.ndarray
    at: np.ndarray | None
    origin: np.ndarray
    dissipated: float
    released: float


class SlidingSteps(NumberedSteps):
    """Steps of a contact with friction, each from the last one.

    At first the contact has no tractions, unless the stepper's state has: the first
    displacement is the origin. A contact that can't carry a force is not converged: how
    far it slides is not known, and counted neither as displacement nor as energy.

    Parameters
    ----------
    stepper : Stepper
    given : SlidingSpecification
        The path, with normal targets of the stepper's control.

    Raises
    ------
    ValueError
        If the normal targets do not fit, or the surface is displaced by tractions that
        a path without coupling does not know.
    NotImplementedError
        If the solid has no lateral components.
    """

    kind = SlidingStep

    def __init__(self, stepper: Stepper, given: SlidingSpecification) -> None:
        super().__init__(stepper, given.normal(stepper.control))
        self.given = given
        self._cross: Coupling | None = None
        problem = stepper.problem
        if given.coupled:
            if problem.solid.coupling:  # none for a Poisson's ratio of 1/2
                self._cross = Coupling(problem, stepper.accuracy)
        elif TRACTION_DEPTH in stepper.start.history:
            raise ValueError(
                "the surface is displaced by tractions of a path with "
                "coupling='solved': give the same coupling, or start from new atoms"
            )
        self._surface = SlidingSurface(problem, given.friction)

    @property
    def parameters(self) -> dict[str, Any]:
        """Friction, spring and coupling; see `PathSteps`."""
        return self.given.parameters

    def target(self, number: int) -> dict[str, Any]:
        """Return the quantities that a step prescribes."""
        lateral = {self.given.control.name: self.given.lateral[number].tolist()}
        return super().target(number) | {"lateral": lateral}

    def change_of_target(self, old: dict[str, Any], number: int) -> str:
        """Return the difference of the targets of a step; see `NumberedSteps`."""
        if found := super().change_of_target(old, number):
            return found
        name, new = self.given.control.name, self.given.lateral
        was = old["lateral"].get(name)
        if was is None:
            return f"its path has no lateral {name}"
        if abs(new[number] - was).max() <= ROUNDING * np.ptp(new, axis=0).max():
            return ""
        before = ", ".join(f"{value:.12g}" for value in was)
        after = ", ".join(f"{value:.12g}" for value in new[number])
        return f"{name}[{number}] was {before}, is {after}"

    def relax(
        self, last: PathStep, number: int
    ) -> tuple[RelaxedStep, dict[str, np.ndarray]]:
        """Relax the contact, and then its tractions; see `NumberedSteps`."""
        begun, target, state = perf_counter(), self.targets[number], last.state
        move = self._move(number, last.record)
        relaxed = relax_in_contact(self.stepper, state, target, number)
        if self._cross is None:
            lateral = self._slid(state, move, relaxed)
        else:
            relaxed, lateral = self._agreed(self._cross, state, move, relaxed, target)
        relaxed = relaxed.marked(lateral.solution.status)
        seconds = perf_counter() - begun
        relaxed = replace(relaxed, lateral=lateral, seconds=seconds)
        window = relaxed.state.window
        by_pressure: np.ndarray | float = 0.0
        if self._cross:
            by_pressure = self._cross.lateral(relaxed.state, window)
        return relaxed, self._surface.history(lateral, window, by_pressure)

    def _agreed(
        self,
        cross: Coupling,
        before: State,
        move: _Move,
        relaxed: RelaxedStep,
        target: float,
    ) -> tuple[RelaxedStep, LateralState]:
        """Solve the normal and the lateral problem in turn until they agree."""
        lateral = self._slid(before, move, relaxed, tolerance=FIRST_RESIDUAL)
        depths: list[tuple[np.ndarray, np.ndarray]] = []
        for number in range(1, MAX_ALTERNATIONS + 1):
            depth, change = cross.change(relaxed, lateral)
            if change <= cross.agreed or not relaxed.run.converged:
                # to the tolerance of the lateral problem itself
                lateral = self._slid(before, move, relaxed, lateral)
                depth, change = cross.change(relaxed, lateral)
            if change <= cross.agreed or not relaxed.run.converged:
                break
            if number == MAX_ALTERNATIONS:
                relaxed = relaxed.marked(disagreement(number, change))
                break
            state = relaxed.state
            used = state.history.get(TRACTION_DEPTH, np.zeros(depth.shape))
            depths.append((used, depth))
            state = state.keeping(**{TRACTION_DEPTH: mixed(depths)})
            relaxed = self.stepper.relax(
                state, target, number=relaxed.number, again=relaxed
            )
            residual = FIRST_RESIDUAL * min(change, 1.0)
            lateral = self._slid(before, move, relaxed, lateral, residual)
        return relaxed, replace(lateral, alternations=number)

    def _move(self, number: int, previous: Any) -> _Move:
        """Return the lateral target of a step, and where the last one has ended."""
        target, at, origin = self.given.lateral[number], None, np.zeros(2)
        dissipated = released = 0.0
        if self.given.control.held:
            origin = self.given.lateral[0]
        if previous is not None:
            at = np.array([previous.lateral_x, previous.lateral_y])
            dissipated = previous.dissipated_energy
            released = previous.released_energy
        return _Move(target, at, origin, dissipated, released)

    def _slid(
        self,
        before: State,
        move: _Move,
        relaxed: RelaxedStep,
        last: LateralState | None = None,
        tolerance: float = 0.0,
    ) -> LateralState:
        """Return the tractions at a target; the last ones are at another pressure.

        The tolerance is at least the one of `FrictionOptions`.
        """
        friction, box, start = self._surface.on_box(relaxed, before)
        bounds, halfspace = friction.bounds(), self._surface.halfspace(box.shape)
        change, new = np.zeros(start.shape), 0.0
        by_pressure: np.ndarray | float = 0.0
        if self._cross:
            touching = bounds > 0.0  # coupled atoms have tractions
            new = float((touching & ~start.any(axis=0)).sum()) / max(touching.sum(), 1)
            by_pressure = self._cross.lateral(relaxed.state, box)
            change = self._cross.lateral(before, box) - by_pressure
        area, options = relaxed.fields.cell_area, FrictionOptions()
        options = replace(options, tolerance=max(tolerance, options.tolerance))
        weakens = self.given.friction.weakens
        # a step with weakening has its own path from the last one
        at, moved, support = self._supported(move, area, None if weakens else last)
        change = change + moved[:, None, None]
        if weakens:
            supports = None
            if support is not None:
                x, y = start.sum(axis=(1, 2)).tolist()
                supports = LateralSupport((x, y), support.stiffness), support
            drive = Drive(change, supports)
            slid = follow_slip(halfspace, friction, start, drive, options)
            bounds = slid.friction.bounds()
        else:
            guess = start
            if last is not None:
                guess = carried_vectors(last.solution.tractions, last.box, box)
            slid = slip_at_bounds(
                halfspace, friction, start, change, guess, support, options
            )
            if self.given.control.free and not slid.solution.converged:
                moved = np.zeros(2)  # not known
        solution = slid.solution
        if last is not None:
            pairs = last.solution.pairs + solution.pairs
            solution = replace(solution, pairs=pairs)
        at = at + moved + slid.solution.shift
        return LateralState(
            box=box,
            halfspace=halfspace,
            friction=slid.friction,
            bounds=bounds,
            displacement=at,
            moved=at - move.origin,
            base=move.target if self.given.spring else np.full(2, np.nan),
            dissipated=move.dissipated + area * slid.lost,
            released=move.released + area * slid.released,
            instabilities=slid.instabilities,
            solution=solution,
            cell_area=area,
            by_pressure=by_pressure,
            new_contact=new,
        )

    def _supported(
        self, move: _Move, area: float, last: LateralState | None
    ) -> tuple[np.ndarray, np.ndarray, LateralSupport | None]:
        """Return the indenter's last place, its known move, and its support."""
        if self.given.control.held:
            at = move.target if move.at is None else move.at
            return at, move.target - at, None
        at = np.zeros(2) if move.at is None else move.at
        moved = np.zeros(2) if last is None else last.displacement - at
        spring = self.given.spring or 0.0
        force = spring * (move.target - at - moved) if spring else move.target
        x, y = (force / area).tolist()
        return at, moved, LateralSupport((x, y), spring / area)
