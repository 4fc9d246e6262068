"""The grid of the surface atoms: shape, spacing and boundary, read off the atoms."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np
from ase import Atoms

from ase_roughcontact._util.rounding import ROUNDING
from ase_roughcontact._util.validation import surface
from ase_roughcontact.atoms.info import (
    LATTICE,
    PAST_DEPTH,
    field_of,
    info_of,
)
from ase_roughcontact.atoms.marks import check_indenter
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.topography import Surface
from ase_roughcontact.topography.base import sampled_heights, surface_id

# Largest distance of an atom from its lattice site, in spacings: text formats round
# positions.
_LATERAL_TOLERANCE = 1e-4
# End of errors about the places of atoms.
_ADVICE = (
    "surface atoms may move along z only, and none may be missing; set their x and y, "
    "and the cell, back as in substrate()"
)


@dataclass(frozen=True)
class SurfaceGrid:
    """Square grid of the surface atoms.

    Attributes
    ----------
    window : (int, int)
        Shape of the window, the atoms that may touch the indenter.
    shape : (int, int)
        Shape of all surface atoms: the window alone, or with the padding of a free
        half space.
    spacing : float
        Distance of neighbours (length).
    origin : (float, float)
        Position of the first atom relative to the indenter's axis (length).
    periodic : bool
        Whether the half space is periodic, or free.
    """

    window: tuple[int, int]
    shape: tuple[int, int]
    spacing: float
    origin: tuple[float, float]
    periodic: bool

    @property
    def in_window(self) -> np.ndarray:
        """Mask of the surface atoms in the window, shape (number of atoms,)."""
        n, m = self.window
        mask = np.zeros(self.shape, dtype=bool)
        mask[:n, :m] = True
        return mask.ravel()

    @property
    def sides(self) -> np.ndarray:
        """Sides of the cell of the atoms, shape (3,) (length)."""
        return self.spacing * np.array([*self.window, max(self.window)])

    def heights(self, indenter: Surface) -> np.ndarray:
        """Return the heights of an indenter above the window, shape (n, m) (length)."""
        return sampled_heights(indenter, self.window, self.spacing, self.origin)

    @staticmethod
    def padded_shape(window: tuple[int, int], periodic: bool) -> tuple[int, int]:
        """Return the shape of all surface atoms for a window with its padding."""
        halfspace = PeriodicHalfSpace if periodic else FreeHalfSpace
        return halfspace.padded_shape(window)

    @classmethod
    def of(cls, atoms: Atoms) -> SurfaceGrid:
        """Read the grid off the atoms.

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
            If the last atom is not the indenter, the others do not form a square grid
            that fits the cell, or the boundary is neither periodic in x and y nor free
            in all directions.
        """
        _check_indenter(atoms)
        periodic = _check_boundary(atoms)
        if not np.isfinite(atoms.positions).all():
            raise ValueError("positions must be finite, got NaN or infinity")
        count = len(atoms) - 1
        lattice = info_of(atoms).get(LATTICE)
        if lattice:  # from which the atoms are displaced
            window, shape = tuple(lattice["window"]), tuple(lattice["shape"])
            origin = tuple(lattice["origin"])
            if count != math.prod(shape):
                raise ValueError(
                    f"{math.prod(shape)} surface atoms have slid, got {count}: "
                    f"{_ADVICE}"
                )
            return cls(window, shape, lattice["spacing"], origin, periodic)
        xy, axis = atoms.positions[:-1, :2], atoms.positions[-1, :2]
        sides = atoms.cell.array.diagonal()[:2]
        shape, window, spacing = _lattice_of(xy, sides)
        _check_on_grid(xy, shape, spacing)
        expected = cls.padded_shape(window, periodic)
        if shape not in (expected, window):
            raise ValueError(
                f"a cell of {window} atoms needs {expected} surface atoms with padding "
                f"or {window} without, got {shape}: build the atoms with substrate()"
            )
        origin = (float(xy[0, 0] - axis[0]), float(xy[0, 1] - axis[1]))
        return cls(window, shape, spacing, origin, periodic)

    def sites(self, axis: np.ndarray) -> np.ndarray:
        """Return the sites of all surface atoms, shape (count, 2), for an axis."""
        x = axis[0] + self.origin[0] + self.spacing * np.arange(self.shape[0])
        y = axis[1] + self.origin[1] + self.spacing * np.arange(self.shape[1])
        return np.stack(np.broadcast_arrays(x[:, None], y), axis=-1).reshape(-1, 2)

    def atoms(self, number: int, height: float) -> Atoms:
        """Return flat atoms, the first one at x = y = 0, and the indenter.

        Parameters
        ----------
        number : int
            Atomic number of the surface atoms.
        height : float
            Height of the indenter (Å).

        Returns
        -------
        Atoms
        """
        axis = np.subtract(0.0, self.origin)
        positions = np.zeros((math.prod(self.shape) + 1, 3))
        positions[:-1, :2], positions[-1] = self.sites(axis), (*axis, height)
        return Atoms(
            numbers=np.append(np.full(len(positions) - 1, number), 0),
            positions=positions,
            cell=self.sides,
            pbc=(self.periodic, self.periodic, False),
        )


def displacement(atoms: Atoms, grid: SurfaceGrid) -> np.ndarray:
    """Return a copy of the displacement of the surface atoms, shape of the grid (Å).

    Present pressures cause it: the depth of the past lowers the surface of a frame.
    """
    values = atoms.positions[:-1, 2].reshape(grid.shape).copy()
    if PAST_DEPTH in info_of(atoms):
        values += field_of(atoms, PAST_DEPTH, grid.window)
    return values


def on_grid(values: np.ndarray, grid: SurfaceGrid, padding: float = 0.0) -> np.ndarray:
    """Return values on a window, shape (..., n, m), extended to the padding."""
    shape = (*values.shape[:-2], *grid.shape)
    found = np.full(shape, padding, dtype=values.dtype)
    found[..., : grid.window[0], : grid.window[1]] = values
    return found


def lateral_displacement(atoms: Atoms, grid: SurfaceGrid) -> np.ndarray | None:
    """Return the displacement along x and y of all atoms, shape (2, N, M) (Å).

    None for atoms on their lattice.
    """
    if LATTICE not in info_of(atoms):
        return None
    moved = atoms.positions[:-1, :2] - grid.sites(_axis_of(atoms))
    return moved.T.reshape(2, *grid.shape)


def set_lateral_displacement(
    atoms: Atoms, grid: SurfaceGrid, values: np.ndarray | None
) -> None:
    """Move all surface atoms along x and y; None puts them on their lattice.

    The indenter is above the middle of the lattice then.
    """
    if values is None and LATTICE not in info_of(atoms):
        return
    axis = _axis_of(atoms)
    atoms.positions[:-1, :2], atoms.positions[-1, :2] = grid.sites(axis), axis
    for info in (atoms.info, atoms.info.get("data", {})):
        info.pop(LATTICE, None)
    if values is not None:
        atoms.positions[:-1, :2] += values.reshape(2, -1).T
        atoms.info[LATTICE] = asdict(grid)


def _axis_of(atoms: Atoms) -> np.ndarray:
    """Return the position of the indenter's axis before it has moved sideways (Å)."""
    lattice = info_of(atoms).get(LATTICE, {})
    return np.array(lattice.get("axis", atoms.positions[-1, :2]))


