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
_MODEL_RESIDUAL, _MODEL_STEPS, _STEPS = 0.02, 30, 20
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
    residual = pressure + stiffness * response
    # the residual times the adjoint solution is the error of the sum to first order
    error = np.where(hard, -pressure, response) * np.where(hard, response, residual)
    force = halfspace.cell_area * float((pressure - error * active).sum())
    size = norm(equations.rows(change, response[box.slices]).ravel())
    if not size <= _LARGEST_RESIDUAL * equations.size:
        force = np.nan
    return HeightResponse(pressure, response, force)


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
        self._active = active[box.slices]
        d = contact.halfspace.self_compliance * stiffness[box.slices]
        hard = hard[box.slices]
        self._t = np.where(hard, 0.0, 1.0 / (1.0 + np.maximum(d, 0.0)))
        self._s = np.where(hard, 1.0, d * self._t)
        self.size = norm(self._s.ravel())
        self._model = CirculantModel(contact.halfspace, box)
        inner = box.slices_in(self._model.box)
        self._inner = inner
        softness = self._t[self._s > 0.0]
        self._inverse = None
        if softness.size:
            self._inverse = self._model.preconditioner(float(softness.mean()))

    def rows(self, x: np.ndarray, response: np.ndarray) -> np.ndarray:
        """Return what is left of the equations, for ``response = 1 + G x``."""
        rows = self._t * x + self._s * response
        rows *= self._active
        return rows

    def solve(self, tolerance: float) -> np.ndarray:
        """Return the change of the pressure, in units of one over c."""
        right = -self._s * self._active
        solution = gcr(
            self._exact, self._approximate, right.ravel(), tolerance * self.size, _STEPS
        )
        return np.zeros(self._box.shape) + np.reshape(solution, (-1, right.shape[1]))

    def _exact(self, x: np.ndarray) -> np.ndarray:
        """Apply the equations with the half space."""
        field = x.reshape(self._box.shape)
        pressure = np.zeros(self._window)
        pressure[self._box.slices] = field
        opening = self._halfspace.displacement(pressure)[self._box.slices]
        return self.rows(field, opening / -self._halfspace.self_compliance).ravel()

    def _approximate(self, right: np.ndarray) -> np.ndarray:
        """Solve the equations with the model."""
        limit = _MODEL_RESIDUAL * norm(right)
        solution = gcr(
            self._with_model, self._precondition, right.copy(), limit, _MODEL_STEPS
        )
        return right if isinstance(solution, float) else solution

    def _with_model(self, x: np.ndarray) -> np.ndarray:
        field = x.reshape(self._box.shape)
        opening = self._model.compliance(self._embedded(field))[self._inner]
        return self.rows(field, opening).ravel()

    def _precondition(self, right: np.ndarray) -> np.ndarray:
        field = right.reshape(self._box.shape)
        if self._inverse is None:
            return field.ravel().copy()
        out = self._embedded(np.where(self._s > 0.0, field, 0.0))
        self._inverse(out, out)
        return np.where(self._s > 0.0, out[self._inner], field).ravel()

    def _embedded(self, values: np.ndarray) -> np.ndarray:
        field = np.zeros(self._model.box.shape, self._model.dtype)
        field[self._inner] = values
        return field
