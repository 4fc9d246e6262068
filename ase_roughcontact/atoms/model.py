"""Checks, contact problem and contact from the parameters and atoms of a calculator."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from ase import Atoms
from ase.data import atomic_numbers

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.kernels import array_equal
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import finite, lookup, positive, surface
from ase_roughcontact.atoms.described import KINDS, from_description
from ase_roughcontact.atoms.grid import (
    SurfaceGrid,
    displacement,
    lateral_displacement,
    set_displacement,
)
from ase_roughcontact.atoms.history import creep_of, history_of, same_arrays
from ase_roughcontact.contact import Contact, ContactState, Problem, State
from ase_roughcontact.contact.creep import check_past, past_of, with_depths
from ase_roughcontact.contact.problem import lattice_offsets
from ase_roughcontact.contact.state import TRACTION_DEPTH, TRACTIONS
from ase_roughcontact.elasticity.crystals.crystal import Crystal
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.elasticity.greens import ElasticSolid, Isotropic
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.elasticity.viscoelastic import Scaled
from ase_roughcontact.interactions import LennardJones93
from ase_roughcontact.interactions.consistency import check_attributes
from ase_roughcontact.topography.base import surface_id

# Largest values of any solid, with their units in tables and here: diamond has a
# modulus of 1200 GPa and a hardness of about 100 GPa.
_LARGEST_OF_SOLIDS = {
    "contact_modulus": (2000.0, "GPa", "eV/Å^3", "ase.units.GPa"),
    "hardness": (300.0, "GPa", "eV/Å^3", "ase.units.GPa"),
    "work_of_adhesion": (30.0, "J/m^2", "eV/Å^2", "ase.units.J / ase.units.m**2"),
}
# Options of FFTs that may be given.
_FFT_OPTIONS = dict.fromkeys(("dtype", "engine", "threads"))


def checked(name: str, value: Any) -> Any:
    """Return a parameter of `RoughContact` as it is stored.

    Parameters
    ----------
    name : str
        Name of the parameter.
    value : object
        Value as the user gives it, or the result of the method `todict` of a part.

    Returns
    -------
    object

    Raises
    ------
    ValueError
        If it is not valid.
    """
    if name == "load":
        finite(load=value)
        return float(value)
    if name == "fft":
        return _checked_fft(value)
    if value is None:
        return None
    if name == "contact_modulus":
        positive(contact_modulus=value)
        _warn_of_units(contact_modulus=value)
        return float(value)
    if isinstance(value, Mapping):
        value = from_description(name, KINDS[name], value)
    if name == "indenter":
        surface(indenter=value)
    elif not isinstance(value, KINDS[name]):
        kind = KINDS[name].__name__
        raise ValueError(f"{name} must be a {kind}, got {value!r}")
    if name == "wall":
        check_attributes(value)
        _warn_of_units(hardness=value.hardness, work_of_adhesion=value.work_of_adhesion)
    return value


def _checked_fft(options: Any) -> dict:
    if not isinstance(options, dict):
        raise ValueError(f"fft must be a dict of options, got {options!r}")
    options = dict(options)
    for key in options:
        lookup(key, _FFT_OPTIONS, "option of fft")
    # fails now, and not at the first calculation, if an option is wrong
    trial = RealFFT2((1, 1), **options)
    if "dtype" in options:
        options["dtype"] = trial.dtype.name
    return options


def _warn_of_units(**values: float) -> None:
    """Warn of values that may be in the units of tables."""
    for name, value in values.items():
        largest, unit, own, factor = _LARGEST_OF_SOLIDS[name]
        usual = value / UNITS[unit]
        if largest < usual < math.inf:
            warn(
                f"{name} = {value:g} {own} is {usual:.3g} {unit}, more than any solid "
                f"has: multiply a value in {unit} by {factor}"
            )


def problem_for(grid: SurfaceGrid, parameters: Mapping[str, Any]) -> Problem:
    """Return the contact problem of a grid of atoms for parameters of `RoughContact`.

    Raises
    ------
    ValueError
        If a parameter is missing, or some of them do not fit together.
    """
    solid, modulus = parameters["solid"], parameters["contact_modulus"]
    indenter, wall = parameters["indenter"], parameters["wall"]
    if indenter is None or (solid is None and modulus is None):
        raise ValueError(
            "RoughContact needs an indenter, and a contact_modulus or a solid"
        )
    if None not in (solid, modulus):
        raise ValueError("give contact_modulus or solid, not both")
    if solid is None:
        solid = Isotropic(modulus)
    if wall is None:
        wall = LennardJones93.repulsive(solid.contact_modulus, grid.spacing)
    return Problem(
        indenter=indenter,
        solid=solid,
        wall=wall,
        spacing=grid.spacing,
        periodic=grid.periodic,
        offset=lattice_offsets(grid.origin, grid.spacing),
        heterogeneity=parameters["heterogeneity"],
        fft=parameters["fft"],
    )


@dataclass
class ContactModel:
    """Contact of a lattice of atoms for the parameters, apart from the positions z.

    Attributes
    ----------
    grid : SurfaceGrid
        The lattice of the atoms: with the parameters it determines the model.
    problem : Problem
    contact : Contact
    last_solution : tuple of (ndarray, float or None, ndarray), optional
        A displacement, a height of the indenter and the pressure on the window that
        causes the displacement. A hard wall exerts this pressure if the indenter is at
        the height; None if a solver has not found it.
    fields : ContactState, optional
        Fields of the displacement and the height in `last_solution`.
    history : mapping of str to ndarray of shape (n, m)
        History that the surface has kept of earlier steps.
    """

    grid: SurfaceGrid
    problem: Problem
    contact: Contact
    last_solution: tuple[np.ndarray, float | None, np.ndarray] | None = None
    fields: ContactState | None = None
    history: Mapping[str, np.ndarray] = field(default_factory=dict)

    @classmethod
    def of(cls, atoms: Atoms, parameters: Mapping[str, Any]) -> ContactModel:
        """Return the model of atoms for the parameters of `RoughContact`."""
        grid = SurfaceGrid.of(atoms)
        _check_element(atoms, parameters["solid"])
        problem = problem_for(grid, parameters)
        window = problem.window(grid.window, grid.origin)
        contact = problem.contact(window, padded=grid.shape != grid.window)
        return cls(grid, problem, contact)

    @cached_property
    def surface_id(self) -> str | None:
        """The `surface_id` of the indenter."""
        return surface_id(self.problem.indenter)

    def fits(self, atoms: Atoms) -> bool:
        """Return whether the lattice of the atoms is still the same."""
        _check_element(atoms, self.problem.solid)
        return SurfaceGrid.of(atoms) == self.grid

    def adopt_history(self, atoms: Atoms) -> None:
        """Give the contact the history that the atoms have kept."""
        new = history_of(atoms, self.grid)
        if same_arrays(self.history, new):
            return
        window = self.problem.window(self.grid.window, self.grid.origin)
        flat = np.zeros(window.shape)
        crept = State(window, 0.0, flat, None, new, creep=creep_of(atoms))
        check_past(crept, self.problem.solid.creep)
        halfspace = self.contact.halfspace
        if isinstance(halfspace.solid, Scaled):  # also after an interrupted time step
            halfspace = halfspace.softened(1.0)
        state = with_depths(crept, halfspace)
        pressure, depth = None, new.get(TRACTION_DEPTH)
        if state.depths:
            pressure, depth = past_of(state)
        self.contact = self.contact.changed(
            halfspace, state.plastic_depth, pressure, depth
        )
        self.history = new

    def state(self, values: np.ndarray, height: float) -> ContactState:
        """Return energy, forces and fields of a displacement and a height."""
        pressure, solved_height = self._solution_of(values)
        reaction = pressure if height == solved_height else None
        if reaction is not None and self.fields is not None:
            return self.fields
        return self.contact.evaluate(values, height, pressure, reaction)

    @cached_property
    def lateral(self) -> LateralHalfSpace:
        """Lateral response of the surface."""
        grid, problem = self.grid, self.problem
        return LateralHalfSpace(
            grid.window, grid.spacing, problem.solid, grid.periodic, **problem.fft
        )

    def lateral_energies(self, atoms: Atoms) -> tuple[np.ndarray, np.ndarray]:
        """Return energies of lateral displacements, shape (N,), and forces (N, 2)."""
        moved: Any = lateral_displacement(atoms, self.grid)
        forces = -(self.grid.spacing**2) * self.lateral.tractions(moved)
        return -0.5 * (moved * forces).sum(axis=0).ravel(), forces.reshape(2, -1).T

    @property
    def lateral_force(self) -> np.ndarray:
        """Sum of the tractions of friction, along x and y."""
        tractions = [self.history.get(key, np.zeros(1)) for key in TRACTIONS]
        area = self.contact.halfspace.cell_area
        return area * np.array([values.sum() for values in tractions])

    def elastic_pressure(self, atoms: Atoms) -> np.ndarray:
        """Return the pressure that causes the displacement of the atoms."""
        values = displacement(atoms, self.grid)
        pressure, _ = self._solution_of(values)
        if pressure is None:
            n, m = self.grid.window
            pressure = self.contact.elastic_pressure(values)[:n, :m].copy()
            if self.grid.shape == self.grid.window:
                self.last_solution = values, None, pressure
        return pressure

    def move(
        self,
        atoms: Atoms,
        pressure: np.ndarray,
        height: float,
        values: np.ndarray | None = None,
    ) -> None:
        """Move the atoms to the displacement of a pressure, and the indenter.

        The pressure is kept until the atoms move. It would otherwise have to be
        calculated from the displacement, and the reaction of a hard wall does not
        follow from positions that are not relaxed, or if all atoms of a periodic
        surface are in contact.
        """
        if values is None:
            values = self.contact.halfspace.padded_displacement(pressure)
            values = np.asarray(values, dtype=float)
        set_displacement(atoms, values)
        atoms.positions[-1, 2] = height
        self.last_solution, self.fields = (values, height, pressure), None
        atoms.calc.reset()

    def _solution_of(
        self, values: np.ndarray
    ) -> tuple[np.ndarray | None, float | None]:
        """Return pressure and height of the indenter if they belong to the values."""
        if self.last_solution is None or not array_equal(self.last_solution[0], values):
            return None, None
        _, height, pressure = self.last_solution
        return pressure, height


def _check_element(atoms: Atoms, solid: ElasticSolid | None) -> None:
    solid = solid.elastic if solid is not None else None
    if not isinstance(solid, Crystal):
        return
    others = atoms.numbers[:-1] != atomic_numbers[solid.symbol]
    if others.any():
        raise ValueError(
            f"the solid is a crystal of {solid.symbol}, got surface atoms of "
            f"{atoms.symbols[int(others.argmax())]}: build them with "
            f"substrate({solid.symbol!r}, ...)"
        )
