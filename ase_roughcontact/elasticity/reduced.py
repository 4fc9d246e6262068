"""Half spaces of which only the atoms are there that may touch.

The margin of a free half space carries no force, so that its displacement follows from
that of the others. Without it the stiffness of the atoms that are left is the inverse
of the Green's function among them: energies and forces stay the same, and there are
fewer atoms to keep, to move and to write. In turn a pressure that is asked of a
displacement costs the solution of a linear system.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ase_roughcontact._util.validation import finite_array
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace

# The residual displacement that is left of a linear system, in roundings, and the steps
# that it may take.
_ROUNDINGS = 50.0
_STEPS = 200


class ReducedHalfSpace(FreeHalfSpace):
    """Free half space below a window without a margin.

    See `HalfSpace` for the parameters.
    """

    @property
    def dof_shape(self) -> tuple[int, int]:
        """Shape of the atoms that are displaced: the window."""
        return self.shape

    @property
    def dof_transform(self) -> RealFFT2:
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
