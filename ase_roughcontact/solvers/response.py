r"""Response of a relaxed contact to its height and to parameters.

With the stiffness :math:`D = V''(g)` of the wall and the compliance :math:`G` of the
half space, the changes of pressure and gap of a relaxed contact by a unit of height,
:math:`x = dp/dZ` and :math:`\lambda = dg/dZ`, solve

.. math:: x + D \lambda = 0, \qquad \lambda = 1 + G x,

and :math:`\lambda = 0` on atoms in elastic contact with a hard wall; atoms in plastic
contact keep their pressure. Since :math:`G` is symmetric, :math:`\lambda` is also the
solution of the adjoint equations: if the pressure :math:`P(g)` of the wall, the heights
h or the compliance depend on a parameter :math:`\theta`, the derivative of the normal
force is

.. math:: \frac{dN}{d\theta} = a_0^2 \sum \left[ x
    \left( \frac{\partial h}{\partial\theta}
    + \frac{\partial G}{\partial\theta} p \right)
    + \lambda \frac{\partial P}{\partial\theta} \right].

The derivative with the height is :math:`dN/dZ = a_0^2 \sum x`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from ase_roughcontact._util.kernels import dot, linear_combination, norm, scale
from ase_roughcontact.contact import Contact, ContactState
from ase_roughcontact.elasticity.circulant import CirculantModel, covering_model
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.interactions import scaled_attraction
from ase_roughcontact.solvers.gcr import gcr

# Largest number of steps for general equations, where all directions are kept.
_MAX_STEPS = 40
# Largest number of steps for a hard wall.
_MAX_HARD_STEPS = 200
# Largest change of the force by the last step under a hard wall, in units of the force
# times the square of the tolerance. The change by further steps is estimated.
_MAX_LAST_CHANGE = 30.0
# Relative residual above which a solution is rejected.
_MAX_RESIDUAL = 0.05
# Relative error of a sum of stiffnesses.
_STIFFNESS_ERROR = 1e-3
# Smallest tolerance for which steps are made in single precision.
_MIN_SINGLE_TOLERANCE = 1e-3
# Smallest number of atoms for which steps are made in single precision.
_MIN_SINGLE_ATOMS = 64 * 64
# Longest side of a window for which eigenvalues are tested (atoms).
_MAX_EIGENVALUE_SIDE = 64
# Largest number of atoms for which eigenvalues are tested.
_MAX_EIGENVALUE_ATOMS = 600


@dataclass(eq=False)
class HeightResponse:
    """Change of a relaxed contact by a unit of height.

    Attributes
    ----------
    pressure : ndarray, shape (n, m)
        Change dp/dZ of the pressure (pressure per length).
    force : float
        Change dN/dZ of the normal force (force per length), negative if the force rises
        as the indenter is lowered.
    halfspace : HalfSpace
        Half space of the contact.
    """

    pressure: np.ndarray
    force: float
    halfspace: HalfSpace

    @cached_property
    def gap(self) -> np.ndarray:
        """Change dg/dZ of the gap, the adjoint solution, shape (n, m)."""
        if self.force == -np.inf:  # all atoms stay in contact
            return np.zeros(self.pressure.shape)
        return 1.0 - self.halfspace.displacement(self.pressure)


def height_response(
    contact: Contact, state: ContactState, tolerance: float = 1e-4
) -> HeightResponse:
    r"""Return the change of a relaxed contact by a unit of height.

    Parameters
    ----------
    contact : Contact
        The contact.
    state : ContactState
        Relaxed state of the contact.
    tolerance : float
        Relative residual of the equations. The relative error of `force` grows with the
        square of the tolerance, and with the radius of the contact: it is 0.003 for a
        tolerance of 0.01 and 500 atoms. Under a hard wall without attraction, and with
        a tolerance of 0.01, it was 8e-5 in the median of 16 contacts, and at most 8e-4.

    Returns
    -------
    HeightResponse
        Changes by a unit of height. They are NaN if the equations are not solved, as at
        an instability, or if the state is not a minimum of the energy.

    Notes
    -----
    In a minimum the relaxation of the surface makes the contact more compliant than a
    rigid surface at the same gaps, :math:`-dN/dZ \le a_0^2 \sum V''(g)`. A solver
    may end at a state just beyond an instability, from which the surface would still
    move: there the solution of the equations violates the inequality, and is not a
    stiffness. The signs of the eigenvalues are also tested in windows of at most 64 x
    64 with up to 600 atoms in range of the wall, if the attraction is steep.
    """
    halfspace, shape = contact.halfspace, state.gap.shape
    hard = np.zeros(shape, bool)
    if contact.wall.hard:
        hard = state.contact & ~state.plastic  # plastic atoms stay at the hardness
    if contact.wall.purely_hard or (halfspace.periodic and hard.all()):
        return punch_response(halfspace, hard, tolerance)
    d = _relative_stiffness(contact, state, hard)
    active = hard | (d != 0.0)
    if not active.any():
        return HeightResponse(np.zeros(shape), 0.0, halfspace)
    atoms = active.ravel().nonzero()[0]
    small = max(shape) <= _MAX_EIGENVALUE_SIDE and atoms.size <= _MAX_EIGENVALUE_ATOMS
    if small and d.min() <= -1.0 and not _is_minimum(halfspace, d, atoms):
        return HeightResponse(np.full(shape, np.nan), np.nan, halfspace)
    return _general_response(halfspace, d, hard, tolerance)


def _general_response(
    halfspace: HalfSpace, d: np.ndarray, hard: np.ndarray, tolerance: float
) -> HeightResponse:
    """Return the response of any wall to a unit of height.

    In units of the self-compliance c, with ``d = c D``, ``T = 1/(1 + max(d, 0))`` and
    ``S = d T``, the equation of an atom is ``T x + S (1 + G x) = 0``, with T = 0 and
    S = 1 for a hard wall. Atoms out of range of the wall have no pressure.
    """
    single = tolerance >= _MIN_SINGLE_TOLERANCE and d.size >= _MIN_SINGLE_ATOMS
    solid = halfspace.in_single_precision() if single else halfspace
    active, compliance = hard | (d != 0.0), halfspace.self_compliance
    t = np.where(hard, 0.0, active / (1.0 + np.maximum(d, 0.0)))
    s = np.where(hard, 1.0, d * t).astype(solid.dtype)
    t = t.astype(solid.dtype)
    stiff = s > 0.0
    box = Box.bounding(stiff)
    if box is not None:
        model = _covering(halfspace, box)
        inside, mask = model.box.slices, stiff[model.box.slices].astype(model.dtype)
        inverse = model.preconditioner(float(t.mean(where=stiff)))

    def apply(x: np.ndarray) -> np.ndarray:
        rows = solid.displacement(x)
        rows *= s
        rows *= -1.0 / compliance
        rows += t * x
        return rows

    def precondition(residual: np.ndarray) -> np.ndarray:
        out = residual.copy()  # for atoms without stiffness
        if box is not None:
            right = out[inside]
            change = np.multiply(right, mask, dtype=mask.dtype)
            inverse(change, change)
            change -= right
            right += mask * change
        return out

    size = norm(s)
    x = np.zeros(d.shape)  # in double precision
    x += gcr(apply, precondition, -s, tolerance * size, _MAX_STEPS)
    result = HeightResponse(x / compliance, np.nan, halfspace)
    solved = norm(t * x + s * result.gap) <= _MAX_RESIDUAL * size
    stiffness = halfspace.cell_area / compliance  # stiffness of an atom
    force = stiffness * _stationary_sum(
        x[active], result.gap[active], d[active], hard[active]
    )
    rigid_surface = np.inf if hard.any() else stiffness * d.sum()
    if solved and force >= -rigid_surface - _STIFFNESS_ERROR * stiffness * abs(d).sum():
        result.force = force
    return result


def punch_response(
    halfspace: HalfSpace, footprint: np.ndarray, tolerance: float = 1e-4
) -> HeightResponse:
    r"""Return the change of the contact of a rigid punch by a unit of height.

    Any contact under a rigid surface without attraction changes like this if its region
    is fixed.

    Parameters
    ----------
    halfspace : HalfSpace
        The half space.
    footprint : ndarray of bool, shape (n, m)
        Atoms that move with the punch; other atoms have no pressure.
    tolerance : float
        Tolerance; the relative error of the force is about its square.

    Returns
    -------
    HeightResponse
        Changes by a unit of height. The force is infinite if the footprint is a whole
        periodic cell.

    Notes
    -----
    Conjugate gradients solve :math:`-G x = 1` on the footprint, with zero elsewhere,
    preconditioned by the inverse of the model. Each step increases the force by the
    length times the work of the step. The increase by further steps is estimated from a
    geometric series with the mean ratio of the last three steps.
    """
    box = Box.bounding(footprint)
    if box is None:
        return HeightResponse(np.zeros(footprint.shape), 0.0, halfspace)
    if halfspace.periodic and footprint.all():
        return HeightResponse(np.full(footprint.shape, -np.inf), -np.inf, halfspace)
    model = _covering(halfspace, box)
    dtype, opened = model.dtype, model.compliance
    single = tolerance >= _MIN_SINGLE_TOLERANCE and footprint.size >= _MIN_SINGLE_ATOMS
    if not (model.exact and (single or dtype.itemsize == 8)):
        exact = halfspace.in_single_precision() if single else halfspace
        dtype, opened = exact.dtype, partial(_opening, exact)
    inside = footprint.astype(dtype)
    residual = inside.copy()
    x, direction, buffer = (np.zeros(footprint.shape, dtype) for _ in range(3))
    growth: list[float] = []
    last_work, part = np.inf, model.box.slices
    for _ in range(_MAX_HARD_STEPS):
        buffer[part] = model.stiffness(residual[part])
        buffer *= inside
        work = dot(buffer, residual)
        if not work:
            break
        linear_combination([(work / last_work, direction), (1.0, buffer)], direction)
        opening = opened(direction, buffer)
        opening *= inside
        length, last_work = work / dot(direction, opening), work
        linear_combination([(1.0, x), (length, direction)], x)
        linear_combination([(1.0, residual), (-length, opening)], residual)
        growth.append(length * work)
        if growth[-1] <= _MAX_LAST_CHANGE * tolerance**2 * sum(growth):
            break
    else:
        return HeightResponse(np.full(footprint.shape, np.nan), np.nan, halfspace)
    force = sum(growth) + _remaining_sum(growth[-3:])
    force *= halfspace.cell_area / halfspace.self_compliance
    x *= -1.0 / halfspace.self_compliance
    return HeightResponse(x, -force, halfspace)


def _remaining_sum(terms: list[float]) -> float:
    """Return the sum of a geometric series after the given terms; zero if they rise."""
    if len(terms) < 2 or not 0.0 < terms[-1] < terms[0]:
        return 0.0
    ratio = (terms[-1] / terms[0]) ** (1.0 / (len(terms) - 1))
    return terms[-1] * ratio / (1.0 - ratio)


def _relative_stiffness(
    contact: Contact, state: ContactState, hard: np.ndarray
) -> np.ndarray:
    """Return ``c V''``, with the self-compliance c; zero at a hard wall."""
    wall, gap, d = contact.wall, state.gap, np.zeros(hard.shape)
    near = gap < wall.cutoff
    near &= ~hard
    if near.any():
        adhesion = None if contact.adhesion is None else contact.adhesion[near]
        closest = np.maximum(gap[near], 0.0) if wall.hard else gap[near]
        d[near] = scaled_attraction(wall, closest, adhesion)[2]
        d *= contact.halfspace.self_compliance
    return d


def _is_minimum(halfspace: HalfSpace, d: np.ndarray, atoms: np.ndarray) -> bool:
    """Return whether the energy has a minimum, by the inertia of ``1/V'' + G``."""
    pairs, columns = halfspace.pair_compliance, halfspace.shape[1]
    # the compliance of a pair is at the difference of the places of its atoms
    places = atoms + (atoms // columns) * (columns - 1)
    matrix = pairs.take(np.subtract.outer(places + pairs.size // 2, places))
    stiffness = d.take(atoms)  # zero for atoms at a hard wall, without a compliance
    compliance = np.divide(1.0, stiffness, where=stiffness != 0.0, out=0.0 * stiffness)
    matrix[np.diag_indices(atoms.size)] += halfspace.self_compliance * compliance
    negative = np.count_nonzero(np.linalg.eigvalsh(matrix) < 0.0)
    return bool(negative == np.count_nonzero(compliance < 0.0))


def _stationary_sum(
    x: np.ndarray, response: np.ndarray, d: np.ndarray, hard: np.ndarray
) -> float:
    r"""Return :math:`\sum x` without its error of first order.

    The error is the residual :math:`x + d \lambda` times the adjoint solution. The
    adjoint solution is :math:`\lambda`, or equally :math:`-x/d`, which does not amplify
    the residual of atoms at a stiff wall.
    """
    adjoint = np.where(d > 1.0, -x / np.maximum(d, 1.0), response)
    error = np.where(hard, -x * response, adjoint * (x + d * response))
    return float((x - error).sum())


def force_derivative(
    contact: Contact,
    state: ContactState,
    response: HeightResponse,
    *,
    heights: np.ndarray | float = 0.0,
    wall_pressure: np.ndarray | float = 0.0,
    compliance: float = 0.0,
) -> float:
    """Return the derivative of the normal force with a parameter, at a fixed height.

    The contact relaxes as the parameter changes, without another solution of linear
    equations.

    Parameters
    ----------
    contact : Contact
        The contact.
    state : ContactState
        Relaxed state of the contact.
    response : HeightResponse
        Response for a small tolerance, to which the error is proportional.
    heights : ndarray, shape (n, m)
        Derivative of the heights of the indenter with the parameter.
    wall_pressure : ndarray, shape (n, m)
        Derivative of the pressure of the wall with the parameter, at fixed gaps.
    compliance : float
        Logarithmic derivative of the compliance of the solid: -1/E* for the contact
        modulus.

    Returns
    -------
    float
        Derivative (force per unit of the parameter).

    Notes
    -----
    For a paraboloid, the derivative of the heights with the radius R is ``-r^2/2R^2``.
    If the wall depends on the parameter, its pressure can be differentiated
    numerically.
    """
    opening = np.zeros(state.gap.shape)
    if compliance:
        opening -= contact.halfspace.displacement(state.pressure)
    change = response.pressure * (heights + compliance * opening)
    change += response.gap * wall_pressure
    return contact.halfspace.cell_area * float(change.sum())


def _covering(halfspace: HalfSpace, box: Box) -> CirculantModel:
    """Return a model for a preconditioner: the solver's model if it covers a box."""
    model: CirculantModel | None = halfspace.model
    if model is None or not model.box.contains(box):
        model = covering_model(halfspace, box)
    return model


def _opening(halfspace: HalfSpace, pressure: np.ndarray, out: np.ndarray) -> np.ndarray:
    """Set and return ``G p`` in units of the self-compliance."""
    opening = halfspace.displacement(pressure)
    scale(out, opening, -1.0 / halfspace.self_compliance)
    return out
