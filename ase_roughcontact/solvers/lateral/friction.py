r"""Lateral tractions of a contact with friction, at a given pressure.

Tractions t on the atoms in contact displace the surface by :math:`G * t`, and follow
the indenter as long as their magnitude is below a bound r, which depends on the
pressure. Atoms that stick are displaced by :math:`c = D - D' + G * t'`, with the
displacement D of the indenter, and the displacement D' and the tractions t' of the last
step. The tractions minimise a convex function,

.. math:: \min_t\ \tfrac{1}{2} t \cdot G * t - c \cdot t, \qquad |t_i| \le r_i,

so that with the opening :math:`g = c - G * t` each atom sticks, :math:`g = 0`, or
slips, :math:`g = \lambda t` with :math:`|t| = r` and :math:`\lambda \ge 0`.

Newton's method acts on the set of atoms that slip. Atoms that stick have two unknowns.
Atoms that slip have one unknown, along the circle of their bound; the curvature of the
circle adds :math:`\lambda` to the diagonal, see `friction_problem`. Atoms begin to slip
if their traction exceeds the bound, and stick again if they are driven backwards. A
step that does not lower the function is shortened, and finally replaced by a step along
the gradient.

Under a lateral force, or with a lateral spring on the indenter, the displacement is
unknown, too. All steps conserve the force: the function is minimised over tractions
with a given sum, and the displacement is the Lagrange multiplier of this sum.
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
from ase_roughcontact.solvers.status import CONVERGED, Status, StatusKind, WithStatus

# Factor by which a step is shortened.
_STEP_FACTOR = 0.25
# Largest number of shorter steps before a step along the gradient.
_MAX_SHORTER_STEPS = 3
# Relative distance of a force to the largest friction, below which the contact slides:
# all atoms slip, and displacements grow without limit as tractions turn parallel.
_SLIDING_DISTANCE = 5e-7
# Smallest tolerance of the residual, in units of the rounding error of a transform. It
# is ten times the residual in single precision.
_MIN_RESIDUAL = 100.0

#: The largest number of steps was reached.
NOT_CONVERGED = StatusKind(
    "friction has not converged after {steps} steps: a residual of {residual:.2g} "
    "remains"
)
#: The lateral load is above the largest friction.
SLIDING = StatusKind(
    "the contact slides: friction does not carry {percent:.3g} % of the lateral load"
)
#: The lateral load is equal to the largest friction.
LARGEST_FRICTION = StatusKind(
    "the contact slides: the lateral load is the largest friction, at which it has no "
    "definite displacement",
    "give displacements",
)
#: All bounds are zero.
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
        Largest number of iterations for the linear system of a step.
    forcing : float
        Largest residual of the solution of the linear system, relative to the residual
        of the tractions.
    """

    tolerance: float = 1e-7
    max_steps: int = 100
    max_iterations: int = 40
    forcing: float = 0.1

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_options(self)


@dataclass(frozen=True, eq=False)
class FrictionSolution(WithStatus):
    """Tractions of a contact with friction, and the residual of the conditions.

    Attributes
    ----------
    tractions : ndarray, shape (2, n, m)
        Tractions on the surface along x and y (pressure).
    slipping : ndarray of bool, shape (n, m)
        Whether each atom slips: the opening g is along the traction, and longer than
        the tolerance times the largest traction times the self-compliance :math:`G_0`.
    displacement : ndarray, shape (2, n, m)
        Displacement of the surface by the tractions (length).
    shift : ndarray, shape (2,)
        Displacement of the indenter by a spring or a given force, in addition to the
        imposed displacement (length).
    residual : float
        Largest :math:`|t - P(t + g/G_0)|` with the projection P onto the bounds,
        relative to the largest traction; at least the relative error of a given force.
    status : Status
        Convergence of the residual to the tolerance, or why it has not converged.
    steps : int
        Number of steps of Newton's method.
    pairs : float
        Number of FFT pairs of two components, normalised to pairs on the grid.
    """

    tractions: np.ndarray
    slipping: np.ndarray
    displacement: np.ndarray
    shift: np.ndarray
    residual: float
    status: Status
    steps: int = 0
    pairs: float = 0.0


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
        Lateral compliance of the surface.
    bound : ndarray, shape (n, m)
        Largest magnitude of the traction, zero for atoms out of contact (pressure).
    imposed : ndarray, shape (2, n, m)
        Displacement of atoms that stick (length).
    start : ndarray, shape (2, n, m), optional
        Initial tractions (pressure).
    support : LateralSupport, optional
        Lateral force or spring on the indenter; by default the indenter does not move
        further.
    options : FrictionOptions, optional
        Options of the solver.

    Returns
    -------
    FrictionSolution
        Solution, with a status if it has not converged: the contact slides if friction
        can't carry a given force.
    """
    options, before = options or FrictionOptions(), halfspace.transformed
    unit, slides = halfspace.self_compliance, False
    tolerance = smallest_residual(halfspace, options)
    problem = FrictionProblem(halfspace, bound, imposed / unit)
    tractions = np.zeros(imposed.shape) if start is None else start
    residual, status = 0.0, Status(CONVERGED)
    if support is not None:
        force, residual = np.array(support.force), max(support.excess(bound), 0.0)
        slides = not carries(support, bound)
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
        state = lowered(state, options)
    if slides:
        status = Status(SLIDING, {"percent": 100.0 * residual})
        if residual <= _SLIDING_DISTANCE:
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


def carries(support: LateralSupport | None, bound: np.ndarray) -> bool:
    """Return whether friction carries the lateral load at a definite displacement."""
    return support is None or support.excess(bound) <= -_SLIDING_DISTANCE


def smallest_residual(halfspace: LateralHalfSpace, options: FrictionOptions) -> float:
    """Return the tolerance of the residual, above the rounding errors of transforms."""
    rounding = float(np.finfo(halfspace.transform.dtype).eps)
    return max(options.tolerance, _MIN_RESIDUAL * rounding)


def lowered(state: FrictionState, options: FrictionOptions) -> FrictionState:
    """Return a state of a lower energy, after a step of Newton's method."""
    problem, system = state.problem, FrictionSystem(state)
    step = system.solve(options.forcing, options.max_iterations)
    for _ in range(_MAX_SHORTER_STEPS + 1):
        new = problem.moved(state, step)
        if not state.rises(new):
            return new
        step = _STEP_FACTOR * step
    halfspace = problem.halfspace
    largest = halfspace.largest_compliance / halfspace.self_compliance
    return problem.moved(state, state.opening / largest)
