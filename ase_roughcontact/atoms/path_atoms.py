"""Atoms of a contact problem: read as problem and state, and moved to states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from ase import Atoms
from ase.data import atomic_numbers

from ase_roughcontact._util.validation import shown
from ase_roughcontact.atoms.calculator import (
    RoughContact,
    adopt_model,
    adopt_results,
    calculator_of,
    has_results,
    model_of,
)
from ase_roughcontact.atoms.exchange import set_window
from ase_roughcontact.atoms.grid import SurfaceGrid, displacement, set_displacement
from ase_roughcontact.atoms.history import creep_of, history_of, set_history
from ase_roughcontact.atoms.model import ContactModel, problem_for
from ase_roughcontact.atoms.snapshot import pressure_of, snapshot
from ase_roughcontact.atoms.substrate import in_cell, surface_atoms
from ase_roughcontact.atoms.trajectory import read_frames, trajectory_writer
from ase_roughcontact.contact import Contact, Problem, State
from ase_roughcontact.elasticity.greens import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.optimize.base import ContactOptimizer
from ase_roughcontact.optimize.optimizers import default_optimizer
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.paths.step_options import Relaxer
from ase_roughcontact.solvers.relaxation import Run, SolverRelaxer, Start, Support
from ase_roughcontact.topography.facts import surface_id


def problem_of(atoms: Atoms) -> tuple[Problem, Box]:
    """Return the contact problem of atoms, and their window.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator.

    Returns
    -------
    Problem, Box
    """
    grid = SurfaceGrid.of(atoms)
    problem = problem_for(grid, calculator_of(atoms).parameters)
    return problem, problem.window(grid.window, grid.origin)


class PathAtoms:
    """Atoms that follow the states of a path.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator. They are moved.

    Attributes
    ----------
    problem : Problem
        Of the atoms.
    """

    def __init__(self, atoms: Atoms) -> None:
        self.atoms = atoms
        self.problem = model_of(atoms).problem
        self._shown: State | None = None  # the state in which the atoms are

    @property
    def window(self) -> Box:
        """Window of the atoms."""
        return problem_of(self.atoms)[1]

    def first_state(self) -> State:
        """Return the state of the atoms."""
        model = model_of(self.atoms)
        grid, (n, m) = model.grid, model.grid.window
        self._shown = State(
            self.problem.window(grid.window, grid.origin),
            float(self.atoms.positions[-1, 2]),
            model.elastic_pressure(self.atoms),
            displacement(self.atoms, grid)[:n, :m].copy(),
            history_of(self.atoms, grid),
            creep=creep_of(self.atoms),
        )
        return self._shown

    def moved_to(self, state: State | None) -> None:
        """Take note of a state to which the atoms were moved; None if it is unknown."""
        self._shown = state

    def place(self, contact: Contact, state: State) -> None:
        """Move the atoms to a state.

        Parameters
        ----------
        contact : Contact
            On the window of the state.
        state : State
        """
        atoms, shown, self._shown = self.atoms, self._shown, state
        if shown is None or shown.window != state.window:
            if self.window != state.window:
                set_window(atoms, state.window)
            shown = None
        atoms.positions[-1, 2] = state.height
        grid = SurfaceGrid.of(atoms) if shown is None else model_of(atoms).grid
        if shown is None or shown.history is not state.history:
            set_history(atoms, grid, state.history, state.creep)
        if grid.shape != grid.window and contact.past_depth is not None:
            model_of(atoms).follow(contact, state.history)
        if grid.shape == grid.window:
            self._adopt_model(grid, contact, state, shown)
        elif shown is None or shown.pressure is not state.pressure:
            model_of(atoms).apply_pressure(atoms, state.pressure, state.height)

    def show(self, stepper: Stepper) -> None:
        """Move the atoms to the last state of a path, with its results."""
        calc, run, state = self.atoms.calc, stepper.run, stepper.state
        if state is not self._shown or not self._is_at(state):
            self._shown = None
            self.place(stepper.contact, state)
        if stepper.control == "loads" and run is not None:
            calc.set(load=run.support.load)
        if run is None or has_results(self.atoms, run.fields):
            return
        same_shape = run.fields.forces.size == len(self.atoms) - 1
        if same_shape and run.state.history is state.history:
            adopt_results(self.atoms, run.fields)
        else:
            self.atoms.get_potential_energy()

    def _is_at(self, state: State) -> bool:
        """Return whether nobody else has moved the atoms from a state."""
        if self.atoms.positions[-1, 2] != state.height or state.displacement is None:
            return False
        n, m = state.window.shape
        values = displacement(self.atoms, SurfaceGrid.of(self.atoms))[:n, :m]
        return values.shape == (n, m) and np.allclose(
            values, state.displacement, rtol=0.0, atol=1e-9 * self.problem.spacing
        )

    read = staticmethod(read_frames)
    writer = staticmethod(trajectory_writer)

    def frame(self, stepper: Stepper, **info: Any) -> Atoms:
        """Return the frame of the last state of a path; see `snapshot`."""
        self.show(stepper)
        return snapshot(self.atoms, **info)

    def state(self, frame: Atoms) -> State:
        """Return the state of a frame."""
        grid = SurfaceGrid.of(frame)
        n, m = grid.window
        forces = frame.get_forces(apply_constraint=False)[:-1, 2].reshape(n, m)
        return State(
            self.problem.window(grid.window, grid.origin),
            float(frame.positions[-1, 2]),
            pressure_of(frame) + forces / self.problem.spacing**2,
            displacement(frame, grid).copy(),
            history_of(frame, grid),
            creep=creep_of(frame),
        )

    def _adopt_model(
        self, grid: SurfaceGrid, contact: Contact, state: State, shown: State | None
    ) -> None:
        """Give the calculator the contact of the path, and the atoms their z."""
        values = state.displacement
        if values is None:
            values = contact.halfspace.displacement(state.pressure)
            values = np.asarray(values, dtype=float)
        known = values, state.height, state.pressure
        if shown is None or shown.pressure is not state.pressure:
            set_displacement(self.atoms, values)
        model = ContactModel.adopted(grid, self.problem, contact, known, state.history)
        adopt_model(self.atoms, model)


class ProblemAtoms(PathAtoms):
    """Atoms of a problem, made when they are needed, flat and without padding.

    Parameters
    ----------
    problem : Problem
    window : Box
    symbol : str
        Chemical symbol of the surface atoms.
    fixed : bool
        Whether the indenter is fixed.
    """

    def __init__(self, problem: Problem, window: Box, symbol: str, fixed: bool) -> None:
        self.problem, self._shown = problem, None
        self._first_window, self._symbol, self._fixed = window, symbol, fixed

    @cached_property
    def atoms(self) -> Atoms:
        """The surface atoms and the indenter."""
        problem, window = self.problem, self._first_window
        (x, y), spacing = problem.origin(window), problem.spacing
        atoms = in_cell(
            surface_atoms(atomic_numbers[self._symbol], window.shape, spacing),
            window.shape,
            spacing,
            (-x, -y, 0.0),
            problem.periodic,
            self._fixed,
            surface_id(problem.indenter),
        )
        solid: dict[str, Any] = {"solid": problem.solid}
        if problem.solid == Isotropic(problem.solid.contact_modulus):
            solid = {"contact_modulus": problem.solid.contact_modulus}
        atoms.calc = RoughContact(
            problem.indenter,
            interaction=problem.wall,
            heterogeneity=problem.heterogeneity,
            fft=dict(problem.fft),
            **solid,
        )
        return atoms


class OptimizerRelaxer:
    """Relaxes the atoms of a path by an optimizer of ASE.

    Parameters
    ----------
    atoms : PathAtoms
    optimizer : callable
        Called as ``optimizer(atoms, logfile=None)``.
    """

    def __init__(self, atoms: PathAtoms, optimizer: Callable[..., Any]) -> None:
        self._path_atoms, self._optimizer = atoms, optimizer

    def __call__(
        self,
        contact: Contact,
        state: State,
        support: Support,
        tolerance: float,
        max_steps: int,
        start: Start | None = None,
    ) -> Run:
        """Relax the atoms from a state; see `SolverRelaxer`."""
        atoms = self._path_atoms.atoms
        self._path_atoms.place(contact, state)
        self._path_atoms.moved_to(None)  # if the optimizer raises an error
        if not support.fixed:
            atoms.calc.set(load=support.load)
        optimizer = self._optimizer(atoms, logfile=None)
        counts = hasattr(optimizer, "pairs")
        halfspace = model_of(atoms).contact.halfspace
        before = 0 if counts else halfspace.pairs
        converged = bool(optimizer.run(fmax=tolerance, steps=max_steps))
        for _ in optimizer.optimizable.iterimages():
            pass  # moves the atoms if the optimizer works on other coordinates
        steps = int(optimizer.nsteps)
        pairs = optimizer.pairs if counts else halfspace.pairs
        message = ""
        if not converged:
            default = f"not converged after {steps} steps"
            message = getattr(optimizer, "message", default)
        fields, forces = atoms.calc.state(atoms), atoms.get_forces()
        relaxed = self._relaxed(state)
        return Run(
            state=relaxed,
            fields=fields,
            support=support,
            energy=float(atoms.get_potential_energy()),
            max_force=float((forces**2).sum(axis=1).max() ** 0.5),
            unbalanced=abs(float(forces[-1, 2])),
            converged=converged,
            message=message,
            iterations=steps,
            pairs=float(pairs - before),
        )

    def _relaxed(self, before: State) -> State:
        """Return the state of the relaxed atoms."""
        atoms, (n, m) = self._path_atoms.atoms, before.window.shape
        fields, model = atoms.calc.state(atoms), model_of(atoms)
        elastic = fields.pressure + fields.forces[:n, :m] / fields.cell_area
        state = replace(
            before,
            height=float(atoms.positions[-1, 2]),
            pressure=elastic,
            displacement=displacement(atoms, model.grid)[:n, :m].copy(),
        )
        self._path_atoms.moved_to(state)
        return state


def relaxer_of(
    optimizer: Callable[..., Any] | None,
    wall: Interaction,
    atoms: PathAtoms,
    springs: bool = False,
) -> Relaxer:
    """Return what relaxes the steps of a path.

    Parameters
    ----------
    optimizer : callable, optional
        See `load_path`.
    wall : Interaction
    atoms : PathAtoms
        On which an optimizer of ASE works.
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
    return OptimizerRelaxer(atoms, optimizer)
