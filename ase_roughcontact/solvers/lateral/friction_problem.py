r"""Friction problem, states of the tractions, and linear equations of Newton's method.

Lengths are in units of the self-compliance times the unit of pressure.

In a step of Newton's method the change x of the tractions and, under a force, the
change s of the indenter's displacement solve

.. math:: Q (G * x - s) + \lambda x = Q g, \qquad \sum x + k s = f .

The projection Q selects the components that may change: both components for atoms that
stick, and the component across the traction for atoms that slip. The missing force is
f. Generalised conjugate residuals solve the equations in single precision,
preconditioned by

.. math:: w\, G^{-1} w + \frac{1 - w^2}{\lambda + c}, \qquad
          w = \frac{c}{c + \lambda}, \qquad c = 4 G_0 ,

the inverse spectrum for atoms that stick, and the diagonal where the curvature exceeds
a few times the self-compliance :math:`G_0`; the change s is eliminated exactly.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ase_roughcontact._util.kernels import norm
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.solvers.gcr import gcr

# Largest relative distance of a traction at its bound.
_BOUND_ROUNDING = 1e-12
# Rounding error of the minimised function, relative to the sum of its terms.
_FUNCTION_ROUNDING = 1e-12
# Curvature, relative to the self-compliance, above which preconditioning is diagonal.
_DIAGONAL_CURVATURE = np.float32(4.0)
# Smallest stiffness against a displacement of the indenter, relative to the largest
# one; below it, all atoms slip.
_MIN_RELATIVE_STIFFNESS = 1e-10
# Relative rounding error of a sum of tractions.
_SUM_ROUNDING = 1e-13
# Largest number of sums in the search for a shift.
_MAX_SUMS = 100
# Smallest ratio by which a shift that was too long is shortened.
_MIN_STEP_RATIO = 0.01
# Smallest slope of the sums, relative to the mean slope.
_MIN_SLOPE = 1e-14


def bounded(tractions: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Return tractions with magnitudes of at most a bound, in the same directions."""
    return tractions * _part(np.hypot(*tractions), bound)


