"""Problem of a contact with friction, and states of its tractions.

Lengths are in units of the self-compliance times that of pressure.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ase_roughcontact.elasticity.lateral import LateralHalfSpace

# Relative distance to the bound within which a traction is at it.
_AT_BOUND = 1e-12
# Rounding of the function that is minimised, relative to the sum of its terms.
_ROUNDING = 1e-12
# Rounding of a sum of tractions, and largest number of sums for a shift.
_SUM_ROUNDING, _MOST_SUMS = 1e-13, 100
# Part of a shift that is tried next if it was too long, at least.
_SHORTEST = 0.01
# Smallest slope of the sums, relative to the mean one.
_FLATTEST = 1e-14


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
        Of a magnitude below the sum of the bounds, unless there is a spring (pressure).
    spring : float
        Its stiffness k.
    shift : ndarray, shape (2,)
        Start (pressure).
    """
    move, missing = np.zeros(2), np.zeros(2)
    for _ in range(_MOST_SUMS):
        moved = values + (shift + move)[:, None]
        size = np.hypot(*moved)
        part = _part(size, bound)
        rest = total - moved @ part - spring * (shift + move)
        before, after = float(missing @ move), float(rest @ move)
        if after < -0.5 * before:
            move = max(before / (before - after), _SHORTEST) * move
            continue
        shift, missing = shift + move, rest
        if np.hypot(*missing) <= _SUM_ROUNDING * (np.hypot(*total) + part @ size):
            break
        normal = np.divide(moved, size, out=np.zeros_like(moved), where=part < 1.0)
        slope = (part.sum() + spring) * np.eye(2)
        least = _FLATTEST * slope
        move = np.linalg.solve(slope - (part * normal) @ normal.T + least, missing)
    return shift


@dataclass(frozen=True, eq=False)
class FrictionProblem:
    """Contact with friction at a given displacement, or under a lateral force.

    Attributes
    ----------
    halfspace : LateralHalfSpace
    bound : ndarray, shape (n, m)
        Largest magnitude of the traction, zero for atoms out of contact.
    imposed : ndarray, shape (2, n, m)
        Displacement of atoms that stick.
    force : ndarray, shape (2,), or None
        Sum of the tractions, less that of the spring; None if there is no shift.
    spring : float
        Its stiffness: by which that sum decreases with the shift.
    """

    halfspace: LateralHalfSpace
    bound: np.ndarray
    imposed: np.ndarray
    force: np.ndarray | None = None
    spring: float = 0.0

    def at(
        self, tractions: np.ndarray, shift: np.ndarray, steps: int = 0
    ) -> FrictionState:
        """Return the state of given tractions, after some steps: one FFT pair."""
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
        """Return tractions within the bounds, and with a sum if that is given.

        Those that are not at their bound make up for what the others lose; all of them,
        if they cannot.
        """
        tractions = bounded(tractions, self.bound)
        if total is None:
            return tractions
        atoms = np.hypot(*tractions) < (1.0 - _AT_BOUND) * self.bound
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
    """Tractions, and the opening g and the shift that follow from them.

    Attributes
    ----------
    problem : FrictionProblem
    tractions, opening : ndarray, shape (2, n, m)
    shift : ndarray, shape (2,)
        With which a step along the opening would conserve the force.
    steps : int
        Steps of Newton's method so far.
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
        """See `friction.FrictionSolution`; at least the error of the force."""
        trial = bounded(self.tractions + self.opening, self.problem.bound)
        largest = float(np.hypot(*trial).max())
        left = float(np.hypot(*(trial - self.tractions)).max())
        return max(left / largest if largest else 0.0, self.error)

    @property
    def missing(self) -> np.ndarray:
        """What the sums of the tractions lack."""
        problem = self.problem
        if problem.force is None:
            return np.zeros(2)
        sums = self.tractions.sum(axis=(1, 2))
        return problem.force - problem.spring * self.shift - sums

    @cached_property
    def error(self) -> float:
        """What the sums lack, relative to all tractions, or to a larger force."""
        if self.problem.force is None:
            return 0.0
        sizes = np.hypot(*self.tractions).sum(), np.hypot(*self.problem.force)
        size = float(max(sizes))
        return float(np.hypot(*self.missing)) / size if size else 0.0

    @cached_property
    def direction(self) -> np.ndarray:
        """Unit vectors of the tractions; zero without."""
        size = np.hypot(*self.tractions)
        return np.divide(
            self.tractions, size, out=np.zeros_like(self.tractions), where=size > 0.0
        )

    @cached_property
    def slipping(self) -> np.ndarray:
        """Mask of the atoms at the bound that are driven forward."""
        bound = self.problem.bound
        at_bound = np.hypot(*self.tractions) >= (1.0 - _AT_BOUND) * bound
        driven = (self.opening * self.direction).sum(axis=0) > 0.0
        return (bound > 0.0) & at_bound & driven

    def rises(self, other: FrictionState) -> bool:
        """Return whether the energy of another state is higher, beyond rounding."""
        opening, spring = self.opening + other.opening, self.problem.spring
        if spring:  # its displacement follows from the sum of the tractions
            shifts = (state.missing / spring for state in (self, other))
            opening = opening + np.sum(list(shifts), axis=0)[:, None, None]
        gain = ((other.tractions - self.tractions) * opening).sum()
        rounding = _ROUNDING * float(abs(self.tractions * self.displacement).sum())
        return bool(gain < -rounding)
