"""The grid of the surface atoms: its shape, spacing, boundary and margin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact._util.kernels import rowwise
from ase_roughcontact._util.validation import surface
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.halfspace import (
    FreeHalfSpace,
    HalfSpace,
    PeriodicHalfSpace,
)
from ase_roughcontact.elasticity.reduced import ReducedHalfSpace
from ase_roughcontact.topography import Surface

# Lateral positions may differ from the grid's by this part of the spacing: text formats
# round them.
_OFF_GRID = 1e-4


@dataclass(frozen=True, eq=False)
class SurfaceGrid:
    """How the atoms of a substrate make a grid.

    Attributes
    ----------
    window : (int, int)
        Shape of the window that may touch.
    grid : (int, int)
        Shape of all surface atoms: of the window with its margin, or of the window.
    spacing : float
        Distance of neighbours (length).
    origin : (float, float)
        Position of the window's first corner relative to the indenter's axis (length).
    periodic : bool
        Periodic or free half space.
    """

    window: tuple[int, int]
    grid: tuple[int, int]
    spacing: float
    origin: tuple[float, float]
    periodic: bool

    def halfspace(self, solid: ElasticSolid | float, **fft: Any) -> HalfSpace:
        """Half space below the atoms; see there for the parameters."""
        given = self.spacing, solid
        if self.periodic:
            return PeriodicHalfSpace(self.window, *given, **fft)
        margin = self.grid == FreeHalfSpace.padded_shape(self.window)
        return (FreeHalfSpace if margin else ReducedHalfSpace)(
            self.window, *given, **fft
        )

    def heights(self, indenter: Surface) -> np.ndarray:
        """Heights of an indenter at the atoms that may touch (length)."""
        return indenter.heights(self.window, self.spacing, self.origin)

    @classmethod
    def of(cls, atoms: Atoms) -> SurfaceGrid:
        """Read the layout off the atoms.

        Parameters
        ----------
        atoms : Atoms
            Substrate and indenter.

        Returns
        -------
        SurfaceGrid

        Raises
        ------
        ValueError
            If the last atom is not the indenter, the other ones are not on a square
            grid that fits the cell, or the boundary is neither periodic in x and y
            nor free in all directions.
        """
        _check_indenter(atoms)
        periodic = _check_boundary(atoms)
        if not np.isfinite(atoms.positions).all():
            raise ValueError("positions must be finite, got NaN or infinity")
        xy = atoms.positions[:-1, :2]
        axis = atoms.positions[-1, :2]
        grid, spacing = _grid_of(xy, atoms.cell)
        _check_on_grid(xy, grid, spacing)
        window = _window_of(atoms.cell, spacing)
        expected = SurfaceGrid.grid_for(window, periodic)
        if grid not in (expected, window):
            raise ValueError(
                f"a cell of {window} atoms needs a grid of {expected} atoms, margin "
                f"included, or of {window} without; got {grid}. Build the atoms with "
                "substrate()"
            )
        origin = (float(xy[0, 0] - axis[0]), float(xy[0, 1] - axis[1]))
        return cls(window, grid, spacing, origin, periodic)

    @staticmethod
    def grid_for(window: tuple[int, int], periodic: bool) -> tuple[int, int]:
        """Shape of the grid for a window."""
        return (PeriodicHalfSpace if periodic else FreeHalfSpace).padded_shape(window)


def displacement(atoms: Atoms, layout: SurfaceGrid) -> np.ndarray:
    """Displacement of the surface atoms, shape of the layout's grid (Å)."""
    return atoms.positions[:-1, 2].reshape(layout.grid)


def set_displacement(atoms: Atoms, values: np.ndarray) -> None:
    """Move the surface atoms to a displacement, shape of the layout's grid (Å)."""
    atoms.positions[:-1, 2] = values.ravel()


