"""Base class of preconditioners that stay the same during a relaxation."""

from __future__ import annotations

from abc import abstractmethod
from typing import TypeVar

import numpy as np
from ase import Atoms
from ase.optimize.precon import Precon

Same = TypeVar("Same", bound="ConstantPrecon")


class ConstantPrecon(Precon):
    """Preconditioner of ASE's optimizers that does not depend on the positions.

    Parameters
    ----------
    size : int
        Number of atoms.
    """

    def __init__(self, size: int) -> None:
        self._size = size

    @abstractmethod
    def _applied(self, vectors: np.ndarray, inverse: bool) -> np.ndarray:
        """Return the product of P, or of its inverse, and vectors of shape (N, 3)."""

    def make_precon(self, atoms: Atoms, reinitialize: bool | None = None) -> None:
        """Do nothing: the preconditioner does not depend on the positions."""

    def Pdot(self, x: np.ndarray) -> np.ndarray:  # noqa: N802
        """Apply P to a vector of shape (3 N,)."""
        return self._applied(x.reshape(-1, 3), inverse=False).reshape(x.shape)

    def solve(self, x: np.ndarray) -> np.ndarray:
        """Apply the inverse of P to a vector of shape (3 N,)."""
        return self._applied(x.reshape(-1, 3), inverse=True).reshape(x.shape)

    def copy(self: Same) -> Same:
        """Return the preconditioner itself, which has no state."""
        return self

    def asarray(self) -> np.ndarray:
        """Return P as a matrix; for tests on few atoms."""
        return np.array([self.Pdot(column) for column in np.eye(3 * self._size)])
