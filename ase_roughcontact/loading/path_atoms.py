"""Atoms of a contact problem: read as problem and state, and moved to states."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from ase import Atoms
from ase.constraints import FixAtoms
from ase.data import atomic_numbers
from ase.optimize.sciopt import OptimizerConvergenceError

from ase_roughcontact._util.validation import shown
from ase_roughcontact.atoms.calculator import (
    RoughContact,
    adopt_model,
    contact_of,
    model_of,
    state_of,
)
from ase_roughcontact.atoms.constraints import surface_held
from ase_roughcontact.atoms.exchange import set_window
from ase_roughcontact.atoms.grid import SurfaceGrid, displacement
from ase_roughcontact.atoms.history import set_history
from ase_roughcontact.atoms.info import INDENTER_KEY
from ase_roughcontact.atoms.model import ContactModel
from ase_roughcontact.atoms.substrate import supported
from ase_roughcontact.contact import Contact, Problem, State
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.contact.support import Support
from ase_roughcontact.elasticity.greens import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.loading.step_frame import FrameAtoms, StepFrame, step_frame
from ase_roughcontact.loading.trajectory import trajectory_writer
from ase_roughcontact.optimize.base import ContactOptimizer, status_of
from ase_roughcontact.optimize.optimizers import default_optimizer
from ase_roughcontact.optimize.settings import make_optimizer
from ase_roughcontact.solvers.relaxation import Run, SolverRelaxer, Start
from ase_roughcontact.solvers.status import Status, StatusKind
from ase_roughcontact.stepping.options import Relaxer
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.topography.base import surface_id

#: Kinds of a status of an optimizer that has not converged.
ENERGY_ROSE = StatusKind(
    "the energy has risen from {first:.4g} to {last:.4g} eV in {steps} steps of the "
    "optimizer",
    "it needs smaller steps, see settings_for",
)
OPTIMIZER_ENDED = StatusKind("{reason}")


class PathAtoms:
    """Atoms that follow the states of a path.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator. They are moved.

    Attributes
    ----------
    problem : Problem
        Contact problem of the atoms.
    """

    def __init__(self, atoms: Atoms) -> None:
        self.atoms = atoms
        self.problem = model_of(atoms).problem
        # state of the atoms at the start of the path
        self._first: State | None = None
        # present state of the atoms
        self._reached: State | None = None

    def first_state(self) -> State:
        """Return the state of the atoms."""
        self._first = self._reached = state_of(self.atoms)
        return self._first

    def place(self, contact: Contact, state: State) -> None:
        """Move the atoms to a state.

        Parameters
        ----------
        contact : Contact
            Contact on the window of the state.
        state : State
        """
        atoms, self._reached = self.atoms, None
        grid, values = SurfaceGrid.of(atoms), None
        window = self.problem.window(grid.window, grid.origin)
        # the padding has no history, which a step in time needs
        drop = self.problem.solid.creep is not None and grid.shape != grid.window
        if drop or window != state.window:
            set_window(atoms, state.window)
            grid = SurfaceGrid.of(atoms)
        set_history(atoms, grid, state.history, state.creep)
        if grid.shape == grid.window:
            model = ContactModel(grid, self.problem, contact, history=state.history)
            adopt_model(atoms, model)
            values = state.displacement
        model_of(atoms).move(atoms, state.pressure, state.height, values)

    def relax(
        self,
        optimizer: Callable[..., Any],
        contact: Contact,
        state: State,
        support: Support,
        tolerance: float,
        max_steps: int,
        start: Start | None = None,
    ) -> Run:
        """Relax the atoms from a state by an optimizer of ASE; see `SolverRelaxer`.

        It is called as ``optimizer(atoms, logfile=None)``. If the energy rises, or an
        error is raised, the atoms are in the first state again.
        """
        atoms, (n, m) = self.atoms, state.window.shape
        self.place(contact, state)
        if not support.fixed:
            atoms.calc.set(load=support.load)
        run = make_optimizer(optimizer, atoms)
        ours = isinstance(run, ContactOptimizer)
        counts = run if ours else contact_of(atoms).halfspace
        before = counts.pairs
        try:
            first = _energy_of(run)
            status = _status_of_run(run, tolerance, max_steps)
            last = _energy_of(run)
        except Exception:
            self.place(contact, state)
            raise
        steps = int(run.nsteps)
        if not (status.converged or last <= first):
            numbers = {"first": first, "last": last, "steps": steps}
            status = Status(ENERGY_ROSE, numbers)
            self.place(contact, state)
        fields, model = atoms.calc.state(atoms), model_of(atoms)
        self._reached = replace(
            state,
            height=float(atoms.positions[-1, 2]),
            pressure=fields.pressure + fields.forces[:n, :m] / fields.cell_area,
            displacement=displacement(atoms, model.grid)[:n, :m],
        ).in_order()
        pairs = float(counts.pairs - before)
        forces = atoms.get_forces()  # zero on atoms that the user has fixed
        return Run(
            state=self._reached,
            fields=fields,
            support=support,
            energy=float(atoms.get_potential_energy()),
            max_force=float((forces**2).sum(axis=1).max() ** 0.5),
            unbalanced=abs(float(forces[-1, 2])),
            status=status,
            iterations=steps,
            pairs=pairs,
            constrained=surface_held(atoms),
        )

    def show_first(self) -> None:
        """Move the atoms back to the state from which the path starts."""
        first = self._first
        if first is not None and self._reached is not first:
            contact = self.problem.contact(first.window, first.plastic_depth)
            self.place(contact, first)
            self._reached = first

    def show(self, relaxed: RelaxedStep) -> None:
        """Move the atoms to the state in which a step leaves the surface."""
        if self._reached is None or not _is_same(relaxed.state, self._reached):
            self.place(relaxed.contact, relaxed.state)
            self._reached, model = relaxed.state, model_of(self.atoms)
            if model.contact is relaxed.contact:
                model.fields = relaxed.fields
        if relaxed.control == LOAD:
            self.atoms.calc.set(load=relaxed.run.support.load)
        self.atoms.get_potential_energy()

    writer = staticmethod(trajectory_writer)

    def frame(self, relaxed: RelaxedStep, **info: Any) -> StepFrame:
        """Return the frame of a step as it leaves the surface."""
        self.show(relaxed)
        return step_frame(relaxed, FrameAtoms.of(self.atoms), **info)


def _is_same(a: State, b: State) -> bool:
    """Return whether two states have the same contact, in the same arrays."""
    if a.height != b.height or a.history.keys() != b.history.keys():
        return False
    same = a.pressure is b.pressure and a.displacement is b.displacement
    return same and all(a.history[key] is b.history[key] for key in a.history)


class ProblemAtoms(PathAtoms):
    """Atoms of a problem, made when they are needed, and flat.

    Parameters
    ----------
    problem : Problem
    window : Box
    symbol : str
        Chemical symbol of the surface atoms.
    fixed : bool
        Whether the indenter is fixed.
    padded : bool
        Whether the atoms have the padding of a free half space, which optimizers of ASE
        need.
    """

    def __init__(
        self,
        problem: Problem,
        window: Box,
        symbol: str,
        fixed: bool,
        padded: bool = False,
    ) -> None:
        self.problem, self._padded = problem, padded
        self._first, self._reached = None, None
        self._first_window, self._fixed = window, fixed
        self._number = atomic_numbers[symbol]

    @cached_property
    def atoms(self) -> Atoms:
        """The surface atoms and the indenter."""
        problem, window = self.problem, self._first_window
        shape = window.shape
        if self._padded:
            shape = SurfaceGrid.padded_shape(shape, problem.periodic)
        origin = problem.origin(window)
        grid = SurfaceGrid(
            window.shape, shape, problem.spacing, origin, problem.periodic
        )
        atoms = grid.atoms(self._number, 0.0)
        supported(atoms, problem.indenter, self._fixed)
        solid: dict[str, Any] = {"solid": problem.solid}
        if problem.solid == Isotropic(problem.solid.contact_modulus):
            solid = {"contact_modulus": problem.solid.contact_modulus}
        atoms.calc = RoughContact(
            problem.indenter,
            wall=problem.wall,
            heterogeneity=problem.heterogeneity,
            fft=dict(problem.fft),
            **solid,
        )
        return atoms

    def frame(self, relaxed: RelaxedStep, **info: Any) -> StepFrame:
        """Return the frame of a step as it leaves the surface, without these atoms."""
        problem, shape = self.problem, relaxed.state.window.shape
        origin = problem.origin(relaxed.state.window)
        grid = SurfaceGrid(shape, shape, problem.spacing, origin, problem.periodic)
        return step_frame(
            relaxed,
            FrameAtoms(
                number=self._number,
                axis=(-origin[0], -origin[1]),
                cell=np.diag(grid.sides),
                constraints=[FixAtoms([math.prod(shape)])] if self._fixed else [],
                info=self._info,
            ),
            **info,
        )

    @cached_property
    def _info(self) -> dict[str, Any]:
        """The `info` of the atoms."""
        identity = surface_id(self.problem.indenter)
        return {} if identity is None else {INDENTER_KEY: identity}


def relaxer_of(
    optimizer: Callable[..., Any] | None,
    wall: Interaction,
    atoms: PathAtoms,
    springs: bool = False,
) -> Relaxer:
    """Return the function that relaxes the steps of a path.

    Parameters
    ----------
    optimizer : callable, optional
        See `load_path`.
    wall : Interaction
    atoms : PathAtoms
        The atoms that an optimizer of ASE moves.
    springs : bool
        Whether there are springs on a free indenter.

    Returns
    -------
    Relaxer
        The solver of one of our optimizers, which needs no atoms, or the optimizer.

    Raises
    ------
    ValueError
        If it is not callable, or the solver is not for the wall or the springs.
    """
    if not (optimizer is None or callable(optimizer)):
        raise ValueError(
            "optimizer must be a class, or a function called as optimizer(atoms, "
            f"logfile=None), got {shown(optimizer)}"
        )
    optimizer = optimizer or default_optimizer(wall)
    kind: Any = optimizer
    options: dict[str, Any] = {}
    if isinstance(kind, partial) and not kind.args:
        kind, options = kind.func, kind.keywords
    ours = isinstance(kind, type) and issubclass(kind, ContactOptimizer)
    if ours and kind.only_solves() and options.keys() <= {"options"}:
        kind.check(wall, springs)
        return SolverRelaxer(kind.solver, **options)
    return partial(atoms.relax, optimizer)


def _status_of_run(optimizer: Any, fmax: float, steps: int) -> Status:
    """Run an optimizer of ASE; return whether it has converged, or why it has not."""
    try:
        converged = bool(optimizer.run(fmax=fmax, steps=steps))
    except OptimizerConvergenceError as error:  # raised by optimizers of SciPy
        return Status(OPTIMIZER_ENDED, {"reason": str(error)})
    return status_of(optimizer, converged)


def _energy_of(optimizer: Any) -> float:
    """Return the energy at which an optimizer of ASE is; of ours, minus infinity.

    The atoms move there, if the optimizer works on other coordinates.
    """
    (atoms,) = optimizer.optimizable.iterimages()
    if isinstance(optimizer, ContactOptimizer):  # they never raise it
        return -math.inf
    return float(atoms.get_potential_energy())
