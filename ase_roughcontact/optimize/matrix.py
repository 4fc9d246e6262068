"""The model of scattered atoms: their own matrix."""

from __future__ import annotations

import numpy as np

from ase_roughcontact.condensed import ScatteredHalfSpace


class Matrix:
    """Compliance of scattered atoms, exactly, and its inverse, roughly.

    It takes the place of `Circulant` and of `Patch`, see there.

    Parameters
    ----------
    halfspace : ScatteredHalfSpace
        The elastic solid.
    atoms : ndarray of int, shape (k,)
        Those that are looked at.

    Attributes
    ----------
    atoms : ndarray of int, shape (k,)
        The same.
    points : int
        Number of atoms: a product costs as much as one of the half space.
    local : float
        Compliance of an atom alone (length per pressure).
    exact : bool
        True.
    """

    exact = True

    def __init__(self, halfspace: ScatteredHalfSpace, atoms: np.ndarray) -> None:
        self.atoms = atoms
        self.points = halfspace.shape[0]
        self.local = halfspace.atom_compliance
        self._halfspace = halfspace
        self.transforms = 0

    def compliance(self, pressure: np.ndarray, members: np.ndarray) -> np.ndarray:
        """Depth of all atoms under pressure on the members."""
        return self._sunk(pressure, self.atoms[members])[self.atoms]

    def stiffness(self, depth: np.ndarray, members: np.ndarray) -> np.ndarray:
        """Pressure that brings each member to its depth alone."""
        return depth / self.local

    def covers(self, atoms: np.ndarray) -> bool:
        """Whether the matrix knows the atoms: it knows all."""
        return True

    def places(self, atoms: np.ndarray) -> np.ndarray:
        """Return the atoms as `depth` and `relieve` want them."""
        return atoms

    def depth(self, pressure: np.ndarray, where: np.ndarray) -> np.ndarray:
        """Depth of atoms under pressure on them."""
        return self._sunk(pressure, where)[where]

    def relief(self, stiffness: float, local: float) -> None:
        """Return what `relieve` needs: nothing."""

    def relieve(
        self, pressure: np.ndarray, where: np.ndarray, relief: None
    ) -> np.ndarray:
        """Pressure that is left when atoms are taken to be far from each other."""
        return pressure

    def _sunk(self, pressure: np.ndarray, where: np.ndarray) -> np.ndarray:
        self.transforms += 1
        return np.einsum("ij,j->i", self._halfspace.matrix[:, where], pressure)
