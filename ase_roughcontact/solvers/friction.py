r"""Lateral tractions of a contact with friction, at a given pressure.

Tractions t on the atoms in contact displace the surface by :math:`G * t`, and follow
the indenter as long as their magnitude is below a bound r that the pressure sets. For
an increment of the indenter's displacement D the sum :math:`c = D - D' + G * t'` with
the last displacement and tractions is what atoms that stick must be displaced by. The
tractions minimise a convex function,

.. math:: \min_t\ \tfrac{1}{2} t \cdot G * t - c \cdot t, \qquad |t_i| \le r_i,

so that with the opening :math:`g = c - G * t` each atom sticks, :math:`g = 0`, or
slips, :math:`g = \lambda t` with :math:`|t| = r` and :math:`\lambda \ge 0`.

Newton's method on the set of atoms that slip: those that stick have two unknowns, and
those that slip one, along their circle, whose curvature adds :math:`\lambda` to the
diagonal. Each system is solved iteratively, preconditioned by

.. math:: w\, G^{-1} w + \frac{1 - w^2}{\lambda + s}, \qquad
          w = \frac{s}{s + \lambda}, \qquad s = 4 G_0 ,

the inverse spectrum for the atoms that stick, and the diagonal where the curvature
exceeds a few times the self-compliance :math:`G_0`. Atoms whose traction exceeds the
bound begin to slip, and those that are driven backwards stick again. A step that does
not lower the function is shortened, and replaced by one along the gradient at last.

Under a lateral force, or with a spring between the indenter and what moves it, the
displacement is unknown, too: Newton's method with the tangent stiffness of the contact
finds that at which the forces balance.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ase_roughcontact._util.kernels import dot, norm
from ase_roughcontact._util.validation import check_options
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.solvers.gcr import gcr

# Relative distance to the bound within which a traction is at it.
_AT_BOUND = 1e-12
# Rounding of the function that is minimised, relative to the sum of its terms.
_ROUNDING = 1e-13
# Factor by which a step is shortened, and how often before the gradient replaces it.
_SHORTER, _MOST_SHORTENED = 0.25, 3
# Largest number of moves of the indenter, and residual of the tractions before each,
# relative to the error of their sums.
_MOST_MOVES, _INNER = 40, 0.3
# Curvature, relative to the self-compliance, above which preconditioning is diagonal.
_CURVED = 4.0
# Relative error of the tangent stiffness: near sliding it is nearly singular.
_TANGENT = 0.03


@dataclass(frozen=True)
class Drive:
    """What moves the indenter sideways, if its displacement is not given.

    Attributes
    ----------
    force : (float, float)
        Sums of the tractions along x and y, at a shift of zero (pressure).
    stiffness : float
        By which these sums decrease with the shift (pressure/length); 0 for a force.
    """

    force: tuple[float, float]
    stiffness: float = 0.0

    def slides(self, bound: np.ndarray, tolerance: float) -> bool:
        """Return whether a force without spring exceeds the sum of the bounds."""
        largest = (1.0 + tolerance) * bound.sum()
        return not self.stiffness and bool(np.hypot(*self.force) > largest)

    def missing(self, state: _State) -> np.ndarray:
        """Return what the sums of the tractions lack."""
        force = np.array(self.force) - self.stiffness * state.shift
        return force - state.tractions.sum(axis=(1, 2))

    def error(self, state: _State) -> float:
        """Return it relative to all tractions, or to the force if it is larger."""
        size = max(
            float(np.hypot(*state.tractions).sum()), float(np.hypot(*self.force))
        )
        return float(np.hypot(*self.missing(state))) / size if size else 0.0


@dataclass(frozen=True)
class FrictionOptions:
    """Options of `solve_friction`.

    Attributes
    ----------
    tolerance : float
        Largest residual of the optimality conditions; see `FrictionSolution`.
    max_steps : int
        Largest number of steps of Newton's method.
    max_iterations : int
        Largest number of iterations for the linear system of each of them.
    forcing : float
        Residual of the linear system that its solution may leave, relative to that of
        the tractions.
    """

    tolerance: float = 1e-7
    max_steps: int = 100
    max_iterations: int = 40
    forcing: float = 0.1

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_options(self)


@dataclass(frozen=True, eq=False)
class FrictionSolution:
    """Tractions of a contact with friction, and what is left of the conditions.

    Attributes
    ----------
    tractions : ndarray, shape (2, n, m)
        On the surface, along x and y (pressure).
    slipping : ndarray of bool, shape (n, m)
        Atoms whose traction is at its bound, and which slip along it.
    displacement : ndarray, shape (2, n, m)
        Of the surface, by the tractions (length).
    shift : ndarray, shape (2,)
        Displacement of the indenter beside what was imposed, by a spring or a given
        force (length).
    residual : float
        Largest :math:`|t - P(t + g/G_0)|` with the projection P onto the bounds,
        relative to the largest traction; at least the relative error of a given force.
    message : str
        Why the residual is above the tolerance; empty if it is not.
    steps : int
        Steps of Newton's method.
    pairs : float
        FFT pairs of two components, normalised to one on the grid.
    """

    tractions: np.ndarray
    slipping: np.ndarray
    displacement: np.ndarray
    shift: np.ndarray
    residual: float
    message: str = ""
    steps: int = 0
    pairs: float = 0.0

    @property
    def converged(self) -> bool:
        """Whether the residual is within the tolerance."""
        return not self.message


def bounded(tractions: np.ndarray, bound: np.ndarray) -> np.ndarray:
    """Return tractions with magnitudes of at most a bound, in the same directions."""
    size = np.hypot(*tractions)
    return tractions * np.divide(
        bound, size, out=np.ones_like(size), where=size > bound
    )


def solve_friction(
    halfspace: LateralHalfSpace,
    bound: np.ndarray,
    imposed: np.ndarray,
    start: np.ndarray | None = None,
    *,
    drive: Drive | None = None,
    options: FrictionOptions | None = None,
) -> FrictionSolution:
    """Return the tractions of a contact with friction.

    Parameters
    ----------
    halfspace : LateralHalfSpace
    bound : ndarray, shape (n, m)
        Largest magnitude of the traction, zero for atoms out of contact (pressure).
    imposed : ndarray, shape (2, n, m)
        Displacement of atoms that stick (length).
    start : ndarray, shape (2, n, m), optional
        Tractions from which the iteration starts.
    drive : Drive, optional
        What moves the indenter further; by default nothing.
    options : FrictionOptions, optional

    Returns
    -------
    FrictionSolution
        Also if it has not converged, which its message says: the contact slides if
        friction can't carry a given force.
    """
    options, before = options or FrictionOptions(), halfspace.pairs
    problem = _Problem(halfspace, bound, imposed, options)
    tractions = np.zeros(imposed.shape) if start is None else bounded(start, bound)
    rest, error, message = np.zeros(2), 0.0, ""
    slides = drive is not None and drive.slides(bound, options.tolerance)
    if drive is None:
        state = problem.at(tractions, rest).relaxed(options.tolerance)
    elif slides:
        along = np.array(drive.force) / np.hypot(*drive.force)
        state = problem.at(along[:, None, None] * bound, rest)
        error = drive.error(state)
    else:
        state, error = _driven(problem.at(tractions, rest), drive)
    residual = max(state.residual, error)
    if residual > options.tolerance:
        message = (
            f"friction has not converged after {state.steps} steps: a residual of "
            f"{residual:.2g} remains"
        )
        if drive and not bound.any():
            message = "no atom in contact can carry the lateral force"
        elif slides:
            message = (
                f"the contact slides: friction does not carry {100.0 * error:.3g} % of "
                "the lateral load"
            )
    return FrictionSolution(
        state.tractions,
        bound > 0.0 if slides else state.slipping,
        state.displacement,
        state.shift,
        residual,
        message,
        state.steps,
        halfspace.pairs - before,
    )


def _driven(state: _State, drive: Drive) -> tuple[_State, float]:
    """Return the state at the shift at which the forces balance, and the error left."""
    problem, least, last = state.problem, np.inf, state.shift
    tolerance = problem.options.tolerance
    for _ in range(_MOST_MOVES):
        error = drive.error(state)
        while state.residual > (limit := max(tolerance, _INNER * error)):
            state = state.relaxed(limit)
            error = drive.error(state)
            if state.residual > limit:  # not converged
                return state, error
        if error <= tolerance:
            break
        missing = drive.missing(state)
        tractions, imbalance = state.tractions, float(np.hypot(*missing))
        if imbalance > least:  # as after a move into sliding
            shift = 0.5 * (state.shift + last)
        else:
            changes, stiffness = state.tangent()
            move = np.linalg.pinv(stiffness + drive.stiffness * np.eye(2)) @ missing
            if not drive.stiffness and not tractions.any():
                move = _softening(missing, problem.bound) * move
            least, last, shift = imbalance, state.shift, state.shift + move
            tractions = bounded(
                tractions + np.tensordot(move, changes, 1), problem.bound
            )
        state = problem.at(tractions, shift, state.steps)
    return state, error


def _softening(force: np.ndarray, bound: np.ndarray) -> float:
    """Return the displacement of a sphere under a force over that without slip.

    It is that of Cattaneo and Mindlin, a guess for any contact.
    """
    part = min(float(np.hypot(*force) / bound.sum()), 1.0) if bound.any() else 0.0
    return 1.5 * (1.0 - (1.0 - part) ** (2.0 / 3.0)) / part if part else 1.0


@dataclass(frozen=True, eq=False)
class _Problem:
    """Data of `solve_friction`."""

    halfspace: LateralHalfSpace
    bound: np.ndarray
    imposed: np.ndarray
    options: FrictionOptions

    @cached_property
    def unit(self) -> float:
        """Self-compliance G0."""
        return self.halfspace.self_compliance

    def at(self, tractions: np.ndarray, shift: np.ndarray, steps: int = 0) -> _State:
        """Return the state of given tractions, after some steps: one FFT pair."""
        displacement = self.halfspace.displacement(tractions)
        imposed = self.imposed + shift[:, None, None]
        return _State(self, tractions, displacement, imposed, shift, steps)


@dataclass(frozen=True, eq=False)
class _State:
    """Tractions, and the displacement and the opening g that follow from them."""

    problem: _Problem
    tractions: np.ndarray
    displacement: np.ndarray
    imposed: np.ndarray
    shift: np.ndarray
    steps: int

    @cached_property
    def opening(self) -> np.ndarray:
        """Difference g of imposed and actual displacement."""
        return self.imposed - self.displacement

    @cached_property
    def energy(self) -> float:
        """Value of the function that is minimised."""
        return -0.5 * dot(self.tractions, self.opening + self.imposed)

    @cached_property
    def residual(self) -> float:
        """See `FrictionSolution`."""
        trial = self.tractions + self.opening / self.problem.unit
        trial = bounded(trial, self.problem.bound)
        largest = float(np.hypot(*trial).max())
        left = float(np.hypot(*(trial - self.tractions)).max())
        return left / largest if largest else 0.0

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

    def relaxed(self, tolerance: float) -> _State:
        """Return the state after steps of Newton's method to a residual."""
        state, last = self, self.steps + self.problem.options.max_steps
        while state.residual > tolerance and state.steps < last:
            state = state.lower(
                state._system.solve(state.opening, self.problem.options.forcing)
            )
        return state

    def tangent(self) -> tuple[np.ndarray, np.ndarray]:
        """Return changes of the tractions per shift along x and y, and their sums."""
        axes = np.eye(2)[:, :, None, None] * np.ones(self.problem.bound.shape)
        changes = np.stack([self._system.solve(axis, _TANGENT) for axis in axes])
        return changes, changes.sum(axis=(2, 3)).T

    @cached_property
    def _system(self) -> _System:
        return _System(self)

    def lower(self, step: np.ndarray) -> _State:
        """Return a state of a lower energy, after a step that is shortened for it."""
        rounding = _ROUNDING * float(abs(self.tractions * self.imposed).sum())
        for _ in range(_MOST_SHORTENED + 1):
            state = self._moved(step)
            if state.energy <= self.energy + rounding:
                return state
            step = _SHORTER * step
        return self._moved(self.opening / self.problem.halfspace.largest_compliance)

    def _moved(self, step: np.ndarray) -> _State:
        tractions = bounded(self.tractions + step, self.problem.bound)
        return self.problem.at(tractions, self.shift, self.steps + 1)


