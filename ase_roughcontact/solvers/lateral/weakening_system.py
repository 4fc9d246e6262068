"""Linear equations of Newton's method for tractions and bounds that depend on slip."""

from __future__ import annotations

import numpy as np

from ase_roughcontact.solvers.lateral.friction_problem import (
    FrictionState,
    FrictionSystem,
)


class WeakeningSystem(FrictionSystem):
    """Linear equations for tractions and their bounds; see `weakening`.

    Parameters
    ----------
    state : FrictionState
        The state.
    slope : ndarray, shape (n, m)
        Derivatives of the bounds by the slip, of atoms held at their bounds.
    excess : ndarray, shape (n, m)
        Bounds after the slip of the state, less its bounds, of these atoms.
    """

    def __init__(
        self, state: FrictionState, slope: np.ndarray, excess: np.ndarray
    ) -> None:
        super().__init__(state)
        self._slope, self._excess = slope.astype(np.float32), excess

    def _along(self, shift: np.ndarray) -> np.ndarray:
        """Return the required changes along tractions at their bounds, at a shift."""
        along = np.tensordot(shift, self._direction, 1)
        return self._direction * (self._excess - self._slope * along)

    def _cleaned(self, change: np.ndarray) -> np.ndarray:
        """Return the change of the atoms in contact."""
        return self._touching * change

    def _changed(self, tractions: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the left side, with a component along tractions at their bounds."""
        across = self._project(values + self._curvature * tractions, self._normal)
        along = (self._normal * (tractions + self._slope * values)).sum(axis=0)
        return across + along * self._normal

    def _precondition(self, residual: np.ndarray) -> np.ndarray:
        result = super()._precondition(residual)
        along = (self._normal * self._field(residual)).sum(axis=0)
        field = self._field(result)
        field += along * self._normal
        return result
