"""Half spaces of which only the atoms are there that may touch.

The margin of a free half space carries no force, so that its displacement follows from
that of the others. Without it the stiffness of the atoms that are left is the inverse
of the Green's function among them: energies and forces stay the same, and there are
fewer atoms to keep, to move and to write. In turn a pressure that is asked of a
displacement costs the solution of a linear system.
"""

from __future__ import annotations

from functools import cached_property, partial
from typing import Any

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from ase_roughcontact._util.validation import finite_array
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, HalfSpace, love_kernel

# The residual displacement that is left of a linear system, in roundings, and the steps
# that it may take.
_ROUNDINGS = 50.0
_STEPS = 200
# Rows of the matrix that are calculated at once.
_ROWS = 256


class ReducedHalfSpace(FreeHalfSpace):
    """Free half space below a window without a margin.

    See `HalfSpace` for the parameters.
    """

    @property
    def layer(self) -> tuple[int, int]:
        """Shape of the atoms that are displaced: the window."""
        return self.shape

    @property
    def layer_transform(self) -> RealFFT2:
        """Transform of all atoms that are displaced."""
        return self.window_transform

    @cached_property
    def _clamped(self) -> np.ndarray:
        return self.window_transform.multiplier(self._own_inverse)

    def elastic_pressure(self, displacement: np.ndarray) -> np.ndarray:
        """Pressure that holds the window at a displacement.

        By conjugate gradients, preconditioned by the stiffness of a window in a margin
        that does not move: 27 to 44 pairs of transforms in windows of 16 x 16 to
        200 x 200.

        Parameters
        ----------
        displacement : ndarray, shape (n, m)
            Length.

        Returns
        -------
        ndarray, shape (n, m)
            Positive in compression (pressure).

        Raises
        ------
        ValueError
            If a displacement is not finite.
        RuntimeError
            If the conjugate gradients do not converge.
        """
        rest = -finite_array("displacement", displacement)
        pressure, direction = np.zeros(rest.shape), np.zeros(rest.shape)
        rounding = float(np.finfo(self.window_transform.dtype).eps)
        allowed = _ROUNDINGS * rounding * float(abs(rest).max())
        last = np.inf
        for _ in range(_STEPS):
            if abs(rest).max() <= allowed:
                return pressure
            relaxed = self.window_transform.filter(rest, self._clamped)
            work = np.einsum("ij,ij", rest, relaxed)
            direction = relaxed + (work / last) * direction
            sunk = -self.displacement(direction)
            length = work / np.einsum("ij,ij", direction, sunk)
            pressure += length * direction
            rest -= length * sunk
            last = work
        raise RuntimeError(
            f"no pressure was found for a displacement: after {_STEPS} steps "
            f"{abs(rest).max():.2g} of {abs(displacement).max():.2g} are left"
        )

    def padded_displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Displacement of the window by a pressure; see `HalfSpace`."""
        return self.displacement(pressure)


class ScatteredHalfSpace(HalfSpace):
    """Free half space below a few atoms anywhere on the lattice.

    Their Green's function is a matrix. It costs the square of their number, and
    nothing for the empty lattice between them.

    Parameters
    ----------
    sites : ndarray of int, shape (k, 2)
        Places of the atoms, in spacings.
    spacing : float
        Side of a cell, the atomic spacing a0 (length).
    contact_modulus : float
        ``E* = E/(1 - nu^2)`` (pressure).
    **fft
        Kept for other windows, see `like`; of no use here.

    Attributes
    ----------
    shape, grid, layer : (int, int)
        ``(k, 1)``: all arrays are columns.
    pairs : int
        Number of products with the matrix.
    """

    periodic = False

    def __init__(
        self, sites: np.ndarray, spacing: float, contact_modulus: float, **fft: Any
    ) -> None:
        self.sites = np.asarray(sites, dtype=int)
        if self.sites.ndim != 2 or self.sites.shape[1] != 2 or not self.sites.size:
            raise ValueError(
                f"sites must have the shape (k, 2), k > 0, got {self.sites.shape}"
            )
        super().__init__((len(self.sites), 1), spacing, contact_modulus, **fft)
        self._products = 0

    def __reduce__(self) -> tuple:
        """Rebuild from the parameters."""
        args = (self.sites, self.spacing, self.contact_modulus)
        return partial(ScatteredHalfSpace, **self.fft), args

    def like(self, shape: tuple[int, int], spacing: float) -> ReducedHalfSpace:
        """Half space of the same solid under a grid; see `HalfSpace.like`."""
        fft = {**self.fft, "measure": False}
        return ReducedHalfSpace(shape, spacing, self.contact_modulus, **fft)

    @property
    def lattice(self) -> bool:
        """Whether the window is a rectangle of which parts can be taken."""
        return False

    @property
    def pairs(self) -> int:
        """Number of products with the matrix so far."""
        return self._products

    @staticmethod
    def padded(shape: tuple[int, int]) -> tuple[int, int]:
        """No padding."""
        return shape

    def symbol(self, grid: tuple[int, int]) -> np.ndarray:
        """Refuse: scattered atoms have no waves."""
        raise ValueError(
            "scattered atoms are no grid, and have no Fourier modes: relax them with "
            "NewtonKrylov, ActiveSet, or one of ASE's optimizers on the atoms"
        )

    @cached_property
    def matrix(self) -> np.ndarray:
        """Green's function among the atoms, shape (k, k) (length per pressure)."""
        count = len(self.sites)
        matrix = np.empty((count, count))
        for start in range(0, count, _ROWS):
            rows = self.sites[start : start + _ROWS, None]
            i, j = np.moveaxis(rows - self.sites, 2, 0)
            matrix[start : start + _ROWS] = love_kernel(
                i, j, self.spacing, self.contact_modulus
            )
        return matrix

    @cached_property
    def _factor(self) -> tuple[np.ndarray, bool]:
        return cho_factor(self.matrix)

    def displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Displacement by a pressure; see `HalfSpace.displacement`."""
        self._products += 1
        return -np.einsum("ij,jk->ik", self.matrix, pressure)

    def elastic_pressure(self, displacement: np.ndarray) -> np.ndarray:
        """Pressure that holds the atoms; see `HalfSpace.elastic_pressure`."""
        self._products += 1
        return -cho_solve(self._factor, displacement)

    def padded_displacement(self, pressure: np.ndarray) -> np.ndarray:
        """Displacement by a pressure; see `HalfSpace.padded_displacement`."""
        return self.displacement(pressure)
