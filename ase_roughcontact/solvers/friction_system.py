r"""Linear equations of a step of Newton's method for a contact with friction.

The change x of the tractions and, under a force, s of the shift solve

.. math:: Q (G * x - s) + \lambda x = Q g, \qquad \sum x + k s = f,

with the projection Q onto the components that may change: both where atoms stick, and
the one across the traction where they slip; f is what the force lacks. They are solved
by generalised conjugate residuals in single precision, preconditioned by

.. math:: w\, G^{-1} w + \frac{1 - w^2}{\lambda + c}, \qquad
          w = \frac{c}{c + \lambda}, \qquad c = 4 G_0 ,

the inverse spectrum for the atoms that stick, and the diagonal where the curvature
exceeds a few times the self-compliance :math:`G_0`; the shift is eliminated exactly.
"""

from __future__ import annotations

import numpy as np

from ase_roughcontact._util.kernels import norm
from ase_roughcontact.solvers.friction_problem import FrictionState
from ase_roughcontact.solvers.gcr import gcr

# Curvature, relative to the self-compliance, above which preconditioning is diagonal.
_CURVED = np.float32(4.0)
# Smallest stiffness against a shift, relative to the largest one: all atoms slip.
_SOFTEST = 1e-10


class FrictionSystem:
    """Linear equations at a state.

    Vectors are arrays (2, n m + 1) with the shift behind the tractions of all atoms.

    Parameters
    ----------
    state : FrictionState
    """

    def __init__(self, state: FrictionState) -> None:
        problem, touching = state.problem, state.problem.bound > 0.0
        self._state, self._halfspace = state, problem.halfspace
        self._driven, self._spring = problem.force is not None, problem.spring
        self._direction = state.direction * state.slipping
        self._normal = self._direction.astype(np.float32)
        self._touching = touching.astype(np.float32)
        curvature = np.hypot(*state.opening) * state.slipping
        np.divide(curvature, problem.bound, out=curvature, where=touching)
        self._curvature = curvature.astype(np.float32)
        self._weight = self._touching * _CURVED / (_CURVED + self._curvature)
        rest = self._touching - self._weight**2
        self._diagonal = rest / (_CURVED + self._curvature)
        self._size = max(np.count_nonzero(touching), 1)
        if self._driven:
            # changes of the tractions by shifts along x and y
            axes = np.eye(2, dtype=np.float32)[:, :, None, None]
            shifts = [self._project(axis, self._normal) for axis in axes]
            self._by_shift = np.stack([self._stiffened(shift) for shift in shifts])
            stiffness = self._by_shift.sum(axis=(2, 3), dtype=float)
            stiffness = 0.5 * (stiffness + stiffness.T) + self._spring * np.eye(2)
            self._softness = np.linalg.pinv(stiffness, _SOFTEST)

    def solve(self, error: float, max_steps: int) -> np.ndarray:
        """Return the change of the tractions, to a relative error of the residual."""
        state = self._state
        opening = self._project(state.opening, self._direction)
        if self._driven and not self._spring:  # without what a shift closes
            axes = np.eye(2)[:, :, None, None]
            shifts = [self._project(axis, self._direction).ravel() for axis in axes]
            shift = np.linalg.lstsq(np.stack(shifts, 1), opening.ravel())[0]
            opening = opening - np.reshape(shift @ shifts, opening.shape)
        right = np.zeros((2, opening[0].size + 1), np.float32)
        self._field(right)[:] = opening
        right[:, -1] = state.missing / self._size
        limit = error * norm(right)
        change = gcr(self._apply, self._precondition, right, limit, max_steps)
        change = np.broadcast_to(change, right.shape)
        # also its rounding errors along the traction, or atoms would leave their bound
        return self._project(self._field(change), self._direction)

    def _field(self, vector: np.ndarray) -> np.ndarray:
        """Return a view of the tractions, shape (2, n, m)."""
        return vector[:, :-1].reshape(2, *self._touching.shape)

    def _project(self, values: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """Return the components along which tractions may change."""
        values = self._touching * values
        return values - normal * (normal * values).sum(axis=0)

    def _apply(self, change: np.ndarray) -> np.ndarray:
        tractions, shift = self._field(change), change[:, -1]
        values = self._halfspace.relative_displacement(tractions)
        result = np.zeros_like(change)
        if self._driven:
            values -= shift[:, None, None]
            sums = tractions.sum(axis=(1, 2), dtype=float)
            result[:, -1] = (sums + self._spring * shift) / self._size
        values = self._project(values, self._normal) + self._curvature * tractions
        self._field(result)[:] = values
        return result

    def _precondition(self, residual: np.ndarray) -> np.ndarray:
        result = np.zeros_like(residual)
        values = self._stiffened(self._field(residual))
        if self._driven:
            sums = values.sum(axis=(1, 2), dtype=float)
            shift = self._softness @ (self._size * residual[:, -1] - sums)
            result[:, -1] = shift
            values += np.tensordot(result[:, -1], self._by_shift, 1)
        self._field(result)[:] = values
        return result

    def _stiffened(self, values: np.ndarray) -> np.ndarray:
        """Return approximate tractions that cause a displacement."""
        smooth = self._halfspace.relative_stiffness(self._weight * values)
        return self._project(
            self._weight * smooth + self._diagonal * values, self._normal
        )
