"""Solvers of the half space as ASE optimizers."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
from ase import Atoms
from ase.optimize.optimize import DEFAULT_MAX_STEPS, Optimizer
from ase.utils.abc import Optimizable

from ase_roughcontact._util.kernels import dot
from ase_roughcontact.atoms.grid import displacement, set_displacement
from ase_roughcontact.optimize.constraints import Indenter, contact_of
from ase_roughcontact.solvers.hard_wall import (
    OptimalityResiduals,
    active_set,
    optimality_residuals,
)
from ase_roughcontact.solvers.newton import newton_krylov
from ase_roughcontact.solvers.relaxation import Relaxation, without_rounding


class Window(Optimizable):
    """Pressure on the window and height of the indenter, where a solver has them.

    The displacement of all atoms follows from the pressure; the atoms are moved by
    `write`, and when somebody looks at them through `iterimages`.
    """

    state: Relaxation | None
    _written: Relaxation | None

    def __init__(self, atoms: Atoms, *, hard: bool) -> None:
        self.atoms = atoms
        self._hard = hard
        self._connect()
        self._known: tuple[np.ndarray | None, float, float] | None = None

    def read(self) -> None:
        """Begin from where the atoms are, under their load and constraints."""
        self._connect()
        self._known = None

    @property
    def start(self) -> np.ndarray | None:
        """Pressure, shape (n, m), that holds the atoms; None where they are flat."""
        return self._beginning()[0]

    def ndofs(self) -> int:
        """Return the number of atoms in the window, and one for the indenter."""
        return self.contact.heights.size + 1

    def get_x(self) -> np.ndarray:
        """Return displacement and height, shape (ndofs,)."""
        self.write()
        n, m = self.contact.heights.shape
        values = displacement(self.atoms, self.atoms.calc.layout(self.atoms))
        return np.append(values[:n, :m].ravel(), self.atoms.positions[-1, 2])

    def set_x(self, x: np.ndarray) -> None:
        """Refuse: the solver alone moves the atoms."""
        raise ValueError("the state of a solver can't be set from outside")

    def get_gradient(self) -> np.ndarray:
        """Return the largest force that is left, as the only entry of a gradient."""
        error = self._beginning()[2] if self.state is None else self.state.error
        return np.array([error])

    def get_value(self) -> float:
        """Return the energy (eV)."""
        if self.state is None:
            return self._beginning()[1]
        held = self.indenter.fixed  # then load and springs are not the solver's
        outside = self.indenter.external(self.state.height)[0] if held else 0.0
        return self.state.energy + outside

    def gradient_norm(self, gradient: np.ndarray) -> float:
        """Largest force on any atom (eV/Å)."""
        return float(np.abs(gradient).max())

    def iterimages(self) -> Iterator[Atoms]:
        """Yield the atoms, moved to where the solver is.

        Energy and forces are known, unless a hard wall has not been relaxed at all.
        """
        self.write()
        if not self._hard or self.state is not None:
            self.atoms.get_potential_energy()
        yield self.atoms

    def write(self) -> None:
        """Move the atoms to where the solver is, the margin included."""
        if self.state is None or self.state is self._written:
            return
        values = self.contact.halfspace.padded_displacement(self.state.pressure)
        set_displacement(self.atoms, values)
        self.atoms.positions[-1, 2] = self.state.height
        self.atoms.calc.hold(self.atoms, self.state.pressure)
        self._written = self.state

    def _connect(self) -> None:
        self.contact = contact_of(self.atoms, hard=self._hard)
        self.indenter = Indenter(self.atoms)
        self.state = self._written = None

    def _beginning(self) -> tuple[np.ndarray | None, float, float]:
        """Pressure, energy and largest force of the atoms as they are."""
        if self._known is None:
            height = float(self.atoms.positions[-1, 2])
            values = displacement(self.atoms, self.atoms.calc.layout(self.atoms))
            pressure = self.atoms.calc.elastic_pressure(self.atoms)
            begin = self._hard_beginning if self._hard else self._soft_beginning
            pressure, energy, error = begin(values, height, pressure)
            start = without_rounding(pressure) if np.ptp(values) > 0.0 else None
            self._known = start, energy + self.indenter.external(height)[0], error
        return self._known

    def _soft_beginning(
        self, values: np.ndarray, height: float, pressure: np.ndarray
    ) -> tuple[np.ndarray, float, float]:
        state = self.contact.evaluate(values, height, pressure)
        n, m = state.pressure.shape
        pressure = state.pressure + state.forces[:n, :m] / state.cell_area
        error = float(np.abs(state.forces).max())
        if not self.indenter.fixed:
            force = state.normal_force + self.indenter.external(height)[1]
            error = max(error, abs(force))
        return pressure, state.energy, error

    def _hard_beginning(
        self, values: np.ndarray, height: float, pressure: np.ndarray
    ) -> tuple[np.ndarray, float, float]:
        """Tell all but the force: whether it is relaxed the solver has to find out."""
        n, m = pressure.shape
        area = self.contact.halfspace.cell_area
        return pressure, -0.5 * area * dot(values[:n, :m], pressure), np.inf


class WindowOptimizer(Optimizer):
    """ASE optimizer around a solver that knows the half space.

    Attributes
    ----------
    pairs : float
        Padded transform pairs spent so far, in units of a pair on the whole window.
    message : str
        Why the solver stopped, empty while it goes on.
    """

    optimizable: Window
    _hard: bool
    _solver: Callable[..., Generator[Relaxation, None, None]]

    def __init__(
        self,
        atoms: Atoms,
        restart: str | Path | None = None,
        logfile: IO | str | Path | None = None,
        trajectory: str | Path | None = None,
        append_trajectory: bool = False,
        **kwargs: Any,
    ) -> None:
        if restart is not None:
            raise ValueError(
                f"{type(self).__name__} restarts from the atoms: restart must be None"
            )
        # in place of the atoms, so that a trajectory is written through `iterimages`
        window = Window(atoms, hard=self._hard)
        super().__init__(window, None, logfile, trajectory, append_trajectory, **kwargs)
        self.pairs = 0.0
        self.message = ""

    def irun(
        self, fmax: float = 0.05, steps: int = DEFAULT_MAX_STEPS
    ) -> Iterator[bool]:
        """Run as a generator; see `run`."""
        window = self.optimizable
        window.read()
        self.message = ""
        self._states = type(self)._solver(
            window.contact,
            height=float(window.atoms.positions[-1, 2]),
            external=None if window.indenter.fixed else window.indenter.external,
            start=window.start,
            tolerance=fmax,
        )
        converged = False
        try:
            for converged in super().irun(fmax, steps):
                yield converged
                if self.message:
                    return
            if not converged:
                self.message = f"not converged after {steps} steps"
        finally:
            self.optimizable.write()

    def run(self, fmax: float = 0.05, steps: int = DEFAULT_MAX_STEPS) -> bool:
        """Relax the atoms.

        Parameters
        ----------
        fmax : float
            Tolerance of the force on every atom (eV/Å).
        steps : int
            Steps at most.

        Returns
        -------
        bool
            Whether the tolerance was reached. If not, `message` says why, and the atoms
            are in the best state that was found.
        """
        *_, converged = self.irun(fmax, steps)
        return bool(converged)

    def call_observers(self) -> None:
        """Call the observers, with the atoms where the solver is."""
        if self.observers:
            self.optimizable.write()
        super().call_observers()

    def step(self) -> None:
        """Take one step of the solver."""
        state = next(self._states, None)
        if state is None:
            self.message = self.message or "the solver has ended"
            return
        self.pairs += state.pairs
        self.message = state.message
        self.optimizable.state = state
        if state.converged or state.message:
            self._states.close()  # what it remembers is large

    def gradient_converged(self, gradient: np.ndarray) -> bool:
        """Whether the solver says so; before its first step, whether the atoms do."""
        state = self.optimizable.state
        if state is not None:
            return state.converged
        return super().gradient_converged(gradient)


class NewtonKrylov(WindowOptimizer):
    """Newton-Krylov solver for soft walls, with or without attraction.

    Solves for the pressure on the window by Newton's method; the linear system of each
    step is solved in Fourier space only as well as the step deserves, and the energy
    falls in every step. From the flat surface it starts on coarser grids. It honours
    a fixed indenter, a load, and a `Hookean` spring on the indenter.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator and a soft wall.
    logfile, trajectory, append_trajectory, **kwargs
        As for any ASE `Optimizer`; the atoms are moved when the trajectory is written
        and at the end.

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact`, the wall is hard, or there is a
        constraint that the solver can't honour.

    Examples
    --------
    >>> from ase_roughcontact import NewtonKrylov, RoughContact, RoughSphere, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, fixed=False)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.5, load=5.0)
    >>> NewtonKrylov(atoms).run(fmax=1e-9)
    True
    >>> round(atoms.calc.state(atoms).normal_force, 6)
    5.0
    """

    _hard = False
    _solver = staticmethod(newton_krylov)


class ActiveSet(WindowOptimizer):
    """Solver for the hard wall: ``g >= 0, p >= 0, g p = 0``.

    Active-set iteration with preconditioned conjugate gradients for the pressure in
    the contact. The force that `fmax` bounds is the one that closes the gap of an atom:
    ``E* a0/1.122`` times the largest gap in contact or overlap outside of it, which is
    never allowed to be larger than 1e-6 spacings. It honours a fixed indenter and a
    load. After a run, `optimality_residuals` holds how well the conditions hold.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator and a `HardWall`.
    logfile, trajectory, append_trajectory, **kwargs
        As for any ASE `Optimizer`; the atoms are moved when the trajectory is written
        and at the end.

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact`, the wall is not hard, or there is a
        constraint that the solver can't honour.

    Examples
    --------
    >>> from ase_roughcontact import HardWall, ActiveSet, RoughContact, RoughSphere
    >>> from ase_roughcontact import substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, fixed=False)
    >>> atoms.calc = RoughContact(sphere, 0.5, HardWall(), load=5.0)
    >>> optimizer = ActiveSet(atoms)
    >>> optimizer.run(fmax=1e-9)
    True
    >>> optimizer.optimality_residuals.gap_in_contact < 1e-6
    True
    >>> round(atoms.calc.state(atoms).normal_force, 6)
    5.0
    """

    _hard = True
    _solver = staticmethod(active_set)

    @property
    def optimality_residuals(self) -> OptimalityResiduals:
        """Gap in contact, overlap, tension and load error, calculated afresh.

        From the pressure where the solver has come to, by one convolution.

        Raises
        ------
        RuntimeError
            If there was no step yet.
        """
        window = self.optimizable
        if window.state is None:
            raise RuntimeError("no optimality residuals before the first step")
        load = None if window.indenter.fixed else window.atoms.calc.parameters["load"]
        return optimality_residuals(
            window.contact, window.state.pressure, window.state.height, load
        )
