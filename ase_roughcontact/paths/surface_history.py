"""The contact of a problem with what its surface has kept of earlier steps."""

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
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.relaxation import Run, fields_of

# Number of time steps of other lengths whose half spaces are kept.
_KEPT_HALFSPACES = 4


class SurfaceHistory:
    """Contact on the window of a state, with its plastic shape, creep and friction.

    Parameters
    ----------
    problem : Problem

    Attributes
    ----------
    contact : Contact
        Of the state given last.
    """

    contact: Contact

    def __init__(self, problem: Problem) -> None:
        self._problem, self._creep = problem, problem.solid.creep
        self._window: Box | None = None
        self._step = self._creep.over(0.0) if self._creep else None

    @property
    def softness(self) -> float:
        """Compliance of the solid in the present step, relative to that at rest."""
        return self._step.compliance if self._step else 1.0

    def begun(self, state: State, elapsed: float) -> State:
        """Return a state as a step finds it, some time after the last one."""
        check_past(state, self._creep)
        if self._creep is None:
            return state
        self._step = self._creep.over(elapsed)
        return replace(before_step(state, self._step), creep=self._creep)

    def on(self, state: State) -> State:
        """Make the contact of a state; return it with the depths that it has kept."""
        depth = state.plastic_depth
        if self._window != state.window:
            self.contact = self._problem.contact(state.window, depth)
            self._window = state.window
            self._instantaneous = self.contact.halfspace
            self._softened = lru_cache(_KEPT_HALFSPACES)(self._instantaneous.softened)
        if self._step is None:
            lowered, old = state.history.get(TRACTION_DEPTH), self.contact
            if old.plastic_depth is not depth or old.past_depth is not lowered:
                self.contact = old.changed(old.halfspace, depth, None, lowered)
            return state
        state = with_depths(state, self._instantaneous)
        halfspace = self._softened(self._step.compliance)
        self.contact = self.contact.changed(halfspace, depth, *past_of(state))
        return state

    def at_rest(self, state: State) -> State:
        """Make the contact of a state between steps, on the instantaneous solid."""
        if self._creep:
            self._step = self._creep.over(0.0)
        return self.on(state)

    def ended(self, run: Run) -> Run:
        """Return the outcome of a step with the history at its end."""
        if self._step is None:
            return run
        state = run.state
        if state.displacement is None:
            displacement = self.contact.halfspace.displacement(state.pressure)
            state = replace(state, displacement=np.asarray(displacement, dtype=float))
        state = self.at_rest(after_step(state, self._step))
        fields = fields_of(self.contact, state, relaxed=True)
        energy = fields.energy + run.support.external(state.height)[0]
        return replace(run, state=state, fields=fields, energy=energy)
