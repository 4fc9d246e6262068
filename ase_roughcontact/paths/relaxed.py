"""Relaxed step of a path, from which the columns of its result are calculated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.paths.errors import Errors, estimated_errors
from ase_roughcontact.paths.relaxed_contact import RelaxedContact
from ase_roughcontact.solvers.friction import FrictionSolution
from ase_roughcontact.solvers.relaxation import Run


@dataclass
class SolverStatistics:
    """Outcome and cost of relaxing a step; summed over its runs of the optimizer.

    Attributes
    ----------
    converged : bool
    message : str
    tolerance : float
    iterations : int
    pairs : float
        See `LoadStep`.
    """

    converged: bool = False
    message: str = ""
    tolerance: float = np.inf
    iterations: int = 0
    pairs: float = 0.0

    def add(self, run: Run, tolerance: float) -> None:
        """Add a run of the optimizer to a tolerance."""
        self.converged, self.message = run.converged, run.message
        self.tolerance = tolerance
        self.iterations += run.iterations
        self.pairs += run.pairs

    def mark(self, message: str) -> None:
        """Mark the step as not converged, for a reason that is not empty."""
        if message:
            self.converged, self.message = False, message


@dataclass(frozen=True, kw_only=True, eq=False)
class LateralState:
    """Lateral state of a contact with friction, on a box of the surface.

    Attributes
    ----------
    box : Box
    bounds : ndarray, shape (n, m)
        Of the tractions (eV/Å^3).
    displacement, moved, base : ndarray, shape (2,)
        Displacement of the indenter along x and y, since it came down, and of the base
        of its spring, NaN without one (Å).
    dissipated : float
        Energy lost by slip since the beginning (eV).
    solution : FrictionSolution
    cell_area : float
        Area of an atom (Å^2).
    by_pressure : ndarray, shape (2, n, m), or float
        Lateral displacement by the pressure, zero if it is neglected (Å).
    stiffness : float
        Lateral force per displacement along x, if all atoms stuck (eV/Å^2).
    alternations : int
        How often the normal and the lateral problem were solved in turn; 0 if their
        coupling is neglected.
    new_contact : float
        Part of the atoms with friction that had no tractions before the step: under
        coupling, that came into contact in it.
    """

    box: Box
    bounds: np.ndarray
    displacement: np.ndarray
    moved: np.ndarray
    base: np.ndarray
    dissipated: float
    solution: FrictionSolution
    cell_area: float
    by_pressure: np.ndarray | float = 0.0
    stiffness: float = np.nan
    alternations: int = 0
    new_contact: float = 0.0

    @property
    def force(self) -> np.ndarray:
        """What acts on the indenter along x and y to hold it (eV/Å)."""
        return self.cell_area * self.solution.tractions.sum(axis=(1, 2))

    @property
    def bound(self) -> float:
        """Largest magnitude of the force, if all atoms slip in one direction."""
        return self.cell_area * float(self.bounds.sum())

    @property
    def sticking(self) -> int:
        """Number of atoms in contact that stick."""
        return int(np.count_nonzero((self.bounds > 0.0) & ~self.solution.slipping))

    @property
    def slip(self) -> float:
        """Largest distance that an atom in contact has slipped (Å)."""
        surface = self.solution.displacement + self.by_pressure
        slips = np.hypot(*(self.moved[:, None, None] - surface))
        return float(slips[self.bounds > 0.0].max(initial=0.0))

    @property
    def energy(self) -> float:
        """Elastic energy of the tractions and of their coupling to pressure (eV)."""
        work = self.solution.displacement + 2.0 * self.by_pressure
        return 0.5 * self.cell_area * float((self.solution.tractions * work).sum())


@dataclass(frozen=True, kw_only=True)
class RelaxedStep(RelaxedContact):
    """Relaxed contact of a step, with what it cost.

    Attributes
    ----------
    number : int
        Number of the step, from zero.
    first_contact : float
        Height at which the indenter begins to repel the flat substrate (Å).
    statistics : SolverStatistics
    seconds : float
        Wall-clock time of the relaxation.
    time : float
        Of the step, NaN unless the solid creeps.
    base : float
        Height of the base of the cantilever; NaN without one (Å).
    hardness : float
        Of the substrate, infinity or NaN if pressures are not limited (eV/Å^3).
    lateral : LateralState or None
        Under friction, of a sliding path.
    scan_errors : ScanErrors or None
        Adds errors by the scan that is pressed.
    """

    number: int
    first_contact: float
    statistics: SolverStatistics
    seconds: float
    time: float = np.nan
    base: float = np.nan
    hardness: float = np.nan
    lateral: Any = None  # so that the columns of sliding paths need no check
    scan_errors: Callable[[RelaxedStep], Errors] | None = None

    @cached_property
    def errors(self) -> Errors:
        """Estimated errors of area, force and height."""
        errors = estimated_errors(self)
        if self.scan_errors is None:
            return errors
        return Errors(*np.add(errors, self.scan_errors(self)).tolist())
