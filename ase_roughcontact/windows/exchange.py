"""Exchange of the window of a free half space for another one, in place."""

from __future__ import annotations

from copy import copy
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact.atoms.grid import SurfaceGrid, set_displacement
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.relaxation import without_rounding
from ase_roughcontact.windows.footprint import lattice_offset


def window_of(layout: SurfaceGrid) -> Box:
    """Atoms of a layout that may touch, counted from the indenter's axis.

    Parameters
    ----------
    layout : SurfaceGrid

    Returns
    -------
    Box
    """
    i, j = (round(x / layout.spacing) for x in layout.origin)
    return Box((i, j), layout.window)


def exchange_window(atoms: Atoms, window: Box) -> None:
    """Exchange the window of a free half space for another, in place.

    The atoms that are in both windows keep their pressure, and all are displaced by
    it. There is no margin then. Constraints on the indenter and the calculator stay.

    Parameters
    ----------
    atoms : Atoms
        Of a free half space, with a `RoughContact` calculator.
    window : Box
        The new window; its first corner comes to the origin, as `substrate` has it.

    Raises
    ------
    ValueError
        If the boundary is periodic, or there are constraints on surface atoms.
    """
    if atoms.pbc.any():
        raise ValueError(
            "the window of a periodic half space is its cell: it must stay"
        )
    layout = atoms.calc.layout(atoms)
    pressure = without_rounding(atoms.calc.elastic_pressure(atoms))
    carried = carry(pressure, window_of(layout), window)
    spacing, symbol = layout.spacing, atoms.numbers[0]
    positions = _positions(window, layout, atoms.positions[-1, 2])
    shift = positions[-1] - atoms.positions[-1]  # along x and y
    constraints = [
        _moved(c, atoms, len(positions) - 1, shift) for c in atoms.constraints
    ]

    atoms.set_constraint()
    atoms.arrays = {
        "numbers": np.append(np.full(len(positions) - 1, symbol), 0),
        "positions": positions,
    }
    n, m = window.shape
    atoms.cell[:] = spacing * np.diag([n, m, max(n, m)])
    atoms.set_constraint(constraints)
    if carried.any():
        halfspace = atoms.calc.contact(atoms).halfspace
        set_displacement(atoms, halfspace.padded_displacement(carried))
        atoms.calc.hold(atoms, carried)


def carry(values: np.ndarray, old: Box, new: Box) -> np.ndarray:
    """Values on a window, taken from another one, zero outside of it.

    Parameters
    ----------
    values : ndarray, shape of the old window
    old, new : Box

    Returns
    -------
    ndarray, shape of the new window
    """
    carried = np.zeros(new.shape)
    common = old.intersection(new)
    if min(common.shape) > 0:
        carried[common.slices_in(new)] = values[common.slices_in(old)]
    return carried


def _positions(window: Box, layout: SurfaceGrid, height: float) -> np.ndarray:
    """Places of the atoms of a window, flat, and of the indenter."""
    spacing = layout.spacing
    positions = np.zeros((window.size + 1, 3))
    grid = positions[:-1].reshape(*window.shape, 3)
    grid[..., 0] = spacing * np.arange(window.shape[0])[:, None]
    grid[..., 1] = spacing * np.arange(window.shape[1])
    x, y = (
        -spacing * i - lattice_offset(x, spacing)
        for i, x in zip(window.start, layout.origin, strict=True)
    )
    positions[-1] = x, y, height
    return positions


def _moved(constraint: object, atoms: Atoms, last: int, shift: np.ndarray) -> object:
    """Constraint of the indenter with its new index and place."""
    index = np.arange(len(atoms))[getattr(constraint, "index", [])]
    if set(np.ravel(index)) != {len(atoms) - 1}:
        raise ValueError(
            f"{constraint} acts on atoms other than the indenter, or is not understood "
            "here: give a fixed window"
        )
    moved: Any = copy(constraint)
    moved.index = last if np.ndim(index) == 0 else np.array([last])
    if getattr(moved, "_type", None) == "point":
        moved.origin = moved.origin + shift
    return moved
