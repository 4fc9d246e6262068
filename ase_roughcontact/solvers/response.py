r"""Response of a relaxed contact to its height and to parameters.

With the stiffness :math:`D = V''(g)` of the wall and the compliance :math:`G` of the
half space, the changes of pressure and gap of a relaxed contact by a unit of height,
:math:`x = dp/dZ` and :math:`\lambda = dg/dZ`, solve

.. math:: x + D \lambda = 0, \qquad \lambda = 1 + G x,

and :math:`\lambda = 0` on the atoms in contact with a hard wall. Since :math:`G` is
symmetric, :math:`\lambda` is also the solution of the adjoint equations: the
derivative of the normal force to any parameter :math:`\theta`, on which the pressure
:math:`P(g)` of the wall, the heights h and the compliance may depend, is

.. math:: \frac{dN}{d\theta} = a_0^2 \sum \left[ x
    \left( \frac{\partial h}{\partial\theta}
    + \frac{\partial G}{\partial\theta} p \right)
    + \lambda \frac{\partial P}{\partial\theta} \right].

For the height itself it is :math:`dN/dZ = a_0^2 \sum x`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.kernels import norm
from ase_roughcontact.contact import Contact, ContactState
from ase_roughcontact.elasticity.circulant import CirculantModel
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.gcr import gcr

# Residual of the equations with the circulant model, relative to their right-hand side,
# and the largest number of steps with the model and with the half space.
_MODEL_RESIDUAL, _MODEL_STEPS, _STEPS = 0.1, 30, 20
# Relative residual above which a solution is none.
_LARGEST_RESIDUAL = 0.05


@dataclass(frozen=True, eq=False)
class HeightResponse:
    """Change of a relaxed contact by a unit of height.

    Attributes
    ----------
    pressure : ndarray, shape (n, m)
        dp/dZ (pressure per length).
    gap : ndarray, shape (n, m)
        dg/dZ, which is also the solution of the adjoint equations.
    force : float
        dN/dZ, negative while the contact stiffens (force per length).
    """

    pressure: np.ndarray
    gap: np.ndarray
    force: float


def height_response(
    contact: Contact, state: ContactState, tolerance: float = 1e-4
) -> HeightResponse:
    """Return the change of a relaxed contact by a unit of height.

    Parameters
    ----------
    contact : Contact
    state : ContactState
        Relaxed.
    tolerance : float
        Relative residual of the equations. The error of `force` is about its square.

    Returns
    -------
    HeightResponse
        NaN if the equations are not solved, as at an instability.
    """
    halfspace, (gap, shape) = contact.halfspace, (state.gap, state.gap.shape)
    hard = state.contact if contact.interaction.hard else np.zeros(shape, bool)
    stiffness = np.zeros(shape)
    near = (gap < contact.interaction.cutoff) & ~hard
    if not contact.interaction.hard and near.any():
        stiffness[near] = contact.interaction.evaluate(gap[near])[2]
    active = hard | (stiffness != 0.0)
    box = Box.bounding(active)
    if box is None:
        return HeightResponse(np.zeros(shape), np.ones(shape), 0.0)
    if halfspace.periodic and hard.all():
        return HeightResponse(np.full(shape, -np.inf), np.zeros(shape), -np.inf)
    equations = _Equations(contact, box, stiffness, hard, active)
    change = equations.solve(tolerance)
    pressure = np.zeros(shape)
    pressure[box.slices] = change / halfspace.self_compliance
    response = 1.0 - halfspace.displacement(pressure)
    x, rise, hard = pressure[active], response[active], hard[active]
    residual = x + stiffness[active] * rise
    # the residual times the adjoint solution is the error of the sum to first order
    error = np.where(hard, -x, rise) * np.where(hard, rise, residual)
    force = halfspace.cell_area * float((x - error).sum())
    size = norm(equations.rows(change, response[box.slices]))
    if not size <= _LARGEST_RESIDUAL * equations.size:
        force = np.nan
    return HeightResponse(pressure, response, force)


def force_derivative(
    contact: Contact,
    state: ContactState,
    response: HeightResponse,
    *,
    heights: np.ndarray | float = 0.0,
    wall_pressure: np.ndarray | float = 0.0,
    compliance: float = 0.0,
) -> float:
    """Return the derivative of the normal force to a parameter, at a fixed height.

    The relaxed contact follows the parameter; its change needs no further solution of
    the linear equations.

    Parameters
    ----------
    contact : Contact
    state : ContactState
        Relaxed.
    response : HeightResponse
        With a small tolerance, to which the error is proportional.
    heights : ndarray, shape (n, m)
        Derivative of the heights of the indenter.
    wall_pressure : ndarray, shape (n, m)
        Derivative of the pressure of the wall at fixed gaps.
    compliance : float
        Logarithmic derivative of the compliance of the solid: -1/E* for the contact
        modulus.

    Returns
    -------
    float
        Force per unit of the parameter.

    Notes
    -----
    On a paraboloid, the derivative of the heights to its radius R is ``-r^2/2R^2``. If
    the wall depends on the parameter, its pressure can be differentiated numerically.
    """
    opening = np.zeros(state.gap.shape)
    if compliance:
        opening -= contact.halfspace.displacement(state.pressure)
    change = response.pressure * (heights + compliance * opening)
    change += response.gap * wall_pressure
    return contact.halfspace.cell_area * float(change.sum())


class _Equations:
    """Equations of the response on a box, in units of the self-compliance c.

    With ``d = c D``, ``T = 1/(1 + max(d, 0))`` and ``S = d T``, those of an atom are
    ``T x + S (1 + G x) = 0``, for a hard wall with T = 0 and S = 1.
    """

    def __init__(
        self,
        contact: Contact,
        box: Box,
        stiffness: np.ndarray,
        hard: np.ndarray,
        active: np.ndarray,
    ) -> None:
        self._halfspace, self._box, self._window = contact.halfspace, box, hard.shape
        d = contact.halfspace.self_compliance * stiffness[box.slices]
        hard, active = hard[box.slices], active[box.slices]
        self._t = np.where(hard, 0.0, active / (1.0 + np.maximum(d, 0.0)))
        self._s = np.where(hard, 1.0, d * self._t)
        self.size = norm(self._s)
        # the same in the precision of the model, and a mask of the atoms with S > 0
        self._model = CirculantModel(contact.halfspace, box)
        self._inner = box.slices_in(self._model.box)
        self._stiff = self._embedded(self._s > 0.0)
        self._model_t, self._model_s = map(self._embedded, (self._t, self._s))
        softness = self._t[self._s > 0.0]
        self._inverse = None
        if softness.size:
            self._inverse = self._model.preconditioner(float(softness.mean()))

    def rows(self, x: np.ndarray, response: np.ndarray) -> np.ndarray:
        """Return what is left of the equations, for ``response = 1 + G x``."""
        return self._t * x + self._s * response

    def solve(self, tolerance: float) -> np.ndarray:
        """Return the change of the pressure, in units of one over c."""
        right = -self._s.ravel()
        solution = gcr(
            self._exact, self._approximate, right, tolerance * self.size, _STEPS
        )
        return np.zeros(self._box.shape) + np.reshape(
            solution, (-1, self._box.shape[1])
        )

    def _exact(self, x: np.ndarray) -> np.ndarray:
        """Apply the equations with the half space."""
        field = x.reshape(self._box.shape)
        pressure = np.zeros(self._window)
        pressure[self._box.slices] = field
        opening = self._halfspace.displacement(pressure)[self._box.slices]
        return self.rows(field, opening / -self._halfspace.self_compliance).ravel()

    def _approximate(self, right: np.ndarray) -> np.ndarray:
        """Solve the equations with the model."""
        residual = self._embedded(right.reshape(self._box.shape)).ravel()
        limit = _MODEL_RESIDUAL * norm(residual)
        solution = gcr(
            self._with_model, self._precondition, residual, limit, _MODEL_STEPS
        )
        if isinstance(solution, float):
            return right
        change = solution.reshape(self._model.box.shape)[self._inner]
        return change.astype(float).ravel()

    def _with_model(self, x: np.ndarray) -> np.ndarray:
        field = x.reshape(self._model.box.shape)
        rows = self._model.compliance(field)
        rows *= self._model_s
        rows += self._model_t * field
        return rows.ravel()

    def _precondition(self, right: np.ndarray) -> np.ndarray:
        if self._inverse is None:
            return right.copy()
        field = right.reshape(self._model.box.shape)
        out = self._stiff * field
        self._inverse(out, out)
        out -= field
        out *= self._stiff
        out += field  # atoms without stiffness keep their right-hand side
        return out.ravel()

    def _embedded(self, values: np.ndarray) -> np.ndarray:
        """Return values on the box as a field of the model."""
        field = np.zeros(self._model.box.shape, self._model.dtype)
        field[self._inner] = values
        return field
