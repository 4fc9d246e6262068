"""Lateral state of a contact with friction."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.interactions.friction import SLIP
from ase_roughcontact.interactions.local_friction import LocalFriction
from ase_roughcontact.solvers.lateral.friction import (
    FrictionOptions,
    FrictionSolution,
    solve_friction,
)

# Options of the solution from which the lateral stiffness follows.
_STIFFNESS_OPTIONS = FrictionOptions(tolerance=1e-3)


@dataclass(frozen=True, kw_only=True, eq=False)
class LateralState:
    """Lateral state of a contact with friction, on a box of the surface.

    Attributes
    ----------
    box : Box
    halfspace : LateralHalfSpace
        Lateral half space on the box.
    friction : LocalFriction
        Friction with the histories at the end of the step.
    bounds : ndarray, shape (n, m)
        Bounds of the tractions at the end of the step (eV/Å^3).
    displacement, moved, base : ndarray, shape (2,)
        Displacement of the indenter along x and y, since it came down, and of the base
        of its spring, NaN without one (Å).
    dissipated, released : float
        Energies lost by slip, and released by instabilities, since the beginning (eV).
    instabilities : int
        Number of instabilities in the step.
    solution : FrictionSolution
    cell_area : float
        Area of an atom (Å^2).
    by_pressure : ndarray, shape (2, n, m), or float
        Lateral displacement by the pressure, zero if it is neglected (Å).
    alternations : int
        Number of alternations of the normal and the lateral problem; 0 if their
        coupling is neglected.
    new_contact : float
        Part of the atoms with friction that had no tractions before the step: under
        coupling, that came into contact in it.
    """

    box: Box
    halfspace: LateralHalfSpace
    friction: LocalFriction
    bounds: np.ndarray
    displacement: np.ndarray
    moved: np.ndarray
    base: np.ndarray
    dissipated: float
    released: float
    instabilities: int
    solution: FrictionSolution
    cell_area: float
    by_pressure: np.ndarray | float = 0.0
    alternations: int = 0
    new_contact: float = 0.0

    @property
    def force(self) -> np.ndarray:
        """Force along x and y that holds the indenter (eV/Å)."""
        return self.cell_area * self.solution.tractions.sum(axis=(1, 2))

    @property
    def loads(self) -> np.ndarray:
        """Tractions that displace the surface, shape (2, n, m) (eV/Å^3)."""
        return self.solution.tractions

    @property
    def bound(self) -> float:
        """Largest magnitude of the force, if all atoms slip in one direction."""
        return self.cell_area * float(self.bounds.sum())

    @cached_property
    def stiffness(self) -> float:
        """Lateral force per displacement along x, if all atoms stuck (eV/Å^2)."""
        imposed = np.zeros((2, *self.bounds.shape))
        imposed[0] = 1.0
        bounds = np.where(self.bounds > 0.0, np.inf, 0.0)
        stuck = solve_friction(
            self.halfspace, bounds, imposed, options=_STIFFNESS_OPTIONS
        )
        return self.cell_area * float(stuck.tractions[0].sum())

    @property
    def sticking(self) -> int:
        """Number of atoms with a positive bound that stick."""
        return int(np.count_nonzero((self.bounds > 0.0) & ~self.solution.slipping))

    @property
    def slipping(self) -> int:
        """Number of atoms with a positive bound that slip."""
        return int(np.count_nonzero(self.solution.slipping))

    @property
    def slip(self) -> float:
        """Largest distance that an atom in contact has slipped (Å)."""
        surface = self.solution.displacement + self.by_pressure
        slips = np.hypot(*(self.moved[:, None, None] - surface))
        return float(slips[self.bounds > 0.0].max(initial=0.0))

    @property
    def slipped(self) -> float:
        """Longest way that an atom in contact has slipped, see `SLIP` (Å)."""
        return float(self.friction.history[SLIP.name].max(initial=0.0))

    @property
    def energy(self) -> float:
        """Elastic energy of the tractions and of their coupling to pressure (eV)."""
        work = self.solution.displacement + 2.0 * self.by_pressure
        return 0.5 * self.cell_area * float((self.solution.tractions * work).sum())
