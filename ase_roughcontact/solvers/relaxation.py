"""Relaxation of a contact: what solvers take and return, and how they are run."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterator
from contextlib import closing
from dataclasses import dataclass, field, replace
from functools import partial, wraps
from typing import Any, ParamSpec, TypeAlias

import numpy as np

from ase_roughcontact._util.kernels import max_abs
from ase_roughcontact._util.validation import finite_array
from ase_roughcontact.contact import Contact, ContactState, State
from ase_roughcontact.contact.state import without_rounding
from ase_roughcontact.contact.support import Support
from ase_roughcontact.elasticity.fft import transformed_points
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.solvers.status import (
    CONVERGED,
    ENDED,
    STEP_LIMIT,
    UNFINISHED,
    Status,
)

# Largest error of a relaxed state, relative to the largest force of the wall on atoms,
# and, for rounding, in units of E* a0^2.
_LARGEST_ERROR, _ROUNDING = 0.01, 1e-13

P = ParamSpec("P")

#: Pressure on the window, shape (n, m), and height of the indenter.
Start: TypeAlias = "tuple[np.ndarray, float]"


@dataclass(frozen=True)
class Relaxation:
    """State of a relaxation.

    Attributes
    ----------
    pressure : ndarray, shape (n, m)
        Elastic pressure on the window, which determines the displacement.
    height : float
        Height of the indenter (length).
    energy : float
        Energy of half space, wall, load and springs.
    error : float
        Largest force on an atom, or on the indenter unless its height is fixed.
    status : Status
        Whether `error` is within the tolerance, or why there is no further step.
    pairs : float
        Forward and inverse FFT pairs since the last state, normalised to one pair on
        the grid of the half space; see `counts_pairs`.
    """

    pressure: np.ndarray
    height: float
    energy: float
    error: float
    status: Status
    pairs: float = 0.0

    @property
    def converged(self) -> bool:
        """Whether the error is within the tolerance."""
        return self.status.converged

    @property
    def message(self) -> str:
        """Reason why the solver stopped without convergence; empty otherwise."""
        return self.status.message


def counts_pairs(
    solver: Callable[P, Iterator[Relaxation]],
) -> Callable[P, Generator[Relaxation, None, None]]:
    """Decorate a solver, so that its states have the FFT pairs that they cost."""

    @wraps(solver)
    def counting(
        *args: P.args, **kwargs: P.kwargs
    ) -> Generator[Relaxation, None, None]:
        states = solver(*args, **kwargs)
        contact: Any = args[0] if args else kwargs["contact"]
        points = math.prod(contact.halfspace.grid)
        while True:
            before = transformed_points()
            state = next(states, None)
            if state is None:
                return
            spent = transformed_points() - before
            yield replace(state, pairs=spent / points)
            del state  # its memory is needed

    return counting


@dataclass(frozen=True, eq=False)
class Run:
    """Outcome of one run of a solver.

    Attributes
    ----------
    state : State
    fields : ContactState
        Energy, forces and fields of the state.
    support : Support
        What held the indenter.
    energy : float
        Energy of solid, wall, load and springs.
    max_force : float
        Largest force on an atom, or on the indenter if it is free.
    unbalanced : float
        Magnitude of the force on the indenter if it is free, else zero.
    status : Status
        Whether the solver has converged, or why it has not.
    iterations : int
    pairs : float
        FFT pairs; see `Relaxation`.
    tolerance : float
        Largest force that it allowed.
    constrained : bool
        Whether constraints held atoms of the surface.
    """

    state: State
    fields: ContactState
    support: Support
    energy: float
    max_force: float
    unbalanced: float
    status: Status = field(default_factory=partial(Status, CONVERGED))
    iterations: int = 0
    pairs: float = 0.0
    tolerance: float = math.inf
    constrained: bool = False

    @property
    def converged(self) -> bool:
        """Whether the solver has converged."""
        return self.status.converged

    @property
    def message(self) -> str:
        """Reason why the solver stopped without convergence; empty otherwise."""
        return self.status.message

    @classmethod
    def of(
        cls, state: State, fields: ContactState, support: Support, **outcome: Any
    ) -> Run:
        """Return the outcome of a run that ended in a state."""
        energy, force = support.external(state.height)
        unbalanced = 0.0 if support.fixed else abs(fields.normal_force + force)
        return cls(
            state=state,
            fields=fields,
            support=support,
            energy=fields.energy + energy,
            max_force=max(max_abs(fields.forces), unbalanced),
            unbalanced=unbalanced,
            **outcome,
        )


@dataclass(frozen=True)
class SolverRelaxer:
    """Relaxes a contact by a solver whose unknown is the pressure.

    Attributes
    ----------
    solver : callable
        Generator function as `newton_krylov`.
    options : optional
        Options of the solver.
    """

    solver: Callable[..., Generator[Relaxation, None, None]]
    options: Any = None

    def __call__(
        self,
        contact: Contact,
        state: State,
        support: Support,
        tolerance: float,
        max_steps: int,
        start: Start | None = None,
    ) -> Run:
        """Relax a contact from a state.

        Parameters
        ----------
        contact : Contact
            On the window of the state.
        state : State
            Its height is that of the indenter, or the first one under a load.
        support : Support
        tolerance : float
            Largest force that may be left on an atom.
        max_steps : int
            Largest number of steps of the solver.
        start : (ndarray, float), optional
            Pressure and height from which to start in place of those of the state.

        Returns
        -------
        Run
        """
        if start is None:
            pressure, force, _ = starting_point(contact, state, support)
            height = state.height
        else:
            (pressure, height), force = start, math.inf
            height = state.height if support.fixed else height
        last, pairs, steps = None, 0.0, 0
        status = Status.of(is_relaxed(contact, pressure, force, tolerance))
        states = self.states(contact, support, tolerance, pressure, height)
        with closing(states):  # frees its arrays
            while not status.final and steps < max_steps:
                found = next(states, None)
                if found is None:
                    status = Status(ENDED)
                    break
                last, steps, pairs = found, steps + 1, pairs + found.pairs
                status = last.status
        if not status.final:
            status = Status(STEP_LIMIT, {"steps": steps})
        if last is not None:
            displacement = contact.halfspace.displacement(last.pressure)
            state = replace(
                state,
                height=last.height,
                pressure=last.pressure,
                displacement=np.asarray(displacement, dtype=float),
            )
        fields = fields_of(contact, state, relaxed=last is not None)
        return Run.of(
            state, fields, support, status=status, iterations=steps, pairs=pairs
        )

    def states(
        self,
        contact: Contact,
        support: Support,
        tolerance: float,
        pressure: np.ndarray | None,
        height: float,
    ) -> Generator[Relaxation, None, None]:
        """Yield the states of the solver, one for each step.

        The solver goes on with a smaller tolerance if the one given is not small
        compared to the forces of the wall; see `is_relaxed`.
        """
        options = {} if self.options is None else {"options": self.options}
        state, relaxed = None, False
        while not relaxed:
            for state in self.solver(
                contact,
                height=height,
                external=None if support.fixed else support.external,
                start=pressure,
                tolerance=tolerance,
                **options,
            ):
                relaxed = is_relaxed(contact, state.pressure, state.error)
                if state.converged and not relaxed:
                    yield replace(state, status=Status(UNFINISHED))
                else:
                    yield state
            if state is None or not state.converged:
                return
            pressure, height = state.pressure, state.height
            # at most half of the last one, down to the least that `is_relaxed` requires
            tolerance = 0.5 * max(largest_error(contact, pressure), 0.01 * state.error)


def is_relaxed(
    contact: Contact,
    pressure: np.ndarray | float | None,
    force: float,
    tolerance: float = math.inf,
) -> bool:
    """Return whether the remaining force is small.

    Parameters
    ----------
    contact : Contact
    pressure : ndarray, shape (n, m), or float, or None
        Pressure on the window, or its largest magnitude; None stands for zero.
    force : float
        Largest remaining force.
    tolerance : float
        The force must be smaller, and at most 1 % of the largest force of the wall on
        an atom: a tolerance above these forces, or above the load, would be reached by
        a surface that is not relaxed.

    Returns
    -------
    bool
    """
    return force < tolerance and force <= largest_error(contact, pressure)


def largest_error(contact: Contact, pressure: np.ndarray | float | None) -> float:
    """Return the largest force that a relaxed state may leave; see `is_relaxed`."""
    pressure = 0.0 if pressure is None else max_abs(np.asarray(pressure))
    least = _ROUNDING * contact.halfspace.contact_modulus
    return contact.halfspace.cell_area * max(_LARGEST_ERROR * pressure, least)


def starting_point(
    contact: Contact, state: State, support: Support
) -> tuple[np.ndarray | None, float, float]:
    """Return the pressure from which a solver starts in a state.

    Parameters
    ----------
    contact : Contact
    state : State
        Its displacement, if it is known, may include padding.
    support : Support

    Returns
    -------
    pressure : ndarray, shape (n, m), or None
        None if the surface is flat.
    force : float
        Largest force. Under a hard wall it is infinity: whether a state is relaxed is
        not known before the first step.
    energy : float
        Under a hard wall without its energy, and NaN if the displacement is not known.
    """
    area, (n, m) = contact.halfspace.cell_area, state.pressure.shape
    if contact.interaction.hard:
        pressure, force = state.pressure, math.inf
        energy = math.nan
        if state.displacement is not None:
            work = float(np.sum(state.displacement[:n, :m] * pressure))
            energy = support.external(state.height)[0] - 0.5 * area * work
    else:
        run = Run.of(state, fields_of(contact, state), support)
        pressure = run.fields.pressure + run.fields.forces[:n, :m] / area
        force, energy = run.max_force, run.energy
    start = pressure if state.displaced else None
    if start is not None and not contact.interaction.purely_hard:
        start = without_rounding(start)
    return start, force, energy


def fields_of(contact: Contact, state: State, relaxed: bool = False) -> ContactState:
    """Return energy, forces and fields of a state.

    Parameters
    ----------
    contact : Contact
    state : State
    relaxed : bool
        Whether a solver has found the pressure, which a hard wall exerts then.

    Returns
    -------
    ContactState
    """
    displacement = state.displacement
    if displacement is None:
        displacement = contact.halfspace.displacement(state.pressure)
    reaction = state.pressure if relaxed else None
    return contact.evaluate(displacement, state.height, state.pressure, reaction)


def checked_start(contact: Contact, start: np.ndarray | None) -> np.ndarray | None:
    """Return an initial pressure, or raise `ValueError` if it is none of the window."""
    if start is None:
        return None
    start, shape = finite_array("start", start), contact.halfspace.shape
    if start.shape != shape:
        raise ValueError(
            f"start must have the shape {shape} of the window, got {start.shape}"
        )
    return start


def force_per_gap(halfspace: HalfSpace) -> float:
    """Return the force on an atom that closes a gap, per length."""
    return halfspace.cell_area / halfspace.self_compliance


def gap_tolerance(halfspace: HalfSpace, tolerance: float, largest_gap: float) -> float:
    """Return the gap of an atom that a force closes, at most that given in spacings."""
    return min(tolerance / force_per_gap(halfspace), largest_gap * halfspace.spacing)


def precision_advice(halfspace: HalfSpace) -> str:
    """Return the advice against rounding errors in single precision, else nothing."""
    if halfspace.dtype == np.float64:
        return ""
    return "the transforms are in single precision: use fft dtype float64"


def indenter_stiffness(contact: Contact) -> float:
    """Return the stiffness ``2 E* a`` (force per length) of half the window's width."""
    n, m = contact.halfspace.shape
    halfspace = contact.halfspace
    return halfspace.contact_modulus * halfspace.spacing * (n * m) ** 0.5
