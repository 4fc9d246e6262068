"""Relaxed contact, from which results, their errors and checks are calculated."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact.atoms.calculator import model_of
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.model import ContactModel
from ase_roughcontact.contact import Contact, ContactState
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.solvers.response import HeightResponse, height_response
from ase_roughcontact.theory.counted_area import open_sides
from ase_roughcontact.theory.edge_area import EdgeArea, edge_area
from ase_roughcontact.windows.fixed import at_edge

# Relative residual of the equations for the contact stiffness; see `height_response`.
_RESIDUAL = 1e-2


@dataclass(frozen=True, kw_only=True)
class RelaxedContact:
    """Relaxed atoms, and the question that they answer.

    Attributes
    ----------
    atoms : Atoms
        With a `RoughContact` calculator.
    control : {"penetrations", "heights", "loads"}
        What the path prescribes.
    continuum : bool
        Whether the continuum is asked for, and not the model of atoms.
    lost_slope : float
        Part of the rms slope that a coarse grid can't resolve, and that is lost.
    coarse_area : float or None
        Contact area on a grid of twice the spacing, if it was calculated (Å^2).
    """

    atoms: Atoms
    control: str = "heights"
    continuum: bool = False
    lost_slope: float = 0.0
    coarse_area: float | None = None

    @property
    def height(self) -> float:
        """Height of the indenter (Å)."""
        return float(self.atoms.positions[-1, 2])

    @cached_property
    def _calculated(self) -> tuple[ContactState, dict[str, Any]]:
        """State and results of the calculator, which compares positions only once."""
        calc = self.atoms.calc
        return calc.state(self.atoms), calc.results

    @property
    def state(self) -> ContactState:
        """Forces, gaps and pressures, calculated from the positions."""
        return self._calculated[0]

    @cached_property
    def forces(self) -> np.ndarray:
        """Forces on all atoms, those of constraints included, shape (N, 3) (eV/Å)."""
        if self.atoms.constraints:
            return self.atoms.get_forces()
        return self._calculated[1]["forces"]

    @property
    def energy(self) -> float:
        """Energy of solid, wall, load and constraints (eV)."""
        if self.atoms.constraints:
            return float(self.atoms.get_potential_energy())
        return float(self._calculated[1]["energy"])

    @cached_property
    def _model(self) -> ContactModel:
        return model_of(self.atoms)

    @property
    def contact(self) -> Contact:
        """Half space, indenter and wall."""
        return self._model.contact

    @property
    def grid(self) -> SurfaceGrid:
        """Grid of the surface atoms."""
        return self._model.grid

    @property
    def halfspace(self) -> HalfSpace:
        """The elastic half space, with the shapes of window and FFT grid."""
        return self.contact.halfspace

    @property
    def touches(self) -> bool:
        """Whether the wall repels an atom."""
        return self.state.repulsive_atoms > 0

    @cached_property
    def perimeter(self) -> float:
        """Length of the boundary of the contact along the lines of the grid (Å)."""
        sides = open_sides(self.state.contact, self.halfspace.periodic)
        return float(sides.sum()) * self.halfspace.spacing

    @cached_property
    def edge_area(self) -> EdgeArea | None:
        """Area of the continuum by the fields at the edge of the contact.

        None unless the continuum is asked for, and this is the contact of a wall with
        an `elastic_edge` that does not end at the edge of a free window.
        """
        wall, state, halfspace = self.contact.interaction, self.state, self.halfspace
        if not (self.continuum and wall.elastic_edge and self.touches):
            return None
        if not halfspace.periodic and at_edge(state.contact):
            return None
        return edge_area(
            state.pressure,
            state.gap,
            self.perimeter,
            halfspace.spacing,
            float(halfspace.solid.wave_modulus(math.pi / halfspace.spacing)),
            halfspace.periodic,
        )

    @property
    def mean_pressure(self) -> float:
        """Mean pressure on the repelled atoms, zero without any (eV/Å^3)."""
        pressures = self.state.pressure[self.state.contact]
        return float(pressures.mean()) if pressures.size else 0.0

    @property
    def positions(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions x and y of the rows of atoms, from the axis (Å)."""
        grid, shape = self.grid, self.state.gap.shape
        x, y = (
            start + grid.spacing * np.arange(count)
            for start, count in zip(grid.origin, shape, strict=True)
        )
        return x, y

    @property
    def contact_radius(self) -> float:
        """Largest distance of an atom in contact from the axis, zero without (Å)."""
        x, y = self.positions
        i, j = self.state.contact.nonzero()
        return float(np.hypot(x[i], y[j]).max(initial=0.0))

    @property
    def cell_side(self) -> float:
        """Side of a periodic cell under a sphere (Å).

        Infinite without images, and under a flat surface, whose images are meant.
        """
        radius = getattr(self.atoms.calc.parameters["indenter"], "radius", math.inf)
        if not self.halfspace.periodic or radius == math.inf:
            return math.inf
        return min(self.halfspace.shape) * self.halfspace.spacing

    @property
    def part_of_cell(self) -> float:
        """Diameter of the contact over the side of the cell; see `cell_side`."""
        side = self.cell_side
        return 2.0 * self.contact_radius / side if side < math.inf else 0.0

    @cached_property
    def response(self) -> HeightResponse:
        """Change of the relaxed contact by a unit of height."""
        return height_response(self.contact, self.state, _RESIDUAL)