def set_displacement(atoms: Atoms, values: np.ndarray) -> None:
    """Move the surface atoms to a displacement, shape of the grid (Å)."""
    for info in (atoms.info, atoms.info.get("data", {})):
        info.pop(PAST_DEPTH, None)
    atoms.positions[:-1, 2] = values.ravel()


def surface_above(atoms: Atoms, grid: SurfaceGrid, indenter: Surface) -> np.ndarray:
    """Return z of an indenter's surface above the window, shape (n, m) (Å)."""
    surface(indenter=indenter)
    check_indenter(atoms, surface_id(indenter))
    mean = atoms.positions[:-1, 2].mean() if grid.periodic else 0.0
    return atoms.positions[-1, 2] + mean + grid.heights(indenter)


def _check_indenter(atoms: Atoms) -> None:
    indices = np.flatnonzero(atoms.numbers == 0)
    if len(atoms) < 2 or list(indices) != [len(atoms) - 1]:
        found = "none" if len(indices) == 0 else f"atoms {indices[:5].tolist()}"
        raise ValueError(
            "the last atom, and no other, must be the indenter (symbol X); "
            f"of {len(atoms)} atoms, {found} have this symbol"
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


def _lattice_of(
    xy: np.ndarray, sides: np.ndarray
) -> tuple[tuple[int, int], tuple[int, int], float]:
    """Return shape of the grid, window and spacing from the order of the atoms.

    The spacing follows from the cell, which is not rounded like positions.
    """
    first_step = float(np.ptp(xy[:2], axis=0).max() if len(xy) > 1 else sides[0])
    columns = max(int(np.searchsorted(xy[:, 0], xy[0, 0] + first_step / 2)), 1)
    rows, remainder = divmod(len(xy), columns)
    if remainder or not first_step:
        raise ValueError(
            f"{len(xy)} surface atoms do not make a grid with rows of {columns}: "
            f"{_ADVICE}"
        )
    steps = max(rows, columns) - 1
    mean_step = np.ptp(xy[[0, -1]], axis=0).max() / steps if steps else first_step
    n, m = (max(round(side / mean_step), 1) for side in sides)
    if np.abs(sides - mean_step * np.array([n, m])).max() > 1e-3 * mean_step:
        raise ValueError(
            "the cell's sides must be whole numbers of spacings, got "
            f"{(sides / mean_step).tolist()}: {_ADVICE}"
        )
    spacing = float(sides[0] / n)
    # exact in the atoms of substrate(), where the cell's is off by rounding
    exact = abs(first_step - spacing) <= ROUNDING * spacing
    return (rows, columns), (n, m), first_step if exact else spacing


def _check_on_grid(xy: np.ndarray, shape: tuple[int, int], spacing: float) -> None:
    """Raise `ValueError` if atoms are beside their sites."""
    n, m = shape
    lines = spacing * np.arange(n)[:, None], spacing * np.arange(m)
    offsets = [xy[:, i].reshape(shape) - lines[i] for i in (0, 1)]
    if max(float(abs(x - x[0, 0]).max()) for x in offsets) <= (
        _LATERAL_TOLERANCE * spacing
    ):
        return
    distance = np.max([abs(x - np.median(x)) for x in offsets], axis=0)
    raise ValueError(
        f"atom {distance.argmax()} is off the square grid by {distance.max():.3g} "
        f"(spacing {spacing:.6g}): {_ADVICE}; numerical forces are along z, icarts=[2]"
    )
