r"""Slip in time, if friction depends on the slip rate.

Over a time h the atoms in contact slip at rates V. With the opening :math:`g = c - G *
t`, as in `friction`, all of them slip,

.. math:: g = h V \frac{t}{|t|}, \qquad |t| = \tau(V) + \eta V,

with a friction that increases with the rate and a radiation damping. The
unknown is :math:`q = t + g/G_0`, with the self-compliance :math:`G_0`. Traction and
slip of an atom are functions of it with slopes between zero and one, a smooth form of
the projection onto a bound: :math:`t = T(q)` with :math:`|t| + h V/G_0 = |q|`. Newton's
method solves

.. math:: G * T(q) + G_0 [q - T(q)] = c .

With the slopes w of T along and across the traction, :math:`s^2 = \kappa w/(1 + (\kappa
- 1) w)` and :math:`\kappa = 4`, its linear equations are

.. math:: [s\, G s + \kappa G_0 (1 - s^2)]\, y = -s\, r, \qquad \Delta t = s y,

for the residual r, without a large number where an atom slips freely. Generalised
conjugate residuals solve them with the preconditioner :math:`s\, G^{-1} s + (1 -
s^4)/(\kappa G_0)`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ase_roughcontact._util.kernels import norm
from ase_roughcontact.contact.support import LateralSupport
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.interactions.rate_and_state import RateFriction
from ase_roughcontact.solvers.gcr import gcr

# Largest number of steps of Newton's method for the traction of an atom.
_MAX_LOCAL_STEPS = 60
# Error of this traction, relative to the traction.
_LOCAL_ERROR = 1e-14
# Compliance, relative to the self-compliance, above which preconditioning is diagonal.
_DIAGONAL = np.float32(4.0)
# Smallest stiffness against a displacement of the indenter, relative to the largest.
_MIN_RELATIVE_STIFFNESS = 1e-10
# Largest number of steps of Newton's method.
_MAX_STEPS = 50
# Largest number of iterations for the linear equations of a step.
_MAX_ITERATIONS = 60
# Residual of the linear equations, relative to the right-hand side.
_FORCING = 0.01


@dataclass(frozen=True, eq=False)
class RateProblem:
    """Atoms that slip for a time at rates that depend on their tractions.

    Attributes
    ----------
    halfspace : LateralHalfSpace
    law : RateFriction
    pressure : ndarray, shape (n, m)
        Pressures; atoms without a positive one have no traction (pressure).
    history : mapping of str to ndarray of shape (n, m)
        Histories of the law at the end.
    imposed : ndarray, shape (2, n, m)
        Displacement of atoms that stick (length).
    duration : float
        Time.
    support : LateralSupport or None
        Support of the indenter, None if its displacement is given.
    compliance : float
        Factor of the solid's compliance, larger than 1 if it creeps.
    """

    halfspace: LateralHalfSpace
    law: RateFriction
    pressure: np.ndarray
    history: Mapping[str, np.ndarray]
    imposed: np.ndarray
    duration: float
    support: LateralSupport | None = None
    compliance: float = 1.0

    @property
    def self_compliance(self) -> float:
        """Displacement of an atom by unit traction on it alone (length/pressure)."""
        return self.compliance * self.halfspace.self_compliance

    def displacement(self, tractions: np.ndarray) -> np.ndarray:
        """Return the lateral displacement by tractions: one FFT pair."""
        return self.compliance * self.halfspace.displacement(tractions)


@dataclass(frozen=True, eq=False)
class RateSolution:
    """Tractions and slip rates of a `RateProblem`.

    Attributes
    ----------
    trial : ndarray, shape (2, n, m)
        Unknown q of the equations (pressure).
    tractions : ndarray, shape (2, n, m)
        Tractions at the end (pressure).
    rates : ndarray, shape (2, n, m)
        Slip rates along the tractions (length/time).
    shift : ndarray, shape (2,)
        Displacement of the indenter by a spring or a force (length).
    residual : float
        Largest residual of the displacements, relative to the largest traction times
        the self-compliance.
    steps : int
        Steps of Newton's method.
    """

    trial: np.ndarray
    tractions: np.ndarray
    rates: np.ndarray
    shift: np.ndarray
    residual: float
    steps: int


@dataclass(frozen=True, eq=False)
class _Response:
    """Tractions and rates of given unknowns, and slopes of the tractions."""

    tractions: np.ndarray
    rates: np.ndarray
    direction: np.ndarray
    along: np.ndarray
    across: np.ndarray


@dataclass(frozen=True, eq=False)
class _State:
    """Unknowns with their residuals, in units of pressure."""

    trial: np.ndarray
    shift: np.ndarray
    response: _Response
    residual: np.ndarray
    missing: np.ndarray

    @cached_property
    def error(self) -> float:
        """Largest residual, relative to the largest traction, or error of the force."""
        sizes = np.hypot(*self.response.tractions)
        largest, total = float(sizes.max(initial=0.0)), float(sizes.sum())
        rest = float(np.hypot(*self.residual).max(initial=0.0))
        lack = float(np.hypot(*self.missing))
        if not largest:
            return 1.0 if rest or lack else 0.0
        return max(rest / largest, lack / total)


def tractions_of(
    law: RateFriction,
    pressure: np.ndarray,
    history: Mapping[str, Any],
    trial: np.ndarray,
    compliance: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    r"""Return tractions that slip reduces: :math:`|t| + C V = |q|`.

    Parameters
    ----------
    law : RateFriction
    pressure : ndarray, shape (k,)
        Positive pressures (pressure).
    history : mapping of str to ndarray of shape (k,)
        Histories of the law.
    trial : ndarray, shape (k,)
        Magnitudes of the tractions without slip, q (pressure).
    compliance : float
        Decrease C of the traction per slip rate (pressure time/length); with
        the damping it must be positive.

    Returns
    -------
    tractions, rates, slopes : ndarray, shape (k,)
        Tractions, slip rates, and derivatives of the tractions by q.
    """
    total = law.damping + compliance
    unknown = np.full(trial.shape, np.nan)
    limit = law.bound(
        pressure, unknown, trial / total, np.nan, history, unknown, unknown
    )
    friction = np.minimum(trial, limit)  # at least the solution; the rate is convex
    for _ in range(_MAX_LOCAL_STEPS):
        rate, slope = law.slip_rate(friction, pressure, history)
        step = (friction + total * rate - trial) / (1.0 + total * slope)
        friction = np.maximum(friction - step, 0.0)
        if (abs(step) <= _LOCAL_ERROR * trial).all():
            break
    rate, slope = law.slip_rate(friction, pressure, history)
    # a small difference of the tractions is less accurate than the rate of the law
    rate = np.where(total * rate < 0.5 * trial, rate, (trial - friction) / total)
    slopes = (1.0 + law.damping * slope) / (1.0 + total * slope)
    return friction + law.damping * rate, rate, slopes


def solve_rates(
    problem: RateProblem,
    guess: RateSolution,
    tolerance: float,
) -> RateSolution:
    """Return tractions and slip rates after a time, by Newton's method.

    Parameters
    ----------
    problem : RateProblem
    guess : RateSolution
        Solution from which to start.
    tolerance : float
        Largest residual.

    Returns
    -------
    RateSolution
        The solution, with a larger residual if it has not converged.
    """
    state = _state(problem, guess.trial, guess.shift)
    steps = 0
    while state.error > tolerance and steps < _MAX_STEPS:
        state = _following(problem, state)
        steps += 1
    found = state.response
    return RateSolution(
        state.trial, found.tractions, found.rates, state.shift, state.error, steps
    )


def _state(problem: RateProblem, trial: np.ndarray, shift: np.ndarray) -> _State:
    """Return a state with given unknowns: one FFT pair."""
    found, unit = _response(problem, trial), problem.self_compliance
    displaced = problem.displacement(found.tractions) - problem.imposed
    residual = (displaced - shift[:, None, None]) / unit + trial - found.tractions
    residual *= problem.pressure > 0.0
    missing = np.zeros(2)
    if problem.support is not None:
        missing = np.array(problem.support.force)
        missing -= problem.support.stiffness * shift
        missing -= found.tractions.sum(axis=(1, 2))
    return _State(trial, shift, found, residual, missing)


def _following(problem: RateProblem, state: _State) -> _State:
    """Return the state after a step of Newton's method."""
    system = _System(problem, state.response)
    change, moved = system.solve(state.residual, state.missing)
    by_change = problem.displacement(change) - moved[:, None, None]
    further = change - state.residual - by_change / problem.self_compliance
    further *= problem.pressure > 0.0
    return _state(problem, state.trial + further, state.shift + moved)