def surface_above(atoms: Atoms, layout: SurfaceGrid, indenter: Surface) -> np.ndarray:
    """Z of an indenter's surface above the atoms that may touch, shape (k,) (Å)."""
    surface(indenter=indenter)
    mean = atoms.positions[:-1, 2].mean() if layout.periodic else 0.0
    return atoms.positions[-1, 2] + mean + layout.heights(indenter).ravel()


def inside(layout: SurfaceGrid) -> np.ndarray:
    """Tell which surface atoms are in the window, shape (number of atoms,)."""
    mask = np.zeros(layout.grid, dtype=bool)
    mask[: layout.window[0], : layout.window[1]] = True
    return mask.ravel()


def _check_indenter(atoms: Atoms) -> None:
    ghosts = np.flatnonzero(atoms.numbers == 0)
    if len(atoms) < 2 or list(ghosts) != [len(atoms) - 1]:
        where = "none" if len(ghosts) == 0 else f"atoms {ghosts[:5].tolist()}"
        raise ValueError(
            "the last atom, and no other, must be the indenter (symbol X); "
            f"of {len(atoms)} atoms, {where} have that symbol"
        )


def _check_boundary(atoms: Atoms) -> bool:
    pbc = tuple(bool(flag) for flag in atoms.pbc)
    if pbc not in ((True, True, False), (False, False, False)):
        raise ValueError(
            "pbc must be (True, True, False) for a periodic half space or all False "
            f"for a free one, got {pbc}"
        )
    cell = atoms.cell.array
    if np.abs(cell - np.diag(np.diag(cell))).max() > 0 or np.diag(cell)[:2].min() <= 0:
        raise ValueError(
            "the cell must be the rectangular window of atoms that may touch, got "
            f"{cell.tolist()}"
        )
    return pbc[0]


def _grid_of(xy: np.ndarray, cell: Any) -> tuple[tuple[int, int], float]:
    """Shape and spacing from the order of the atoms."""
    spacing = float(np.abs(xy[1] - xy[0]).max()) if len(xy) > 1 else float(cell[0, 0])
    next_row = np.flatnonzero(xy[:, 0] - xy[0, 0] > spacing / 2)
    columns = int(next_row[0]) if len(next_row) else len(xy)
    rows, rest = divmod(len(xy), columns)
    if rest or not spacing > 0:
        raise ValueError(
            f"{len(xy)} surface atoms do not make a grid with rows of {columns}"
        )
    return (rows, columns), spacing


def _check_on_grid(xy: np.ndarray, grid: tuple[int, int], spacing: float) -> None:
    x, y = (part.reshape(grid) for part in xy.T)
    i, j = (np.broadcast_to(part, grid) for part in np.ogrid[: grid[0], : grid[1]])
    off = max(_distance(x, x[0, 0], spacing, i), _distance(y, y[0, 0], spacing, j))
    # a spacing read off two rounded positions drifts with the index
    tolerance = _OFF_GRID * spacing * max(1.0, 1e-3 * max(grid))
    if off > tolerance:
        worst = np.maximum(
            abs(x - x[0, 0] - spacing * i), abs(y - y[0, 0] - spacing * j)
        ).argmax()
        raise ValueError(
            f"atom {worst} is off the square grid by {off:.3g} (spacing "
            f"{spacing:.6g}): surface atoms may move along z only"
        )


@rowwise(np.maximum)
def _distance(x: np.ndarray, first: float, spacing: float, i: np.ndarray) -> float:
    """Return the largest ``|x - first - spacing i|``."""
    return float(abs(x - first - spacing * i).max())


def _window_of(cell: Any, spacing: float) -> tuple[int, int]:
    sides = np.diag(cell.array)[:2] / spacing
    window = np.rint(sides).astype(int)
    if np.abs(sides - window).max() > 1e-3 * max(1.0, 1e-3 * sides.max()):
        raise ValueError(
            f"the cell's sides must be whole numbers of spacings, got {sides.tolist()}"
        )
    return int(window[0]), int(window[1])
