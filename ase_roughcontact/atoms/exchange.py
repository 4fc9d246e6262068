"""Exchange of the window or the grid of surface atoms for another one, in place."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact.atoms.calculator import problem_of
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.info import INDENTER_KEY, LATTICE
from ase_roughcontact.atoms.marks import set_mark
from ase_roughcontact.contact import Problem
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.topography.base import surface_id
from ase_roughcontact.windows.regrid import GridChange, lost_slope, on_grid


def set_window(atoms: Atoms, window: Box) -> None:
    """Exchange the window of a free half space for one with flat atoms, in place.

    There is no padding afterwards, and the atoms have the arrays of new ones.
    Calculator, `info` and constraints of the indenter stay.

    Parameters
    ----------
    atoms : Atoms
        Free half space with a `RoughContact` calculator.
    window : Box
        The new window, in lattice indices counted from the indenter's axis. Its first
        atom is placed at the origin, as in the atoms of `substrate`.

    Raises
    ------
    ValueError
        If the half space is periodic, or there are constraints on surface atoms.
    """
    if atoms.pbc.any():
        raise ValueError(
            "the window of a periodic half space is its cell and cannot be exchanged: "
            "build other atoms"
        )
    problem, _ = problem_of(atoms)
    _exchange(atoms, problem, window, window.shape)


def regrid(atoms: Atoms, change: GridChange, keep_window: bool = True) -> float:
    """Exchange the grid of surface atoms for a finer or coarser one, in place.

    The window, the indenter, the wall and the solid stay. The substrate is flat
    afterwards, and the atoms have the arrays of new ones.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator.
    change : GridChange
    keep_window : bool
        Whether the window stays as it is. Otherwise it is enlarged until a coarser grid
        fits it.

    Returns
    -------
    float
        Part of the rms slope that a coarser grid can't resolve and that the indenter
        has lost.

    Raises
    ------
    ValueError
        If a coarser grid does not fit the window or the period of the indenter, or the
        indenter can't be smoothed.
    """
    problem, old = problem_of(atoms)
    padded = len(atoms) - 1 > old.size
    if not keep_window:
        old = Box(old.start, change.enclosing_shape(old.shape))
    fine, window = on_grid(problem, old, change)
    shape = window.shape
    if padded:
        shape = SurfaceGrid.padded_shape(shape, problem.periodic)
    _exchange(atoms, fine, window, shape)
    if fine.indenter is not problem.indenter:
        atoms.info[INDENTER_KEY] = surface_id(fine.indenter)
        set_mark(atoms, fields=0)
    atoms.calc.set(indenter=fine.indenter, wall=problem.wall)
    return lost_slope(problem.indenter, fine.indenter)


def _exchange(
    atoms: Atoms, problem: Problem, window: Box, shape: tuple[int, int]
) -> None:
    """Put flat atoms in place of all, with the constraints of the indenter."""
    origin, height = problem.origin(window), float(atoms.positions[-1, 2])
    grid = SurfaceGrid(window.shape, shape, problem.spacing, origin, problem.periodic)
    new = grid.atoms(atoms.numbers[0], height)
    moved_by = new.positions[-1] - atoms.positions[-1]
    constraints = [_moved(c, atoms, len(new) - 1, moved_by) for c in atoms.constraints]
    atoms.set_constraint()
    atoms.arrays, atoms.cell = new.arrays, new.cell
    atoms.set_constraint(constraints)
    atoms.info.pop(LATTICE, None)
    set_mark(atoms, fields=0)


def _moved(constraint: object, atoms: Atoms, last: int, moved_by: np.ndarray) -> object:
    """Return a constraint of the indenter with its new index and position."""
    index = np.arange(len(atoms))[getattr(constraint, "index", [])]
    if set(np.ravel(index)) != {len(atoms) - 1}:
        raise ValueError(
            f"{constraint} acts on other atoms than the indenter, or is not supported: "
            "use a fixed window"
        )
    moved: Any = copy(constraint)
    moved.index = last if np.ndim(index) == 0 else np.array([last])
    if getattr(moved, "_type", None) == "point":
        moved.origin = moved.origin + moved_by
    return moved
