"""Relaxed step of a path, from which the columns of its result are calculated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

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
    """Lateral state of a contact with friction.

    Attributes
    ----------
    displacement, force : ndarray, shape (2,)
        Of the indenter along x and y (Å), and what acts on it to hold it (eV/Å).
    base : ndarray, shape (2,)
        Displacement of the base of the spring that moves it, NaN without one (Å).
    bound : float
        Largest magnitude of this force, if all atoms slip in one direction (eV/Å).
    sticking, slipping : int
        Numbers of atoms in contact that stick, and of the others.
    slip : float
        Largest distance that an atom in contact has slipped (Å).
    stiffness : float
        Lateral force per displacement along x, if all atoms stuck (eV/Å^2).
    energy, dissipated : float
        Elastic energy of the tractions, and energy lost by slip since the beginning
        (eV).
    solution : FrictionSolution
        On the box of the tractions.
    alternations : int
        How often the normal and the lateral problem were solved in turn; 0 if their
        coupling is neglected.
    """

    displacement: np.ndarray
    force: np.ndarray
    base: np.ndarray
    bound: float
    sticking: int
    slipping: int
    slip: float
    stiffness: float
    energy: float
    dissipated: float
    solution: FrictionSolution
    alternations: int = 0


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
