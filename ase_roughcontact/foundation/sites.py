"""Lattice sites of the lowest layers of a slab, and the atoms on them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from ase import Atoms

from ase_roughcontact.foundation.surface import CrystalSurface

# Largest relative difference of a side of the cell from a multiple of the surface cell.
_MAX_CELL_ERROR = 1e-4
# Largest distance of an atom from its site, and largest difference of displacements of
# neighbours, in spacings. A site of another stacking is at least 0.5 spacings away.
_MAX_SITE_DISTANCE = 0.3
# Largest mean displacement of a layer relative to the one below it, in spacings.
_MAX_LAYER_DISPLACEMENT = 0.1


@dataclass(frozen=True, eq=False)
class Sites:
    """Atoms of the lowest layers of a slab and their positions at rest.

    Parameters
    ----------
    indices : ndarray of int, shape (k, n, m)
        Indices of the atoms by layer, the lowest one last, and by cell.
    positions : ndarray, shape (k, n, m, 3)
        Positions at rest (Å).
    cell : ndarray, shape (3, 3)
        Periodic cell (Å).
    spacing : float
        Distance of nearest neighbours in the surface (Å).
    """

    indices: np.ndarray
    positions: np.ndarray
    cell: np.ndarray
    spacing: float

    @classmethod
    def of(
        cls, atoms: Atoms, surface: CrystalSurface, layers: int, coupled: int
    ) -> Sites:
        """Find the atoms of the lowest layers.

        Parameters
        ----------
        atoms : Atoms
            Slab without indenter.
        surface : CrystalSurface
            Surface of the crystal.
        layers : int
            Number of layers of the slab.
        coupled : int
            Number k of the lowest layers that are returned.

        Returns
        -------
        Sites
            Sites of the k lowest layers.

        Raises
        ------
        ValueError
            If the atoms of these layers are not at the sites of the crystal.
        """
        shape = cells(atoms, surface)
        number = shape[0] * shape[1]
        column = surface.column(layers)[layers - coupled :]
        if len(atoms) < layers * number:
            raise ValueError(
                f"{layers} layers of {shape[0]} x {shape[1]} cells are at least "
                f"{layers * number} atoms, got {len(atoms)}"
            )
        order = np.argsort(atoms.positions[:, 2], kind="stable")
        places = column.positions - column.positions[-1]
        rows = column.cell.array[:2]
        # sites have the mean position of the lowest layer
        lowest = atoms.positions[order[:number]]
        phases = 2.0 * np.pi * lowest[:, :2] @ np.linalg.inv(rows[:, :2])
        mean = np.angle(np.exp(1j * phases).mean(axis=0)) / (2.0 * np.pi)
        places += np.append(mean @ rows[:, :2], lowest[:, 2].mean())
        steps = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), -1)
        positions = places[:, None, None] + steps @ rows
        spacing = surface.constants.spacing
        indices = np.full((coupled, *shape), -1)
        for below in range(coupled):
            layer, place = indices[-1 - below], places[-1 - below]
            found = order[below * number : (below + 1) * number]
            relative = atoms.positions[found] - place
            cell = np.rint(relative[:, :2] @ np.linalg.inv(rows[:, :2])).astype(int)
            relative -= cell @ rows
            distance = np.linalg.norm(relative, axis=1)
            mean = np.linalg.norm(relative.mean(axis=0)) / spacing
            layer[tuple((cell % shape).T)] = found
            others = [i for i in found if atoms.symbols[i] != surface.symbol]
            displaced = distance.max() > _MAX_SITE_DISTANCE * spacing
            displaced |= mean > _MAX_LAYER_DISPLACEMENT * max(below, 1)
            if displaced or layer.min() < 0 or others:
                worst = found[distance.argmax()]
                reason = f"atom {worst} is {distance.max():.2f} Å from a site"
                if others:
                    reason = f"atom {others[0]} is {atoms.symbols[others[0]]}"
                raise ValueError(
                    f"layer {below + 1} from below is no layer of {surface.surface} "
                    f"{surface.symbol} with lattice constant "
                    f"{surface.lattice_constant:.4f} Å: {reason}. Check the atoms, or "
                    "use crystal_slab"
                )
        return cls(indices, positions, atoms.cell.array, spacing)

    def displacement(self, positions: np.ndarray) -> np.ndarray:
        """Return the displacement of the atoms from rest, up to a uniform displacement.

        The positions of all atoms are given; vectors of the cell may have been added to
        them. The result has the shape (k, n, m, 3) (Å).

        Raises
        ------
        ValueError
            If an atom has left its site.
        """
        moved = positions[self.indices] - self.positions
        moved -= moved[0, 0, 0].copy()
        across = moved[..., :2] @ np.linalg.inv(self.cell[:2, :2])
        moved -= np.rint(across) @ self.cell[:2]
        strain = [
            moved - np.roll(moved, 1, axis) for axis in (1, 2) if moved.shape[axis] > 1
        ]
        limit = (_MAX_SITE_DISTANCE * self.spacing) ** 2
        for part in (*strain, np.diff(moved, axis=0)):
            squares = np.einsum("...i,...i", part, part)
            if squares.size and not squares.max() <= limit:
                place = np.unravel_index(squares.argmax(), squares.shape)
                distance = squares.max() ** 0.5
                raise ValueError(
                    f"atom {self.indices[place]} in the {self.indices.shape[0]} lowest "
                    f"layers has left its lattice site by {distance:.2f} Å: use more "
                    "layers, or a lower load, temperature or time step; after removing "
                    "atoms make a new foundation"
                )
        return moved


def cells(atoms: Atoms, surface: CrystalSurface) -> tuple[int, int]:
    """Return the number of surface cells along both sides of the atoms' cell.

    Raises
    ------
    ValueError
        If the sides are not multiples of the sides of the surface cell, or the atoms
        are not periodic along x and y only.
    """
    if atoms.pbc.tolist() != [True, True, False]:
        raise ValueError(
            "an elastic foundation is periodic along x and y only: set pbc to (True, "
            f"True, False), got {atoms.pbc.tolist()}. Free boundaries are not supported"
        )
    unit, sides = surface.column(1).cell.array[:2], atoms.cell.array[:2]
    numbers = np.linalg.norm(sides, axis=1) / np.linalg.norm(unit, axis=1)
    n, m = np.rint(numbers).astype(int).tolist()
    expected = np.array([n, m])[:, None] * unit
    error = np.linalg.norm(sides - expected, axis=1)
    if min(n, m) < 1 or (error > _MAX_CELL_ERROR * np.linalg.norm(unit, axis=1)).any():
        raise ValueError(
            f"the sides of the cell must be multiples of {unit[0, :2].round(5)} and "
            f"{unit[1, :2].round(5)} Å for {surface.surface} {surface.symbol} with "
            f"lattice constant {surface.lattice_constant:.5f} Å, got "
            f"{sides[0].round(5)} and {sides[1].round(5)}: use crystal_slab, or this "
            "lattice constant"
        )
    return n, m
