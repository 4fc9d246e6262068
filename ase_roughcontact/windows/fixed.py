"""Fixed windows: never exchanged, but their edge is checked."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ase_roughcontact._util.units import with_unit
from ase_roughcontact.contact import Contact, Problem, State
from ase_roughcontact.contact.support import Support
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.relaxation import Run
from ase_roughcontact.topography import RoughSphere


class WindowedState(NamedTuple):
    """State on the window of a step.

    Attributes
    ----------
    state : State
    level : float
        Height of the undeformed indenter, counted from its own zero, up to which the
        window contains its atoms (length).
    """

    state: State
    level: float


class FixedWindow:
    """Window that is the same for all steps, with methods as in `AutoWindow`.

    Parameters
    ----------
    problem : Problem
    window : Box
    checked : bool
        Whether the wall may not act on an atom at the edge of the window of a free half
        space.
    first_contact : float
        Height at which the indenter begins to repel the flat substrate (length).
    """

    def __init__(
        self, problem: Problem, window: Box, checked: bool, first_contact: float
    ) -> None:
        self._problem, self._window, self._checked = problem, window, checked
        self.first_contact = first_contact

    def choose(self, state: State, support: Support, last: float) -> WindowedState:
        """Return the state; its window stays."""
        return WindowedState(state, math.inf)

    def enlarged(self, run: Run, contact: Contact, window_level: float) -> None:
        """Raise `RuntimeError` if the wall acts at the edge in a relaxed state."""
        if not (self._checked and run.converged) or self._problem.periodic:
            return
        acts = run.fields.pressure != 0.0
        if at_edge(acts):
            advice = "give a larger shape or window='auto' (in a scene shape = 'auto')"
            if not isinstance(self._problem.indenter, RoughSphere):
                advice += ", or window='unchecked' if the indenter ends there"
            load, depth = run.fields.normal_force, self.first_contact - run.state.height
            raise RuntimeError(
                f"at a load of {with_unit(load, 'nN')} and a depth of {depth:.4g} Å "
                "the contact or its attraction reaches the edge of the window of "
                f"{acts.shape} atoms: {advice}"
            )

    def check(self, height: float) -> None:
        """Do nothing, as the window is the same at all heights; see `AutoWindow`."""

    def describe_lattice(self) -> dict[str, Any]:
        """Return a description of the atoms' lattice, for resuming a path."""
        return {
            "window": self._window.shape,
            "spacing": self._problem.spacing,
            "origin": self._problem.origin(self._window),
            "periodic": self._problem.periodic,
        }


def at_edge(mask: np.ndarray) -> bool:
    """Return whether a mask of the atoms of a window is true at its edge."""
    return bool(mask[[0, -1]].any() or mask[:, [0, -1]].any())
