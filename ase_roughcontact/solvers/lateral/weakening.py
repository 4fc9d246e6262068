r"""Lateral tractions of atoms with bounds that depend on their slip.

The bounds r(s) depend on the slip :math:`s = |g|` with the opening g, see `friction`.
Newton's method acts on the tractions and their bounds b together: the change x of the
traction of an atom that slips has a component along its direction n, too,

.. math:: n \cdot x - r' \, n \cdot (\sigma - G * x) = r(s) - b ,

with the slope r' of the bound, and the change :math:`\sigma` of the displacement of the
indenter. Steps lower the energy

.. math:: \Pi = \tfrac{1}{2} t \cdot G * t + \sum \int_0^{|g|} r \, ds ,

to which the support of the indenter adds its own, or at least the residual; if they do
not, the tractions are solved for at given bounds, and the bounds follow the slip. If a
step would raise the energy along the slip by which bounds fall, no equilibrium is near,
and slip grows without further load. Across such an instability, bounds fall along the
slip that grows, by small parts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ase_roughcontact.contact.support import LateralSupport
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.interactions.local_friction import LocalFriction
from ase_roughcontact.solvers.lateral.friction import (
    NOT_CONVERGED,
    FrictionOptions,
    FrictionSolution,
    carries,
    lowered,
    smallest_residual,
    solve_friction,
)
from ase_roughcontact.solvers.lateral.friction_problem import (
    FrictionProblem,
    FrictionState,
)
from ase_roughcontact.solvers.lateral.weakening_system import WeakeningSystem
from ase_roughcontact.solvers.status import CONVERGED, Status, StatusKind

# Change of the slip from which the slope of the bounds follows, in units of the slip
# that would relieve a single atom from its bound.
_SLOPE_STEP = 1e-4
# Residual of the linear system, in units of the usual one: a few atoms that stick
# determine the displacement under a force.
_FORCING = 0.1
# Smallest slope of bounds that depend on slip, in units of the self-compliance.
_MIN_SLOPE = 1e-6
# Smallest bound of an atom in contact, relative to its bound without slip.
_MIN_BOUND = 1e-9
# Decrease of the residual by a step that need not lower the energy.
_DECREASE = 0.5
# Rounding error of the energy, relative to the sum of its terms.
_ENERGY_ROUNDING = 1e-12
# Largest residual of the tractions at which bounds follow the slip, relative to the
# change of the bounds.
_BALANCED = 0.1

# Largest fall of a bound by slip that grows, relative to the largest bound.
_LARGEST_FALL = 0.1
# Largest number of steps to an equilibrium before an instability, and across it, in
# units of the usual number.
_STEPS_BEFORE = 0.4
_STEPS_BEYOND = 4.0

#: An instability is ahead.
GROWING = StatusKind("the slip grows without further load, as friction weakens by it")
#: Friction has weakened below the lateral load.
RUNAWAY = StatusKind(
    "the contact slides after an instability: friction weakens by slip below the "
    "lateral load, and there is no further equilibrium",
    "give displacements, or bases and a spring",
)


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """Tractions, and the slip at which these are within their bounds.

    Attributes
    ----------
    solution : FrictionSolution
    slipped : ndarray, shape (n, m)
        Way that each atom has slipped (length).
    """

    solution: FrictionSolution
    slipped: np.ndarray


def solve_weakening(
    halfspace: LateralHalfSpace,
    friction: LocalFriction,
    imposed: np.ndarray,
    start: np.ndarray,
    *,
    support: LateralSupport | None = None,
    options: FrictionOptions | None = None,
    beyond: bool = False,
) -> Equilibrium:
    """Return tractions in equilibrium with friction that depends on slip.

    Parameters
    ----------
    halfspace, imposed, start, support, options
        See `solve_friction`.
    friction : LocalFriction
        Friction with the histories before the slip.
    beyond : bool
        Whether to go on across instabilities.

    Returns
    -------
    Equilibrium
        With a status if it has not converged: the contact slides if friction can't
        carry a given force, or weakens until it can't.
    """
    options, before = options or FrictionOptions(), halfspace.transformed
    unit, tolerance = halfspace.self_compliance, smallest_residual(halfspace, options)
    peak = friction.bounds()
    if not carries(support, peak):
        solution = solve_friction(
            halfspace, peak, imposed, start, support=support, options=options
        )
        return Equilibrium(solution, np.zeros(peak.shape))
    problem = FrictionProblem(halfspace, peak, imposed / unit)
    if support is not None:
        force = np.array(support.force)
        problem = replace(problem, force=force, spring=unit * support.stiffness)
    tractions = problem.feasible(_raised(start, peak, tolerance), problem.force)
    weakening = _Weakening(friction, peak, unit, support)
    state = problem.at(tractions, np.zeros(2))
    iterate = weakening.iterate(state, np.zeros(peak.shape))
    most = options.max_steps * (_STEPS_BEYOND if beyond else _STEPS_BEFORE)
    status = Status(CONVERGED)
    while iterate.residual > tolerance:
        state = iterate.state
        if state.steps >= most:
            numbers = {"steps": state.steps, "residual": iterate.residual}
            status = Status(NOT_CONVERGED, numbers)
            break
        following = iterate.following(options, beyond)
        if isinstance(following, Status):
            status = following
            break
        iterate = following
    state = iterate.state
    solution = FrictionSolution(
        state.tractions,
        state.slipping(tolerance),
        unit * state.displacement,
        unit * state.shift,
        iterate.residual,
        status,
        state.steps,
        (halfspace.transformed - before) / math.prod(halfspace.grid),
    )
    return Equilibrium(solution, unit * iterate.slip)


def _raised(tractions: np.ndarray, bound: np.ndarray, tolerance: float) -> np.ndarray:
    """Return tractions at their bounds where they are nearly, within a tolerance.

    Otherwise an atom that slips further could solve the problem without weakening.
    """
    size = np.hypot(*tractions)
    near = (size > 0.0) & (bound - size < tolerance * bound.max(initial=0.0))
    return tractions * np.divide(bound, size, out=np.ones_like(size), where=near)


@dataclass(frozen=True, eq=False)
class _Weakening:
    """Bounds as functions of the slip, in units of `FrictionProblem`.

    Attributes
    ----------
    friction : LocalFriction
    peak : ndarray, shape (n, m)
        Bounds without slip.
    unit : float
        Unit of slip.
    support : LateralSupport or None
        Support of the indenter.
    """

    friction: LocalFriction
    peak: np.ndarray
    unit: float
    support: LateralSupport | None

    def bound(self, slip: np.ndarray) -> np.ndarray:
        """Return the bounds after a slip; positive for atoms with a peak."""
        bounds = self.friction.bounds(self.unit * slip)
        return np.maximum(bounds, _MIN_BOUND * self.peak)

    def slope(self, slip: np.ndarray) -> np.ndarray:
        """Return the derivatives of the bounds by the slip."""
        change = np.where(self.peak > 0.0, _SLOPE_STEP * self.peak, 1.0)
        return (self.bound(slip + change) - self.bound(slip)) / change

    def work(self, slip: np.ndarray) -> float:
        """Return the work of friction over a slip."""
        return float((self.friction.mean_bounds(self.unit * slip) * slip).sum())

    def iterate(self, state: FrictionState, reached: np.ndarray) -> _Iterate:
        """Return the iterate of a state, with bounds of a slip that was reached."""
        held, problem = state.held_at_bound, state.problem
        bound = np.where(held, problem.bound, self.peak)
        state = replace(state, problem=replace(problem, bound=bound))
        opening = np.hypot(*state.opening)
        slip = np.where(held, opening, 0.0)
        lost = self.work(np.where(self.peak > 0.0, opening, 0.0))
        elastic = 0.5 * float((state.tractions * state.displacement).sum())
        energy, shift = elastic + lost, state.shift
        if problem.force is not None:
            energy += 0.5 * problem.spring * float(shift @ shift)
            energy -= float(problem.force @ shift)
        return _Iterate(
            weakening=self,
            state=state,
            reached=np.where(held, reached, 0.0),
            slip=slip,
            excess=np.where(held, self.bound(slip) - bound, 0.0),
            energy=energy,
            rounding=_ENERGY_ROUNDING * (abs(elastic) + lost),
        )


@dataclass(frozen=True, eq=False)
class _Step:
    """Step of Newton's method.

    Attributes
    ----------
    tractions : ndarray, shape (2, n, m)
        Change of the tractions.
    slip : ndarray, shape (n, m)
        Change of the slip at which bounds are taken.
    raises : bool
        Whether the energy at fixed loads rises along the slip.
    """

    tractions: np.ndarray
    slip: np.ndarray
    raises: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class _Iterate:
    """State of the tractions, and the slip of the atoms at their bounds.

    Attributes
    ----------
    weakening : _Weakening
    state : FrictionState
    reached, slip : ndarray, shape (n, m)
        Slip that the bounds of the state belong to, and slip of the state, of the atoms
        at their bounds; zero for others.
    excess : ndarray, shape (n, m)
        Bounds after this slip, less the bounds of the state.
    energy, rounding : float
        Energy, and its rounding error.
    smallest : float
        Smallest residual of the earlier iterates.
    growth : float
        Part of the last growth of the slip by which it grows further in the next step
        across an instability; zero elsewhere.
    extrapolated : bool
        Whether the last growth was extrapolated; the next one is not, as components
        that alternate would grow, too.
    last_change : float
        Change of the bounds before the last growth.
    """

    weakening: _Weakening
    state: FrictionState
    reached: np.ndarray
    slip: np.ndarray
    excess: np.ndarray
    energy: float
    rounding: float
    smallest: float = math.inf
    growth: float = 0.0
    extrapolated: bool = False
    last_change: float = 0.0

    @property
    def change(self) -> float:
        """Largest change of the bounds by the slip, relative to the largest bound."""
        largest = float(self.state.problem.bound.max(initial=0.0))
        return float(abs(self.excess).max()) / largest if largest else 0.0

    @property
    def residual(self) -> float:
        """Residual of tractions and bounds."""
        return max(self.state.residual, self.change)

    @property
    def balanced(self) -> bool:
        """Whether the tractions solve the problem at the bounds of the state."""
        return self.state.residual <= _BALANCED * self.change

    def following(self, options: FrictionOptions, beyond: bool) -> _Iterate | Status:
        """Return the next iterate, or the reason for the end; see `solve_weakening`."""
        if self.growth:
            if not self.balanced:
                return self._relaxed(options)
            if self.change > _DECREASE * self.last_change:
                return self._grown()
        step = self._step(options)
        if self.balanced and step.raises:
            return self._grown() if beyond else Status(GROWING)
        new = self._moved(step.tractions, step.slip)
        if new is not None and (
            new.energy <= self.energy + self.rounding
            or new.residual < _DECREASE * min(self.smallest, self.residual)
        ):
            return new
        if not self.balanced:
            return self._relaxed(options)
        return self._grown() if beyond else self._moved() or Status(RUNAWAY)

    def _step(self, options: FrictionOptions) -> _Step:
        """Return the step of Newton's method for tractions and bounds."""
        state = self.state
        slope = np.where(state.held_at_bound, self.weakening.slope(self.slip), 0.0)
        system = WeakeningSystem(state, slope, self.excess)
        tractions = system.solve(_FORCING * options.forcing, options.max_iterations)
        along = (state.direction * tractions).sum(axis=0) - self.excess
        slip = np.zeros(along.shape)
        np.divide(along, slope, out=slip, where=abs(slope) > _MIN_SLOPE)
        return _Step(tractions, slip, float((slip * self.excess).sum()) > 0.0)

    def _relaxed(self, options: FrictionOptions) -> _Iterate:
        """Return the iterate after a step for the tractions at given bounds."""
        new = self.weakening.iterate(lowered(self.state, options), self.reached)
        return replace(
            new,
            smallest=min(self.smallest, self.residual),
            growth=self.growth,
            extrapolated=self.extrapolated,
            last_change=self.last_change,
        )

    def _grown(self) -> _Iterate | Status:
        """Return the iterate after slip has grown, with the bounds of more growth."""
        growth = np.maximum(self.slip - self.reached, 0.0)
        part = 0.0 if self.extrapolated else self.growth
        bound, peak = self.weakening.bound, self.weakening.peak
        now, limit = bound(self.slip), _LARGEST_FALL * peak.max()
        while part > 0.5 and (now - bound(self.slip + part * growth)).max() > limit:
            part *= 0.5
        new = self._moved(slip=part * growth)
        if new is None:
            return Status(RUNAWAY)
        return replace(
            new,
            growth=self.growth if self.extrapolated else 2.0 * part + 1.0,
            extrapolated=part > 0.0,
            last_change=self.change,
        )

    def _moved(
        self, change: np.ndarray | float = 0.0, slip: np.ndarray | float = 0.0
    ) -> _Iterate | None:
        """Return the iterate after a change of the tractions, with bounds of more slip.

        None if these bounds do not carry a given force.
        """
        state, weakening = self.state, self.weakening
        held, problem = state.held_at_bound, state.problem
        reached = np.maximum(self.slip + slip, 0.0)
        bound = np.where(held, weakening.bound(reached), weakening.peak)
        if not carries(weakening.support, bound):
            return None
        tractions = state.tractions + change
        size, part = np.hypot(*tractions), np.ones(bound.shape)
        np.divide(bound, size, out=part, where=held & (size > 0.0))
        total = tractions.sum(axis=(1, 2)) if problem.spring else problem.force
        problem = replace(problem, bound=bound)
        tractions = problem.feasible(part * tractions, total)
        moved = problem.at(tractions, state.shift, state.steps + 1)
        smallest = min(self.smallest, self.residual)
        return replace(weakening.iterate(moved, reached), smallest=smallest)
