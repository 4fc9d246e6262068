"""Relaxed step of a path, from which results, errors and limits are calculated."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ase_roughcontact.contact import Contact, ContactState, Problem, State
from ase_roughcontact.contact.control import HEIGHT, Control
from ase_roughcontact.contact.creep import creep_energy
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.solvers.relaxation import Run
from ase_roughcontact.solvers.response import HeightResponse, height_response
from ase_roughcontact.solvers.status import Status
from ase_roughcontact.stepping.accuracy import GridModel
from ase_roughcontact.stepping.options import StepOptions
from ase_roughcontact.stepping.relaxation_errors import (
    RelaxationErrors,
    relaxation_errors,
)
from ase_roughcontact.theory.counted_area import open_sides
from ase_roughcontact.theory.edge_area import EdgeArea, edge_area
from ase_roughcontact.windows.fixed import at_edge

# Relative residual of the equations for the contact stiffness; see `height_response`.
_STIFFNESS_RESIDUAL = 1e-2


@dataclass(frozen=True, kw_only=True, eq=False)
class RelaxedStep:
    """Relaxed contact at one target of a path.

    Attributes
    ----------
    problem : Problem
    contact : Contact
        The contact on the window of the state.
    run : Run
        The solution: state, fields, forces, support of the indenter, and statistics of
        the solver.
    control : Control
        The quantity that the path prescribes.
    options : StepOptions
        Options of the path, such as whether the continuum is asked for.
    number : int
        Number of the step, from zero.
    first_contact : float
        Height at which the indenter begins to repel the flat substrate (Å).
    seconds : float
        Wall-clock time of the relaxation.
    time : float
        Time of the step; NaN unless the solid creeps.
    base : float
        Height of the base of the cantilever; NaN without one (Å).
    lateral : LateralState or None
        Lateral displacements and tractions of a sliding path; None without friction.
    """

    problem: Problem
    contact: Contact
    run: Run
    control: Control = HEIGHT
    options: StepOptions = field(default_factory=StepOptions)
    number: int = 0
    first_contact: float = math.nan
    seconds: float = 0.0
    time: float = math.nan
    base: float = math.nan
    lateral: Any = None  # so that the columns of sliding paths need no check

    @property
    def state(self) -> State:
        """Relaxed state; after `Stepper.commit` the one the next step starts from."""
        return self.run.state

    @property
    def grid_model(self) -> GridModel:
        """Model that the grid samples, and the error asked for."""
        return self.options.grid_model

    @property
    def height(self) -> float:
        """Height of the indenter (Å)."""
        return self.state.height

    @cached_property
    def fields(self) -> ContactState:
        """Forces, gaps and pressures, calculated from the displacement."""
        return self.run.fields

    @cached_property
    def stored_energy(self) -> float:
        """Energy of solid, wall, load and springs, also stored by creep (eV)."""
        creep = self.problem.solid.creep
        stored = creep_energy(self.state, creep) if creep else 0.0
        return self.run.energy + self.fields.cell_area * stored

    @cached_property
    def halfspace(self) -> HalfSpace:
        """The elastic half space, with the shapes of window and FFT grid."""
        return self.contact.halfspace

    @cached_property
    def touches(self) -> bool:
        """Whether the wall repels an atom."""
        return self.fields.repulsive_atoms > 0

    @cached_property
    def gap_error(self) -> float:
        """Largest gap in contact with a hard wall, or overlap not plastic (Å)."""
        if not self.contact.wall.hard:
            return 0.0
        fields, gap = self.fields, self.fields.gap
        closed = gap.max(initial=0.0, where=fields.contact)
        return float(max(closed, -gap.min(initial=0.0, where=~fields.plastic)))

    @cached_property
    def perimeter(self) -> float:
        """Length of the boundary of the contact along the lines of the grid (Å)."""
        sides = open_sides(self.fields.contact, self.halfspace.periodic)
        return float(sides.sum()) * self.halfspace.spacing

    @cached_property
    def edge_area(self) -> EdgeArea | None:
        """Area of the continuum by the fields at the edge of the contact.

        None unless the continuum is asked for, and this is the contact of a hard wall
        that does not end at the edge of a free window.
        """
        contact, fields, halfspace = self.contact, self.fields, self.halfspace
        is_continuum = self.grid_model.is_continuum
        if not (is_continuum and contact.wall.hard and self.touches):
            return None
        if not halfspace.periodic and at_edge(fields.contact):
            return None
        _, attraction = contact.evaluate_wall(np.zeros(fields.gap.shape))
        return edge_area(
            np.where(fields.contact, fields.pressure - attraction, 0.0),
            fields.gap,
            halfspace.spacing,
            float(halfspace.solid.wave_modulus(math.pi / halfspace.spacing)),
            halfspace.periodic,
            fields.hardness,
        )

    @cached_property
    def mean_pressure(self) -> float:
        """Mean pressure on the repelled atoms, zero without any (eV/Å^3)."""
        pressures = self.fields.pressure[self.fields.contact]
        return float(pressures.mean()) if pressures.size else 0.0

    @property
    def positions(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions x and y of the rows of atoms, from the axis (Å)."""
        spacing, shape = self.problem.spacing, self.fields.gap.shape
        origin = self.problem.origin(self.run.state.window)
        x, y = (
            start + spacing * np.arange(count)
            for start, count in zip(origin, shape, strict=True)
        )
        return x, y

    @property
    def contact_radius(self) -> float:
        """Largest distance of an atom in contact from the axis, zero without (Å)."""
        x, y = self.positions
        rows = self.fields.contact.any(axis=1)
        contact = self.fields.contact[rows]
        ends = contact.argmax(axis=1), -1 - contact[:, ::-1].argmax(axis=1)
        return float(np.hypot(x[rows], [y[end] for end in ends]).max(initial=0.0))

    @cached_property
    def cell_side(self) -> float:
        """Side of a periodic cell under a sphere (Å).

        Infinite without images, and under a flat surface, where images are intended.
        """
        if (
            not self.halfspace.periodic
            or self.problem.topography.apex_radius == math.inf
        ):
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
        return height_response(self.contact, self.fields, _STIFFNESS_RESIDUAL)

    @cached_property
    def relaxation(self) -> RelaxationErrors:
        """Errors that the relaxation leaves."""
        return relaxation_errors(self.contact, self.run, self.response, self.gap_error)

    def marked(self, status: Status | None) -> RelaxedStep:
        """Return the step with another status, if there is one and it had converged."""
        if status is None or not self.run.converged:
            return self
        return replace(self, run=replace(self.run, status=status))
