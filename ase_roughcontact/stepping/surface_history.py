"""The contact of a state, with the history of its surface."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from ase_roughcontact.contact import Contact, Problem, State
from ase_roughcontact.contact.creep import (
    after_step,
    before_step,
    check_past,
    past_of,
    with_depths,
)
from ase_roughcontact.contact.state import TRACTION_DEPTH
from ase_roughcontact.elasticity.creep import CreepStep
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.relaxation import Run, fields_of

# Number of half spaces that are kept, one for each duration of a time step.
_KEPT_HALFSPACES = 4


class SurfaceHistory:
    """Makes contacts on the window of a state, with plastic shape, creep and friction.

    The last contact is kept, since contacts on the same window share its half space.

    Parameters
    ----------
    problem : Problem
    """

    def __init__(self, problem: Problem) -> None:
        self._problem, self._creep = problem, problem.solid.creep
        self._window: Box | None = None
        self._contact: Contact

    def step(self, elapsed: float) -> CreepStep | None:
        """Return the creep of the solid over a time, None if it does not creep."""
        return self._creep.over(elapsed) if self._creep else None

    def begun(self, state: State, step: CreepStep | None) -> State:
        """Return a state at the start of a step, some time after the last one."""
        check_past(state, self._creep)
        if step is None:
            return state
        return replace(before_step(state, step), creep=self._creep)

    def contact(self, state: State, step: CreepStep | None) -> tuple[State, Contact]:
        """Return a state with the depths that it has kept, and its contact."""
        depth = state.plastic_depth
        if self._window != state.window:
            self._contact = self._problem.contact(state.window, depth)
            self._window = state.window
            self._instantaneous = self._contact.halfspace
            self._softened = lru_cache(_KEPT_HALFSPACES)(self._instantaneous.softened)
        last = self._contact
        if step is None:
            lowered = state.history.get(TRACTION_DEPTH)
            if last.plastic_depth is not depth or last.past_depth is not lowered:
                self._contact = last.changed(last.halfspace, depth, past_depth=lowered)
        else:
            state = with_depths(state, self._instantaneous)
            halfspace = self._softened(step.compliance)
            creep_pressure, creep_depth = past_of(state)
            self._contact = last.changed(halfspace, depth, creep_pressure, creep_depth)
        return state, self._contact

    def ended(
        self, run: Run, contact: Contact, step: CreepStep | None
    ) -> tuple[Run, Contact]:
        """Return the outcome of a step with the history at its end, and its contact.

        The contact is on the instantaneous solid.
        """
        if step is None:
            return run, contact
        state = run.state
        if state.displacement is None:
            displacement = contact.halfspace.displacement(state.pressure)
            state = replace(state, displacement=np.asarray(displacement, dtype=float))
        state, contact = self.contact(after_step(state, step), self.step(0.0))
        fields = fields_of(contact, state, relaxed=True)
        energy = fields.energy + run.support.external(state.height)[0]
        return replace(run, state=state, fields=fields, energy=energy), contact