def _response(problem: RateProblem, trial: np.ndarray) -> _Response:
    """Return the tractions of given unknowns."""
    touching = problem.pressure > 0.0
    size = np.hypot(*trial)
    direction = np.divide(trial, size, out=np.zeros_like(trial), where=size > 0.0)
    history = {name: each[touching] for name, each in problem.history.items()}
    compliance = problem.duration / problem.self_compliance
    traction, rate, along = (np.zeros(size.shape) for _ in range(3))
    traction[touching], rate[touching], along[touching] = tractions_of(
        problem.law, problem.pressure[touching], history, size[touching], compliance
    )
    across = np.divide(traction, size, out=along.copy(), where=size > 0.0)
    return _Response(
        traction * direction, rate * direction, direction, along, touching * across
    )


class _System:
    """Linear equations of a step of Newton's method, for scaled tractions y.

    Vectors are arrays of shape (2, n m + 1), with the shift after the tractions.
    """

    def __init__(self, problem: RateProblem, found: _Response) -> None:
        self._halfspace, self._shape = problem.halfspace, problem.pressure.shape
        self._unit = problem.self_compliance
        self._driven, self._spring = problem.support is not None, 0.0
        if problem.support is not None:
            self._spring = self._unit * problem.support.stiffness
        self._direction = found.direction.astype(np.float32)
        self._along, self._across = (
            np.sqrt(_DIAGONAL * slope / (1.0 + (_DIAGONAL - 1.0) * slope)).astype(
                np.float32
            )
            for slope in (found.along, found.across)
        )
        self._size = max(np.count_nonzero(problem.pressure > 0.0), 1)
        if self._driven:
            axes = np.eye(2, dtype=np.float32)[:, :, None, None]
            shifts = [self._scaled(axis) for axis in axes]
            self._by_shift = np.stack([self._inverse(shift) for shift in shifts])
            stiffness = np.array(
                [
                    [float((shift * change).sum()) for change in self._by_shift]
                    for shift in shifts
                ]
            )
            stiffness = 0.5 * (stiffness + stiffness.T) + self._spring * np.eye(2)
            self._compliance = np.linalg.pinv(stiffness, _MIN_RELATIVE_STIFFNESS)

    def solve(
        self, residual: np.ndarray, missing: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the changes of the tractions and of the indenter's displacement."""
        right = np.zeros((2, residual[0].size + 1), np.float32)
        self._field(right)[:] = -self._scaled(residual)
        right[:, -1] = missing / self._size
        limit = _FORCING * norm(right)
        found = gcr(self._apply, self._precondition, right, limit, _MAX_ITERATIONS)
        found = np.broadcast_to(found, right.shape).astype(float)
        moved = self._driven * self._unit * found[:, -1]
        return self._scaled(self._field(found)), moved

    def _field(self, vector: np.ndarray) -> np.ndarray:
        """Return a view of the tractions, shape (2, n, m)."""
        return vector[:, :-1].reshape(2, *self._shape)

    def _scaled(self, values: np.ndarray, power: int = 1) -> np.ndarray:
        """Return values times a power of s."""
        along, across = self._along**power, self._across**power
        part = (self._direction * values).sum(axis=0)
        return across * values + (along - across) * part * self._direction

    def _apply(self, vector: np.ndarray) -> np.ndarray:
        """Return the left-hand side."""
        values, shift = self._field(vector), vector[:, -1]
        tractions = self._scaled(values)
        displaced = self._halfspace.relative_displacement(tractions)
        result = np.zeros_like(vector)
        if self._driven:
            displaced -= shift[:, None, None]
            sums = tractions.sum(axis=(1, 2), dtype=float)
            result[:, -1] = (sums + self._spring * shift) / self._size
        rest = _DIAGONAL * (values - self._scaled(values, 2))
        self._field(result)[:] = self._scaled(displaced) + rest
        return result

    def _precondition(self, residual: np.ndarray) -> np.ndarray:
        """Return an approximate solution."""
        result = np.zeros_like(residual)
        values = self._inverse(self._field(residual))
        if self._driven:
            sums = self._scaled(values).sum(axis=(1, 2), dtype=float)
            result[:, -1] = self._compliance @ (self._size * residual[:, -1] - sums)
            values = values + np.tensordot(result[:, -1], self._by_shift, 1)
        self._field(result)[:] = values
        return result

    def _inverse(self, values: np.ndarray) -> np.ndarray:
        """Return approximate scaled tractions that cause scaled displacements."""
        smooth = self._halfspace.relative_stiffness(self._scaled(values))
        return self._scaled(smooth) + (values - self._scaled(values, 4)) / _DIAGONAL
