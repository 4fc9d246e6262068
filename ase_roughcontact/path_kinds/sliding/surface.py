"""Surface of a sliding path: boxes of its tractions, half spaces, and its history."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np

from ase_roughcontact._util.history import entry_of
from ase_roughcontact.contact import Problem, State
from ase_roughcontact.contact.creep import CREEP_TRACTIONS
from ase_roughcontact.contact.state import LATERAL, TRACTIONS
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.elasticity.lattice import Box, carried
from ase_roughcontact.interactions.friction import FrictionLaw
from ase_roughcontact.interactions.local_friction import LocalFriction
from ase_roughcontact.path_kinds.sliding.lateral_state import LateralState
from ase_roughcontact.stepping.relaxed import RelaxedStep

# Number of boxes with half spaces that are kept.
_KEPT_HALFSPACES = 3


class SlidingSurface:
    """Surface with friction, with tractions only in a box around the contact.

    Parameters
    ----------
    problem : Problem
    law : FrictionLaw

    Raises
    ------
    NotImplementedError
        If the solid has no lateral components.
    """

    def __init__(self, problem: Problem, law: FrictionLaw) -> None:
        self.problem, self.law = problem, law

        @lru_cache(_KEPT_HALFSPACES)
        def halfspace(shape: tuple[int, int]) -> LateralHalfSpace:
            return LateralHalfSpace(
                shape,
                problem.spacing,
                problem.solid,
                problem.periodic,
                **problem.fft,
            )

        halfspace((2, 2))  # raises if the solid has no lateral components
        self.halfspace = halfspace

    def on_box(
        self, relaxed: RelaxedStep, before: State
    ) -> tuple[LocalFriction, Box, np.ndarray]:
        """Return friction, a box of all tractions, and tractions before the step.

        The box has also the tractions by which the solid has crept.
        """
        window, fields = relaxed.state.window, relaxed.fields
        law, problem = self.law, self.problem
        history = {
            entry.name: before.history[entry.name]
            for entry in law.histories
            if entry.name in before.history
        }

        def friction_on(box: Box) -> LocalFriction:
            return LocalFriction(
                law,
                carried(fields.pressure, window, box),
                carried(fields.contact, window, box),
                problem.spacing,
                problem.origin(box),
                {
                    name: carried(values, before.window, box, entry_of(name).entering)
                    for name, values in history.items()
                },
            )

        none = np.zeros(before.window.shape)
        old = [before.history.get(name, none) for name in TRACTIONS]
        box = window
        if not problem.periodic:
            sizes = sum((np.hypot(*each) for each in past_of(before)), np.hypot(*old))
            loaded = Box.bounding(sizes > 0.0, before.window.start)
            kept = fields.contact if law.histories else friction_on(box).bounds() > 0.0
            touching = Box.bounding(kept, window.start)
            box = touching.union(loaded) if touching else loaded or Box((0, 0), (1, 1))
        return friction_on(box), box, carried_vectors(old, before.window, box)

    def history(
        self,
        lateral: LateralState,
        window: Box,
        by_pressure: np.ndarray | float = 0.0,
    ) -> dict[str, np.ndarray]:
        """Return the history that a window keeps of a step.

        Parameters
        ----------
        lateral : LateralState
        window : Box
        by_pressure : ndarray, shape (2, n, m), or float
            Lateral displacement of the window by the pressure (length).
        """
        box, found = lateral.box, lateral.solution
        tractions = carried_vectors(found.tractions, box, window)
        displacement = found.displacement
        if box != window:
            loads = carried_vectors(lateral.loads, box, window)
            displacement = self.halfspace(window.shape).displacement(loads)
        displacement = displacement + by_pressure
        slipping = carried(found.slipping.astype(float), box, window)
        entries = (*tractions, *displacement, slipping)
        history = dict(zip(LATERAL, entries, strict=True))
        for entry in self.law.histories:
            values = lateral.friction.history[entry.name]
            history[entry.name] = carried(values, box, window, entry.entering)
        return history


def past_of(state: State) -> list[list[np.ndarray]]:
    """Return the tractions along x and y of each term of the creep."""
    count = state.creep.terms if state.creep else 0
    names = [[f"{axis}{k + 1}" for axis in CREEP_TRACTIONS] for k in range(count)]
    none = np.zeros(state.window.shape)
    return [[state.history.get(name, none) for name in pair] for pair in names]


def past_entries(
    past: Iterable[np.ndarray], box: Box, window: Box
) -> dict[str, np.ndarray]:
    """Return the history that a window keeps of the tractions of the past."""
    history = {}
    for k, vectors in enumerate(past):
        values = carried_vectors(vectors, box, window)
        for axis, component in zip(CREEP_TRACTIONS, values, strict=True):
            history[f"{axis}{k + 1}"] = component
    return history


def carried_vectors(vectors: Iterable[np.ndarray], box: Box, window: Box) -> np.ndarray:
    """Return both components of vectors on another box."""
    return np.stack([carried(each, box, window) for each in vectors])
