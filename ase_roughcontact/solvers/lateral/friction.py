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
diagonal; see `friction_problem`. Atoms whose traction exceeds the bound begin to slip,
and those that are driven backwards stick again. A step that does not lower the function
is shortened, and replaced by one along the gradient at last.

Under a lateral force, or with a spring between the indenter and what moves it, the
displacement is unknown, too. All steps conserve the force: it is minimised over the
tractions with a given sum, and the displacement is the Lagrange multiplier of this sum.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ase_roughcontact._util.validation import check_options
from ase_roughcontact.contact.support import LateralSupport
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.solvers.lateral.friction_problem import (
    FrictionProblem,
    FrictionState,
    FrictionSystem,
)
from ase_roughcontact.solvers.status import CONVERGED, Status, StatusKind

# Factor by which a step is shortened, and how often before the gradient replaces it.
_SHORTER, _MOST_SHORTENED = 0.25, 3
# Relative distance of a force to the largest friction from which the contact slides:
# all atoms slip, and displacements grow without limit as their tractions turn parallel.
_AT_LARGEST = 5e-7
# Smallest residual, in units of the rounding of a transform: ten times what single
# precision leaves.
_LEAST_RESIDUAL = 100.0

#: Kinds of a status that is not converged.
NOT_CONVERGED = StatusKind(
    "friction has not converged after {steps} steps: a residual of {residual:.2g} "
    "remains"
)
SLIDING = StatusKind(
    "the contact slides: friction does not carry {percent:.3g} % of the lateral load"
)
LARGEST_FRICTION = StatusKind(
    "the contact slides: the lateral load is the largest friction, at which it has no "
    "definite displacement",
    "give displacements",
)
NO_FRICTION = StatusKind("no atom in contact can carry the lateral load")


@dataclass(frozen=True)
class FrictionOptions:
    """Options of `solve_friction`.

    Attributes
    ----------
    tolerance : float
        Largest residual of the optimality conditions, see `FrictionSolution`; at least
        1.2e-5 if the transforms are in single precision.
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
        Atoms that slip: the opening g is along the traction, and longer than the
        tolerance times the largest traction times the self-compliance :math:`G_0`.
    displacement : ndarray, shape (2, n, m)
        Of the surface, by the tractions (length).
    shift : ndarray, shape (2,)
        Displacement of the indenter beside what was imposed, by a spring or a given
        force (length).
    residual : float
        Largest :math:`|t - P(t + g/G_0)|` with the projection P onto the bounds,
        relative to the largest traction; at least the relative error of a given force.
    status : Status
        Whether the residual is within the tolerance, or why it is not.
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
    status: Status
    steps: int = 0
    pairs: float = 0.0

    @property
    def converged(self) -> bool:
        """Whether the residual is within the tolerance."""
        return self.status.converged

    @property
    def message(self) -> str:
        """Reason why the residual is above the tolerance; empty if it is not."""
        return self.status.message


def solve_friction(
    halfspace: LateralHalfSpace,
    bound: np.ndarray,
    imposed: np.ndarray,
    start: np.ndarray | None = None,
    *,
    support: LateralSupport | None = None,
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
    support : LateralSupport, optional
        What holds the indenter sideways; by default it does not move further.
    options : FrictionOptions, optional

    Returns
    -------
    FrictionSolution
        Also if it has not converged, which its status says: the contact slides if
        friction can't carry a given force.
    """
    options, before = options or FrictionOptions(), halfspace.transformed
    unit, slides = halfspace.self_compliance, False
    rounding = float(np.finfo(halfspace.transform.dtype).eps)
    tolerance = max(options.tolerance, _LEAST_RESIDUAL * rounding)
    problem = FrictionProblem(halfspace, bound, imposed / unit)
    tractions = np.zeros(imposed.shape) if start is None else start
    residual, status = 0.0, Status(CONVERGED)
    if support is not None:
        force, excess = np.array(support.force), support.excess(bound)
        slides, residual = excess > -_AT_LARGEST, max(excess, 0.0)
        if slides:
            tractions = (force / np.hypot(*force))[:, None, None] * bound
        else:
            problem = replace(problem, force=force, spring=unit * support.stiffness)
    state = problem.at(problem.feasible(tractions, problem.force), np.zeros(2))
    while not slides and state.residual > tolerance:
        if state.steps == options.max_steps:
            numbers = {"steps": state.steps, "residual": state.residual}
            status = Status(NOT_CONVERGED, numbers)
            break
        state = _lowered(state, options)
    if slides:
        status = Status(SLIDING, {"percent": 100.0 * residual})
        if residual <= _AT_LARGEST:
            status = Status(LARGEST_FRICTION)
        if not bound.any():
            status = Status(NO_FRICTION)
    return FrictionSolution(
        state.tractions,
        bound > 0.0 if slides else state.slipping(tolerance),
        unit * state.displacement,
        unit * state.shift,
        max(state.residual, residual),
        status,
        state.steps,
        (halfspace.transformed - before) / math.prod(halfspace.grid),
    )


def _lowered(state: FrictionState, options: FrictionOptions) -> FrictionState:
    """Return a state of a lower energy, after a step of Newton's method."""
    problem, system = state.problem, FrictionSystem(state)
    step = system.solve(options.forcing, options.max_iterations)
    for _ in range(_MOST_SHORTENED + 1):
        new = problem.moved(state, step)
        if not state.rises(new):
            return new
        step = _SHORTER * step
    halfspace = problem.halfspace
    largest = halfspace.largest_compliance / halfspace.self_compliance
    return problem.moved(state, state.opening / largest)
