"""The contact of a state, with the history of its surface."""

from __future__ import annotations

from collections.abc import Callable
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
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.relaxation import Run, fields_of

# Number of half spaces that are kept, one for each duration of a time step.
_KEPT_HALFSPACES = 4


class SurfaceHistory:
    """Makes contacts on the window of a state, with plastic shape, creep and friction.

    The last bare contact and its half spaces are kept, which contacts on the same
    window share.

    Parameters
    ----------
    problem : Problem
    """

    def __init__(self, problem: Problem) -> None:
        self._creep = problem.solid.creep

        @lru_cache(1)
        def bare(window: Box) -> tuple[Contact, Callable[[float], HalfSpace]]:
            """Return a contact without history, and half spaces by their compliance."""
            contact = problem.contact(window)
            return contact, lru_cache(_KEPT_HALFSPACES)(contact.halfspace.softened)

        self._bare = bare

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
        bare, softened = self._bare(state.window)
        depth, lowered = state.plastic_depth, state.history.get(TRACTION_DEPTH)
        if step is not None:
            state = with_depths(state, bare.halfspace)
            halfspace = softened(step.compliance)
            return state, bare.changed(halfspace, depth, *past_of(state))
        if depth is None and lowered is None:
            return state, bare
        return state, bare.changed(bare.halfspace, depth, None, lowered)

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