class _System:
    """Linear equations of a step of Newton's method.

    Parameters
    ----------
    state : _State
    """

    def __init__(self, state: _State) -> None:
        problem, touching = state.problem, state.problem.bound > 0.0
        self._halfspace, self._options = problem.halfspace, problem.options
        self._normal = state.direction * state.slipping
        self._touching = touching.astype(float)
        curvature = np.hypot(*state.opening) * state.slipping
        self._curvature = np.divide(
            curvature, problem.bound, out=curvature, where=touching
        )
        softness = _CURVED * problem.unit
        self._weight = self._touching * softness / (softness + self._curvature)
        rest = self._touching - self._weight**2
        self._diagonal = rest / (softness + self._curvature)

    def solve(self, opening: np.ndarray, error: float) -> np.ndarray:
        """Return the change of the tractions that closes an opening, to an error."""
        right = self._project(opening)
        limit = error * norm(right)
        change = gcr(
            self._apply, self._precondition, right, limit, self._options.max_iterations
        )
        return np.broadcast_to(change, opening.shape)

    def _project(self, values: np.ndarray) -> np.ndarray:
        """Return the components along which tractions may change."""
        n = self._normal
        return self._touching * values - n * (n * values).sum(axis=0)

    def _apply(self, change: np.ndarray) -> np.ndarray:
        values = self._halfspace.displacement(change)
        return self._project(values) + self._curvature * change

    def _precondition(self, residual: np.ndarray) -> np.ndarray:
        smooth = self._halfspace.stiffness(self._weight * residual)
        return self._project(self._weight * smooth + self._diagonal * residual)
