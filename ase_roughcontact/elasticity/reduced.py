"""Free half space without the atoms of its padding.

The atoms in the padding of a free half space carry no force, so that their displacement
follows from the displacement of the window. Without them the stiffness of the window is
the inverse of the Green's function within the window. Energies and forces stay the
same, and there are about four times fewer atoms to keep, move and write. In exchange,
the pressure that belongs to a displacement is the solution of a linear system instead
of one FFT pair.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ase_roughcontact._util.validation import finite_array
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace

# Residual at which conjugate gradients stop, in rounding errors of the displacement.
_MAX_RESIDUAL = 50.0


class ReducedHalfSpace(FreeHalfSpace):
    """Free half space under a window without padding atoms.

    See `HalfSpace` for the parameters.

    Attributes
    ----------
    max_iterations : int
        Largest number of iterations of the conjugate gradients.
    """

    max_iterations = 200

    @property
    def dof_shape(self) -> tuple[int, int]:
        """Shape of the displacement field: the window."""
        return self.shape

    @cached_property
    def _clamped_stiffness(self) -> np.ndarray:
        """Stiffness of the window when the padding is held in place."""
        spectrum = self.grid_spectrum  # not positive for very stiff layers
        positive = np.maximum(
            spectrum, spectrum.min(where=spectrum > 0, initial=np.inf)
        )
        return self.window_transform.multiplier(1.0 / positive)

    def elastic_pressure(self, displacement: np.ndarray) -> np.ndarray:
        """Return the pressure that maintains a displacement of the window.

        Conjugate gradients solve ``-G p = u``, preconditioned by the stiffness of the
        window in a fixed padding. They take 27 to 44 FFT pairs in windows of 16 x 16
        to 200 x 200.

        Raises
        ------
        ValueError
            If a displacement is not finite.
        RuntimeError
            If the conjugate gradients do not converge.
        """
        residual = -finite_array("displacement", displacement)
        pressure, direction = np.zeros(residual.shape), np.zeros(residual.shape)
        rounding = float(np.finfo(self.window_transform.dtype).eps)
        tolerance = _MAX_RESIDUAL * rounding * float(abs(residual).max())
        last_work = np.inf
        for _ in range(self.max_iterations):
            if abs(residual).max() <= tolerance:
                return pressure
            preconditioned = self.window_transform.filter(
                residual, self._clamped_stiffness
            )
            work = np.einsum("ij,ij", residual, preconditioned)
            direction = preconditioned + (work / last_work) * direction
            depth = -self.displacement(direction)
            step = work / np.einsum("ij,ij", direction, depth)
            pressure += step * direction
            residual -= step * depth
            last_work = work
        raise RuntimeError(
            f"the pressure of a displacement up to {abs(displacement).max():.2g} did "
            f"not converge in {self.max_iterations} iterations: its residual is "
            f"{abs(residual).max():.2g}; increase max_iterations"
        )
