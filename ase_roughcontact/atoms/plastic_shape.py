"""Plastic shape of the surface: the depth by which its atoms have flowed."""

from __future__ import annotations

import numpy as np
from ase import Atoms

from ase_roughcontact._util.kernels import array_equal
from ase_roughcontact.atoms.fields import field_of, info_of
from ase_roughcontact.atoms.grid import SurfaceGrid

#: Array of the atoms with the plastic depth of each (length). The frame of a path has
#: it as text in its `info`, under the same name.
DEPTH_KEY = "plastic_depth"
#: Key in the `info` of a frame of whether its surface has kept the plastic depth.
INDENTED = "indented"


def kept_depth(atoms: Atoms, grid: SurfaceGrid) -> np.ndarray | None:
    """Return the plastic depth that a surface has kept.

    Parameters
    ----------
    atoms : Atoms
        Surface and indenter.
    grid : SurfaceGrid
        Of the atoms.

    Returns
    -------
    ndarray, shape (n, m), or None
        On the window (length); None if the surface is not indented.
    """
    if DEPTH_KEY not in atoms.arrays and info_of(atoms).get(INDENTED):
        set_kept_depth(atoms, grid, field_of(atoms, DEPTH_KEY))
    if DEPTH_KEY not in atoms.arrays:
        return None
    n, m = grid.window
    return atoms.arrays[DEPTH_KEY][:-1].reshape(grid.shape)[:n, :m].copy()


def set_kept_depth(atoms: Atoms, grid: SurfaceGrid, depth: np.ndarray | None) -> None:
    """Set the plastic depth of a surface; None for one that is not indented."""
    atoms.info.pop(INDENTED, None)
    if depth is None:
        atoms.arrays.pop(DEPTH_KEY, None)
        return
    n, m = grid.window
    on_grid = np.zeros(grid.shape)
    on_grid[:n, :m] = depth
    atoms.arrays[DEPTH_KEY] = np.append(on_grid, 0.0)


def same_depth(a: Atoms, b: Atoms) -> bool:
    """Return whether two surfaces have the same plastic depth."""
    depths = [each.arrays.get(DEPTH_KEY) for each in (a, b)]
    if depths[0] is None or depths[1] is None:
        return depths[0] is depths[1]
    return array_equal(*depths)
