"""Atoms read as the state of a contact."""

from __future__ import annotations

from ase import Atoms

from ase_roughcontact.atoms.calculator import model_of
from ase_roughcontact.atoms.grid import displacement
from ase_roughcontact.atoms.history import creep_of, history_of
from ase_roughcontact.contact import State


def state_of(atoms: Atoms) -> State:
    """Return the state of atoms with a `RoughContact` calculator."""
    model = model_of(atoms)
    grid = model.grid
    n, m = grid.window
    return State(
        model.problem.window(grid.window, grid.origin),
        float(atoms.positions[-1, 2]),
        model.elastic_pressure(atoms),
        displacement(atoms, grid)[:n, :m],
        history_of(atoms, grid),
        creep=creep_of(atoms),
    ).in_order()
