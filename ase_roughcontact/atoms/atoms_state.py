"""Atoms read as the state of a contact."""

from __future__ import annotations

import numpy as np
from ase import Atoms

from ase_roughcontact.atoms.calculator import model_of
from ase_roughcontact.atoms.grid import SurfaceGrid, displacement
from ase_roughcontact.atoms.history import creep_of, history_of
from ase_roughcontact.contact import Problem, State


def state_of(atoms: Atoms) -> State:
    """Return the state of atoms with a `RoughContact` calculator."""
    model = model_of(atoms)
    pressure = model.elastic_pressure(atoms)
    return state_with(atoms, model.problem, model.grid, pressure)


def state_with(
    atoms: Atoms, problem: Problem, grid: SurfaceGrid, pressure: np.ndarray
) -> State:
    """Return the state of atoms without a calculator.

    Parameters
    ----------
    atoms : Atoms
    problem : Problem
    grid : SurfaceGrid
        Of the atoms.
    pressure : ndarray, shape (n, m)
        Elastic pressure on the window.

    Returns
    -------
    State
    """
    n, m = grid.window
    return State(
        problem.window(grid.window, grid.origin),
        float(atoms.positions[-1, 2]),
        pressure,
        displacement(atoms, grid)[:n, :m],
        history_of(atoms, grid),
        creep=creep_of(atoms),
    )