def _part(size: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Return the factors by which a bound reduces magnitudes."""
    return np.divide(bound, size, out=np.ones_like(size), where=size > bound)


def balancing_shift(
    values: np.ndarray,
    bound: np.ndarray,
    total: np.ndarray,
    spring: float,
    shift: np.ndarray,
) -> np.ndarray:
    r"""Return s so that :math:`\sum P(v_i + s) + k s` is a given total.

    The sum is the gradient of a convex function of s, which is minimised by Newton's
    method; a move beyond the minimum is shortened by secants.

    Parameters
    ----------
    values : ndarray, shape (2, atoms)
        Tractions v before the projection P onto the bounds (pressure).
    bound : ndarray, shape (atoms,)
        Largest magnitudes (pressure).
    total : ndarray, shape (2,)
        Required total, with a magnitude below the sum of the bounds unless there is a
        spring (pressure).
    spring : float
        Stiffness k of the spring.
    shift : ndarray, shape (2,)
        First guess of s (pressure).

    Returns
    -------
    ndarray, shape (2,)
        Shift s (pressure).
    """
    move, missing = np.zeros(2), np.zeros(2)
    for _ in range(_MAX_SUMS):
        moved = values + (shift + move)[:, None]
        size = np.hypot(*moved)
        part = _part(size, bound)
        rest = total - moved @ part - spring * (shift + move)
        before, after = float(missing @ move), float(rest @ move)
        if after < -0.5 * before:
            move = max(before / (before - after), _MIN_STEP_RATIO) * move
            continue
        shift, missing = shift + move, rest
        if np.hypot(*missing) <= _SUM_ROUNDING * (np.hypot(*total) + part @ size):
            break
        # a difference of sums over all directions would round to a negative slope
        across = np.divide(
            moved[::-1], size, out=np.zeros_like(moved), where=part < 1.0
        )
        across[0] *= -1.0
        slope = (np.count_nonzero(part == 1.0) + spring) * np.eye(2)
        least = _MIN_SLOPE * (part.sum() + spring) * np.eye(2)
        move = np.linalg.solve(slope + (part * across) @ across.T + least, missing)
        if size.size:  # beyond this length all atoms slip along the move
            longest = float(size.max() + bound.max())
            move *= min(1.0, longest / max(np.hypot(*move), longest))
    return shift


@dataclass(frozen=True, eq=False)
class FrictionProblem:
    """Contact with friction at a given displacement, or under a lateral force.

    Attributes
    ----------
    halfspace : LateralHalfSpace
        Lateral compliance of the surface.
    bound : ndarray, shape (n, m)
        Largest magnitude of the traction, zero for atoms out of contact.
    imposed : ndarray, shape (2, n, m)
        Displacement of atoms that stick.
    force : ndarray, shape (2,), or None
        Sum of the tractions and of the force of the spring; None if the displacement of
        the indenter is given.
    spring : float
        Stiffness of the spring: decrease of the sum of the tractions with the shift of
        the indenter.
    """

    halfspace: LateralHalfSpace
    bound: np.ndarray
    imposed: np.ndarray
    force: np.ndarray | None = None
    spring: float = 0.0

    def at(
        self, tractions: np.ndarray, shift: np.ndarray, steps: int = 0
    ) -> FrictionState:
        """Return the state of given tractions after a number of steps: one FFT pair."""
        halfspace = self.halfspace
        opening = self.imposed - (
            halfspace.displacement(tractions) / halfspace.self_compliance
        )
        if self.force is not None:
            atoms = self._touching
            values = opening[:, atoms]
            if not shift.any() and values.size:
                shift = -values.mean(axis=1)
            values = values + tractions[:, atoms]
            shift = balancing_shift(
                values, self.bound[atoms], self.force, self.spring, shift
            )
            opening += shift[:, None, None]
        return FrictionState(self, tractions, opening, shift, steps)

    def moved(self, state: FrictionState, step: np.ndarray) -> FrictionState:
        """Return the state after a step, within the bounds and with the same force."""
        tractions = state.tractions + step
        total = self.force
        if self.spring:
            total = tractions.sum(axis=(1, 2))
        tractions = self.feasible(tractions, total)
        return self.at(tractions, state.shift, state.steps + 1)

    def feasible(self, tractions: np.ndarray, total: np.ndarray | None) -> np.ndarray:
        """Return tractions within the bounds, with the given sum if there is one.

        Tractions below their bound restore the sum, or all tractions if these do not
        suffice.
        """
        tractions = bounded(tractions, self.bound)
        if total is None:
            return tractions
        atoms = np.hypot(*tractions) < (1.0 - _BOUND_ROUNDING) * self.bound
        rest = total - tractions[:, ~atoms].sum(axis=1)
        if not self.spring and np.hypot(*rest) >= self.bound[atoms].sum():
            atoms, rest = self._touching, total
        values, bound = tractions[:, atoms], self.bound[atoms]
        shift = balancing_shift(values, bound, rest, self.spring, np.zeros(2))
        tractions[:, atoms] = bounded(values + shift[:, None], bound)
        return tractions

    @cached_property
    def _touching(self) -> np.ndarray:
        return self.bound > 0.0


@dataclass(frozen=True, eq=False)
class FrictionState:
    """Tractions, with the opening g and the shift of the indenter.

    Attributes
    ----------
    problem : FrictionProblem
        The problem.
    tractions, opening : ndarray, shape (2, n, m)
        Tractions, and openings g between indenter and surface.
    shift : ndarray, shape (2,)
        Displacement of the indenter in addition to the imposed displacement. With it, a
        step along the opening would conserve the force.
    steps : int
        Number of steps of Newton's method so far.
    """

    problem: FrictionProblem
    tractions: np.ndarray
    opening: np.ndarray
    shift: np.ndarray
    steps: int

    @cached_property
    def displacement(self) -> np.ndarray:
        """Displacement of the surface."""
        return self.problem.imposed + self.shift[:, None, None] - self.opening

    @cached_property
    def residual(self) -> float:
        """Residual, see `FrictionSolution`; at least the error of the force."""
        trial = bounded(self.tractions + self.opening, self.problem.bound)
        largest = float(np.hypot(*trial).max())
        if not largest:
            return self.error
        change = float(np.hypot(*(trial - self.tractions)).max())
        return max(change / largest, self.error)

    @property
    def missing(self) -> np.ndarray:
        """Missing force along x and y."""
        problem = self.problem
        if problem.force is None:
            return np.zeros(2)
        sums = self.tractions.sum(axis=(1, 2))
        return problem.force - problem.spring * self.shift - sums

    @cached_property
    def error(self) -> float:
        """Missing force, relative to the sum of all magnitudes or to a larger force."""
        if self.problem.force is None:
            return 0.0
        sizes = np.hypot(*self.tractions).sum(), np.hypot(*self.problem.force)
        size = float(max(sizes))
        return float(np.hypot(*self.missing)) / size if size else 0.0

    @cached_property
    def direction(self) -> np.ndarray:
        """Unit vectors along the tractions; zero for atoms without traction."""
        size = np.hypot(*self.tractions)
        return np.divide(
            self.tractions, size, out=np.zeros_like(self.tractions), where=size > 0.0
        )

    @cached_property
    def held_at_bound(self) -> np.ndarray:
        """Mask of the atoms that the next step leaves at their bound.

        Their traction is at the bound, up to rounding, and the opening is along it.
        """
        bound = self.problem.bound
        at_bound = np.hypot(*self.tractions) >= (1.0 - _BOUND_ROUNDING) * bound
        driven = (self.opening * self.direction).sum(axis=0) > 0.0
        return (bound > 0.0) & at_bound & driven

    def slipping(self, tolerance: float) -> np.ndarray:
        """Return the mask of the atoms that slip, within a tolerance of the residual.

        Without the bound, the opening would raise the traction above the bound by more
        than the tolerance times the largest traction.
        """
        bound = self.problem.bound
        excess = np.hypot(*(self.tractions + self.opening)) - bound
        largest = float(np.hypot(*self.tractions).max())
        return (bound > 0.0) & (excess > tolerance * largest)

    def rises(self, other: FrictionState) -> bool:
        """Return whether another state has a higher energy, beyond rounding errors."""
        opening, spring = self.opening + other.opening, self.problem.spring
        if spring:  # the spring's displacement follows from the sum of the tractions
            shifts = (state.missing / spring for state in (self, other))
            opening = opening + np.sum(list(shifts), axis=0)[:, None, None]
        gain = ((other.tractions - self.tractions) * opening).sum()
        terms = float(abs(self.tractions * self.displacement).sum())
        return bool(gain < -_FUNCTION_ROUNDING * terms)


class FrictionSystem:
    """Linear equations of Newton's method at a state.

    Vectors are arrays of shape (2, n m + 1), with the shift after the tractions of all
    atoms.

    Parameters
    ----------
    state : FrictionState
        The state.
    """

    def __init__(self, state: FrictionState) -> None:
        problem, touching = state.problem, state.problem.bound > 0.0
        self._state, self._halfspace = state, problem.halfspace
        self._driven, self._spring = problem.force is not None, problem.spring
        self._direction = state.direction * state.held_at_bound
        self._normal = self._direction.astype(np.float32)
        self._touching = touching.astype(np.float32)
        curvature = np.hypot(*state.opening) * state.held_at_bound
        np.divide(curvature, problem.bound, out=curvature, where=touching)
        self._curvature = curvature.astype(np.float32)
        denominator = _DIAGONAL_CURVATURE + self._curvature
        self._weight = self._touching * _DIAGONAL_CURVATURE / denominator
        self._diagonal = (self._touching - self._weight**2) / denominator
        self._size = max(np.count_nonzero(touching), 1)
        if self._driven:
            # changes of the tractions by shifts along x and y
            axes = np.eye(2, dtype=np.float32)[:, :, None, None]
            shifts = [self._project(axis, self._normal) for axis in axes]
            self._by_shift = np.stack([self._stiffened(shift) for shift in shifts])
            stiffness = self._by_shift.sum(axis=(2, 3), dtype=float)
            stiffness = 0.5 * (stiffness + stiffness.T) + self._spring * np.eye(2)
            self._compliance = np.linalg.pinv(stiffness, _MIN_RELATIVE_STIFFNESS)

    def solve(self, error: float, max_steps: int) -> np.ndarray:
        """Return the change of the tractions, to a relative error of the residual."""
        state = self._state
        opening, shift = self._project(state.opening, self._direction), np.zeros(2)
        if self._driven and not self._spring:  # leave out openings that a shift closes
            axes = np.eye(2)[:, :, None, None]
            shifts = [self._project(axis, self._direction).ravel() for axis in axes]
            columns = np.stack(shifts, axis=1)
            shift = np.linalg.lstsq(columns, opening.ravel(), rcond=None)[0]
            opening = opening - np.reshape(shift @ shifts, opening.shape)
        right = np.zeros((2, opening[0].size + 1), np.float32)
        self._field(right)[:] = opening + self._along(shift)
        right[:, -1] = state.missing / self._size
        limit = error * norm(right)
        change = gcr(self._apply, self._precondition, right, limit, max_steps)
        change = np.broadcast_to(change, right.shape)
        return self._cleaned(self._field(change))

    def _along(self, shift: np.ndarray) -> np.ndarray | float:
        """Return the required changes along tractions at their bounds, at a shift."""
        return 0.0

    def _cleaned(self, change: np.ndarray) -> np.ndarray:
        """Return a change without rounding errors by which atoms leave their bounds."""
        return self._project(change, self._direction)

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
        self._field(result)[:] = self._changed(tractions, values)
        return result

    def _changed(self, tractions: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the left side of changed tractions, and displacements from these."""
        return self._project(values, self._normal) + self._curvature * tractions

    def _precondition(self, residual: np.ndarray) -> np.ndarray:
        result = np.zeros_like(residual)
        values = self._stiffened(self._field(residual))
        if self._driven:
            sums = values.sum(axis=(1, 2), dtype=float)
            shift = self._compliance @ (self._size * residual[:, -1] - sums)
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
