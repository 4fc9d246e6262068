"""Base class of the ASE optimizers that solve the contact problem on arrays."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterator
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, ClassVar

import numpy as np
from ase import Atoms
from ase.optimize.optimize import DEFAULT_MAX_STEPS, Optimizer

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.validation import instance_of
from ase_roughcontact.atoms.calculator import model_of, problem_of, uses_model
from ase_roughcontact.atoms.constraints import support_of
from ase_roughcontact.atoms.grid import displacement
from ase_roughcontact.contact import State
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.solvers.relaxation import (
    Relaxation,
    SolverRelaxer,
    is_relaxed,
    starting_point,
)
from ase_roughcontact.solvers.status import (
    CONVERGED,
    ENDED,
    STEP_LIMIT,
    UNFINISHED,
    Status,
)


class ContactOptimizer(Optimizer):
    """ASE optimizer around a solver for the pressure on the window.

    A subclass sets `solver` and the class attributes for the walls and constraints that
    the solver supports.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator.
    restart : None
        Not supported: the optimizer starts from the atoms.
    logfile, trajectory, append_trajectory, **kwargs
        See ASE's `Optimizer`.
    options : optional
        Options of the solver: `NewtonKrylovOptions` or `ActiveSetOptions`.

    Attributes
    ----------
    solver : callable
        Class attribute, set with `staticmethod`: a generator function
        ``solver(contact, *, height, external, start, tolerance)``, such as
        `newton_krylov`, that yields a `Relaxation` for each step. It also gets
        `options`, if they are given.
    hard_walls : bool
        Class attribute: whether the solver is for hard walls without attraction, or for
        all other walls; see `supports`.
    springs : bool
        Class attribute: whether the solver supports a `Hookean` on a free indenter.
    state : Relaxation or None
        Last state of the solver; None before the first step of a run.
    pairs : float
        Number of FFT pairs so far, normalised to pairs on the full padded grid.
    status : Status
        Convergence of the last run, or why it did not converge.

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact`, or the solver does not support its
        wall or a constraint.

    Notes
    -----
    `run` moves the atoms when observers are called and at the end, `irun` at every
    step. The calculator then has energy and forces of the atoms, also at the start
    unless atoms overlap with a hard wall.
    """

    solver: Callable[..., Generator[Relaxation, None, None]]
    hard_walls: ClassVar[bool] = False
    springs: ClassVar[bool] = True

    state: Relaxation | None
    _applied: Relaxation | None
    _states: Generator[Relaxation, None, None]

    def __init__(
        self,
        atoms: Atoms,
        restart: str | Path | None = None,
        logfile: IO | str | Path | None = None,
        trajectory: str | Path | None = None,
        append_trajectory: bool = False,
        *,
        options: Any = None,
        **kwargs: Any,
    ) -> None:
        if restart is not None:
            raise ValueError(
                f"{type(self).__name__} starts from the atoms: restart must be None"
            )
        instance_of(Atoms, atoms=atoms)
        super().__init__(atoms, None, logfile, trajectory, append_trajectory, **kwargs)
        self._writes_log = logfile is not None
        self.status, self.pairs = Status(UNFINISHED), 0.0
        self._relaxer = SolverRelaxer(type(self).solver, options)
        self._check()
        if problem_of(atoms)[0].wall.permanent:
            warn(
                "an optimizer does not keep the plastic shape of the surface from one "
                "run to the next: use load_path for a wall with permanent=True"
            )

    def run(self, fmax: float = 0.05, steps: int = DEFAULT_MAX_STEPS) -> bool:
        """Relax the atoms.

        Parameters
        ----------
        fmax : float
            Tolerance of the force on every atom (eV/Å). The remaining force is also at
            most 1 % of the largest force of the wall on an atom.
        steps : int
            Largest number of steps.

        Returns
        -------
        bool
            Whether the tolerance was reached. If not, `status` has the reason, and the
            atoms are in the best state that was found.
        """
        *_, converged = self._iterate(fmax, steps)
        return converged

    def irun(
        self, fmax: float = 0.05, steps: int = DEFAULT_MAX_STEPS
    ) -> Iterator[bool]:
        """Run as a generator, which yields after each step; see `run`.

        Yields
        ------
        bool
            Whether the tolerance was reached.
        """
        for converged in self._iterate(fmax, steps):
            self._move_atoms()
            yield converged

    @classmethod
    def supports(cls, wall: Interaction) -> bool:
        """Return whether the solver supports a wall."""
        return cls.hard_walls == wall.purely_hard

    @classmethod
    def check(cls, wall: Interaction, springs: bool = False) -> None:
        """Raise `ValueError` if the solver does not support a wall, or springs."""
        if not cls.supports(wall):
            if cls.hard_walls:
                raise ValueError(
                    f"{cls.__name__} is for the hard wall, got {wall}: relax it with "
                    "NewtonKrylov"
                )
            raise ValueError("a hard wall has no gradient: relax it with ActiveSet")
        if springs and not cls.springs:
            raise ValueError(
                f"{cls.__name__} does not support a spring on the indenter: give a "
                "constant load, or fix the height"
            )

    @classmethod
    def only_solves(cls) -> bool:
        """Return whether a subclass has no methods of its own for a run."""
        names = "__init__", "run", "irun", "step", "converged", "_iterate", "_start"
        return all(getattr(cls, n) is getattr(ContactOptimizer, n) for n in names)

    def step(self) -> None:
        """Do one step of the solver.

        Raises
        ------
        RuntimeError
            If the calculator of the atoms was changed since the run began.
        """
        if not uses_model(self.atoms, self._model):
            raise RuntimeError(
                "the calculator of the atoms was changed during the run: start it again"
            )
        state = next(self._states, None)
        if state is None:
            self.status = Status(ENDED)
            return
        self.state = state
        self.pairs += state.pairs
        self.status = state.status
        self._energy, self._force = state.energy, state.error
        if self.support.fixed:  # springs are not part of the problem
            self._energy += self.support.external(state.height)[0]
        if state.status.final:
            self._states.close()  # frees the arrays of the solver

    def converged(self, forces: np.ndarray | None = None) -> bool:
        """Return whether the last step reached the tolerance; forces are not used."""
        return self.status.converged

    @property
    def message(self) -> str:
        """Reason why the last run ended without convergence; otherwise empty."""
        return self.status.message

    def log(self, gradient: np.ndarray | None = None) -> None:
        """Write a line to the log file, if there is one."""
        if not self._writes_log:
            return
        name = type(self).__name__
        if self.nsteps == 0:
            head = f"{'':{len(name)}}  {'Step':>4} {'Time':>8} {'Energy':>15}"
            self.logfile.write(f"{head}  {'fmax':>12}\n")
        clock = time.strftime("%H:%M:%S")
        values = f"{self._energy:15.6f} {self._force:15.6f}"
        self.logfile.write(f"{name}:  {self.nsteps:3d} {clock} {values}\n")

    def call_observers(self) -> None:
        """Call the observers with the atoms in the last state."""
        if self.observers:
            self._move_atoms()
        super().call_observers()

    def _iterate(self, fmax: float, steps: int) -> Iterator[bool]:
        """Yield whether the tolerance was reached, at the start and after each step."""
        self.fmax, self.max_steps = fmax, self.nsteps + steps
        self._check()
        self._model = model_of(self.atoms)
        self.contact = self._model.contact
        pressure, height = self._start()
        relaxed = is_relaxed(self.contact, pressure, self._force, fmax)
        self.status = Status.of(relaxed)
        self._states = self._relaxer.states(
            self.contact, self.support, fmax, pressure, height
        )
        try:
            if self.nsteps == 0:
                self.log()
                if self.trajectory is None or self._traj_is_empty():
                    self.call_observers()
            yield self.status.converged
            while not self.status.final:
                if self.nsteps >= self.max_steps:
                    self.status = Status(STEP_LIMIT, {"steps": steps})
                    break
                self.step()
                self.nsteps += 1
                self.log()
                self.call_observers()
                yield self.status.converged
        finally:
            self._states.close()
            if self.state is not None or self.status.converged:
                self._move_atoms()

    def _check(self) -> None:
        """Read the constraints, and raise `ValueError` if the solver can't be used."""
        wall = problem_of(self.atoms)[0].wall
        self.check(wall)
        self.support = support_of(self.atoms)
        self.check(wall, self.support.springs is not None and not self.support.fixed)
        self.state = self._applied = None
        self.status = Status(UNFINISHED)

    def _start(self) -> tuple[np.ndarray | None, float]:
        """Return the first pressure, None for a flat surface, and the height.

        Energy and largest force of this state are set.
        """
        height = float(self.atoms.positions[-1, 2])
        values = displacement(self.atoms, self._model.grid)
        pressure = self._model.elastic_pressure(self.atoms)
        state = State(Box((0, 0), pressure.shape), height, pressure, values)
        first, self._force, self._energy = starting_point(
            self.contact, state, self.support
        )
        return first, height

    def _move_atoms(self) -> None:
        """Move the atoms to the last state, and calculate their results."""
        if not uses_model(self.atoms, self._model):
            return  # the state belongs to another problem
        state = self.state
        if state is None or state is self._applied:
            with suppress(ValueError):  # the first atoms may overlap with a hard wall
                self.atoms.get_potential_energy()
            return
        self._model.move(self.atoms, state.pressure, state.height)
        self.atoms.get_potential_energy()
        self._applied = state


def status_of(optimizer: Any, converged: bool) -> Status:
    """Return the status of an optimizer after a run.

    Parameters
    ----------
    optimizer : Optimizer
        `ContactOptimizer`, which has a status, or another optimizer of ASE.
    converged : bool
        Whether the optimizer has converged.
    """
    if converged:
        return Status(CONVERGED)
    if isinstance(optimizer, ContactOptimizer):
        return optimizer.status
    return Status(STEP_LIMIT, {"steps": int(optimizer.nsteps)})
