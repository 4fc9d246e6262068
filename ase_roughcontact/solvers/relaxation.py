"""Relaxation of a contact: states and results of solvers, and runs of a solver."""

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
    WithStatus,
)

# Largest force left in a relaxed state, relative to the largest force of the wall on an
# atom.
_MAX_RELATIVE_ERROR = 0.01
#: Rounding error of a force, in units of E* a0^2 or of the sum of the forces.
FORCE_ROUNDING = 1e-13

P = ParamSpec("P")

#: Pressure on the window, shape (n, m), and height of the indenter.
Start: TypeAlias = "tuple[np.ndarray, float]"


@dataclass(frozen=True)
class Relaxation(WithStatus):
    """Step of a solver, with its pressure, height and status.

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
        Convergence of `error` to the tolerance, or why there is no further step.
    pairs : float
        Number of forward and inverse FFT pairs since the last step, normalised to pairs
        on the grid of the half space; see `counts_pairs`.
    """

    pressure: np.ndarray
    height: float
    energy: float
    error: float
    status: Status
    pairs: float = 0.0


def counts_pairs(
    solver: Callable[P, Iterator[Relaxation]],
) -> Callable[P, Generator[Relaxation, None, None]]:
    """Decorate a solver, so that each `Relaxation` has its number of FFT pairs."""

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
            del state  # frees memory

    return counting


@dataclass(frozen=True, eq=False)
class Run(WithStatus):
    """Outcome of one run of a solver.

    Attributes
    ----------
    state : State
        Final state.
    fields : ContactState
        Energy, forces and fields of the state.
    support : Support
        Load and springs on the indenter.
    energy : float
        Energy of solid, wall, load and springs.
    max_force : float
        Largest force on an atom, or on the indenter if it is free.
    unbalanced : float
        Magnitude of the force on the indenter if it is free, otherwise zero.
    status : Status
        Convergence of the solver, or why it has not converged.
    iterations : int
        Number of steps.
    pairs : float
        Number of FFT pairs; see `Relaxation`.
    tolerance : float
        Largest force that the solver could leave.
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
    """Relaxation of a contact by a solver for the pressure.

    Attributes
    ----------
    solver : callable
        Generator function, such as `newton_krylov`.
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
            Contact on the window of the state.
        state : State
            Initial state, with the height of the indenter, or the first one under a
            load.
        support : Support
            Load and springs on the indenter.
        tolerance : float
            Largest force that may be left on an atom.
        max_steps : int
            Largest number of steps of the solver.
        start : (ndarray, float), optional
            Initial pressure and height, by default from the state.

        Returns
        -------
        Run
            Outcome, with the final state.
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
        with closing(states):  # frees the arrays of the solver
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
        """Yield the steps of the solver.

        The solver goes on with a smaller tolerance if the given tolerance is not small
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
            # at most half of the last tolerance, and not below half of the limit of
            # `is_relaxed` or 0.5 % of the error
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
        The contact.
    pressure : ndarray, shape (n, m), or float, or None
        Pressure on the window, or its largest magnitude; None stands for zero.
    force : float
        Largest remaining force.
    tolerance : float
        Tolerance of the force. The force must also be at most 1 % of the largest force
        of the wall on an atom, as a surface that is not relaxed would reach a tolerance
        above these forces or above the load.

    Returns
    -------
    bool
        Whether the force is below the tolerance and this limit.
    """
    return force < tolerance and force <= largest_error(contact, pressure)


def largest_error(contact: Contact, pressure: np.ndarray | float | None) -> float:
    """Return the largest force that a relaxed state may leave; see `is_relaxed`."""
    pressure = 0.0 if pressure is None else max_abs(np.asarray(pressure))
    least = FORCE_ROUNDING * contact.halfspace.contact_modulus
    return contact.halfspace.cell_area * max(_MAX_RELATIVE_ERROR * pressure, least)


def starting_point(
    contact: Contact, state: State, support: Support
) -> tuple[np.ndarray | None, float, float]:
    """Return the pressure from which a solver starts in a state.

    Parameters
    ----------
    contact : Contact
        The contact.
    state : State
        Initial state; its displacement may include padding.
    support : Support
        Load and springs on the indenter.

    Returns
    -------
    pressure : ndarray, shape (n, m), or None
        Initial pressure; None if the surface is flat.
    force : float
        Largest force. Under a hard wall it is infinity, as it is not known before the
        first step whether a state is relaxed.
    energy : float
        Energy. Under a hard wall it does not include the energy of the wall, and is NaN
        if the state has no displacement.
    """
    area, (n, m) = contact.halfspace.cell_area, state.pressure.shape
    if contact.wall.hard:
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
    if start is not None and not contact.wall.purely_hard:
        start = without_rounding(start)
    return start, force, energy


def fields_of(contact: Contact, state: State, relaxed: bool = False) -> ContactState:
    """Return energy, forces and fields of a state.

    Parameters
    ----------
    contact : Contact
        The contact.
    state : State
        The state.
    relaxed : bool
        Whether a solver has found the pressure: it is then the reaction of a hard wall.

    Returns
    -------
    ContactState
        Energy, forces and fields.
    """
    displacement = state.displacement
    if displacement is None:
        displacement = contact.halfspace.displacement(state.pressure)
    reaction = state.pressure if relaxed else None
    return contact.evaluate(displacement, state.height, state.pressure, reaction)


def checked_start(contact: Contact, start: np.ndarray | None) -> np.ndarray | None:
    """Return an initial pressure; raise `ValueError` if it has another shape."""
    if start is None:
        return None
    start, shape = finite_array("start", start), contact.halfspace.shape
    if start.shape != shape:
        raise ValueError(
            f"start must have the shape {shape} of the window, got {start.shape}"
        )
    return start


def force_per_gap(halfspace: HalfSpace) -> float:
    """Return the force on an atom that closes its gap, over the gap (force/length)."""
    return halfspace.cell_area / halfspace.self_compliance


def gap_tolerance(halfspace: HalfSpace, tolerance: float, largest_gap: float) -> float:
    """Return the gap that a force on an atom closes, at most `largest_gap` spacings."""
    return min(tolerance / force_per_gap(halfspace), largest_gap * halfspace.spacing)


def precision_advice(halfspace: HalfSpace) -> str:
    """Return advice against rounding errors in single precision; otherwise empty."""
    if halfspace.dtype == np.float64:
        return ""
    return "the transforms are in single precision: use fft dtype float64"


def indenter_stiffness(contact: Contact) -> float:
    """Return the stiffness ``2 E* a`` of a contact as wide as half of the window.

    The unit is force per length.
    """
    n, m = contact.halfspace.shape
    halfspace = contact.halfspace
    return halfspace.contact_modulus * halfspace.spacing * (n * m) ** 0.5
