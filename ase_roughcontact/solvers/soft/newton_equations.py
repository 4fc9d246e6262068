r"""Newton's equations at a state of a contact, solved with a model of the half space.

For the residual pressure :math:`r` and the missing load :math:`t`, the change :math:`x`
of the pressure and the change :math:`z` of the height of the indenter solve

.. math:: x + D (G x + z) = r, \qquad \sum x - s z = t

on the atoms in range of the wall, where :math:`D` is the stiffness of the wall,
:math:`G` the Green's function and :math:`s` the stiffness of springs on the indenter
per area of an atom. If the height is fixed, :math:`z = 0` replaces the second equation.

With the circulant model :math:`C` in place of :math:`G` the equations are solved to a
tenth of the residual, which takes a single exact convolution. If the result does not
satisfy the exact equations well enough, they are solved with the model as the
preconditioner.

*Scaling.* With the self-compliance :math:`c` of an atom, the rows are multiplied by

.. math:: W = (1 + c D_+)^{-1/2}, \qquad D_+ = \max(D, 0).

The norm of a scaled residual measures its energy: a large residual pressure on an atom
deep in the core of the wall has no more weight than the small displacement that removes
it.

*Preconditioner.* In units in which :math:`c = 1`,

.. math:: 1 + D C = (1 + D) [s + (1 - s) C], \qquad s = 1/(1 + D).

The share :math:`s`, the compliance of the wall over the compliance of wall and atom in
series, varies much less than :math:`D`. The mean share :math:`\bar s` of the atoms with
:math:`D > 0`, which :math:`\chi` selects, makes the second factor circulant:

.. math:: M r = \chi [\bar s + (1 - \bar s) C]^{-1} \chi W r + (1 - \chi) r.

If the height is free, :math:`z` follows from the second equation, with
:math:`x = M r - z\, M W D 1`.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ase_roughcontact._util.kernels import (
    dot,
    linear_combination,
    max_abs,
    norm,
    scale,
    total,
)
from ase_roughcontact.elasticity.circulant import CirculantModel
from ase_roughcontact.solvers.gcr import gcr
from ase_roughcontact.solvers.soft.energy import EnergyState, Increment

# Largest number of Krylov steps with the model.
_MAX_MODEL_STEPS = 40
# Largest number of Krylov steps with the exact Green's function.
_MAX_EXACT_STEPS = 10
# Largest relative residual of the exact equations for a solution of the model. With a
# larger one, the solver would stall for one of 70 walls with strong attraction.
_MAX_EXACT_RESIDUAL = 1.0
# Smallest tolerance of the residual, relative to the residual with the missing load:
# less is lost in single precision.
_MIN_RESIDUAL = 0.01
# Residual due to a missing load, relative to the tolerance of the residual, up to which
# its effect on the pressures is neglected.
_MAX_NEGLECTED_LOAD = 0.1


class NewtonEquations:
    """Newton's equations at a state of a contact.

    A change of the state is a flat array: the pressures on the box of the state, and
    the height as the last number. Internally a change covers the box of the model, in
    single precision and in units in which the self-compliance is one.

    Parameters
    ----------
    state : EnergyState
        The state.
    model : CirculantModel
        Model that covers the box of the state.
    convex : bool
        Whether a negative stiffness of the wall is set to zero.
    """

    def __init__(
        self, state: EnergyState, model: CirculantModel, convex: bool = False
    ) -> None:
        self._state, self.model, energy = state, model, state.function
        self._window = state.box.slices
        self._inside = state.box.slices_in(model.box)
        self._free, self._load, self._spring = not energy.support.fixed, 0.0, 0.0
        if self._free:  # load and stiffness per area of an atom
            force = energy.external(state.height)[1]
            self._load = -force / energy.area - total(state.pressure)
            spring = energy.spring_stiffness(state.height) / energy.area
            self._spring = spring * model.self_compliance
        self._stiffness = state.stiffness[self._window]
        if convex:
            self._stiffness = np.maximum(self._stiffness, 0.0)
        self._d = self._embedded(self._stiffness, model.self_compliance)
        self._weight = 1.0 / np.sqrt(1.0 + np.maximum(self._d, 0.0))
        self._stiff = (self._d > 0.0).astype(self._d.dtype)
        self._inverse = None
        count = total(self._stiff)
        if count:
            wall_share = dot(self._stiff * self._weight, self._weight) / count
            self._inverse = model.preconditioner(wall_share)

    @property
    def solvable(self) -> bool:
        """Whether the height is fixed, or wall or springs resist its change."""
        return not self._free or self._height_response[1] > 0.0

    def solution(self, reduction: float) -> np.ndarray:
        """Return the change that solves the equations of the model.

        Parameters
        ----------
        reduction : float
            Largest residual of the solution, relative to the residual of the state.

        Returns
        -------
        ndarray, shape (k + 1,)
            Change of the state.
        """
        right = self._scaled(self._state.residual[self._window])
        return self._solve(right, self._load, reduction)

    def refined(
        self, change: np.ndarray, opening: np.ndarray, reduction: float
    ) -> np.ndarray:
        """Solve the exact equations if the residual of a change is above a limit.

        Parameters
        ----------
        change : ndarray, shape (k + 1,)
            Solution for the model.
        opening : ndarray, shape (n, m)
            Change of the opening by this change of the pressures (length).
        reduction : float
            Largest residual for the model, see `solution`.

        Returns
        -------
        ndarray, shape (k + 1,)
            Solution of the exact equations; the given array if its residual is within
            the limit.
        """
        right = self._scaled(self._state.residual[self._window])
        image = self._applied(change, opening)
        left = linear_combination([(1.0, right), (-1.0, image)])
        accepted = _MAX_EXACT_RESIDUAL * max(norm(right), norm(image))
        if self.model.exact or norm(left) <= accepted:
            return change

        def apply(change: np.ndarray) -> np.ndarray:
            return self._applied(change, Increment.of(self._state, change).opening)

        def precondition(residual: np.ndarray) -> np.ndarray:
            return self._solve(residual, 0.0, reduction)

        return change + gcr(apply, precondition, left, accepted, _MAX_EXACT_STEPS)

    def _scaled(self, pressure: np.ndarray) -> np.ndarray:
        """Return ``W r``, flat."""
        stiffness = self.model.self_compliance * np.maximum(self._stiffness, 0.0)
        return (pressure / np.sqrt(1.0 + stiffness)).reshape(-1)

    def _applied(self, change: np.ndarray, opening: np.ndarray) -> np.ndarray:
        """Return ``W [x + D (G x + z)]`` for the exact opening ``G x``."""
        x, z = change[:-1].reshape(self._state.box.shape), float(change[-1])
        return self._scaled(x + self._stiffness * (opening[self._window] + z))

    def _solve(self, right: np.ndarray, load: float, reduction: float) -> np.ndarray:
        """Solve for a right-hand side ``W r`` and a missing load, with the model."""
        unit = max(max_abs(right), abs(load) / right.size) or 1.0
        load = load / unit
        _, resistance, push = self._height_response
        size, dtype = self.model.box.size + 1, self.model.dtype

        def precondition(residual: np.ndarray) -> np.ndarray:
            change = np.empty(size, dtype)
            self._precondition(residual, change[:-1])
            return self._balanced(change, 0.0)

        solution = np.zeros(size, dtype)
        residual = self._embedded(right.reshape(self._stiffness.shape), 1.0 / unit)
        first = norm(residual)
        if load and self._free:
            self._balanced(solution, load)
            # a small missing load is not worth a transform
            limit = _MAX_NEGLECTED_LOAD * reduction * first * resistance
            if abs(load) * push > limit:
                terms = [(1.0, residual), (-1.0, self._apply_model(solution))]
                linear_combination(terms, out=residual)
        tolerance = reduction * max(first, _MIN_RESIDUAL * norm(residual))
        solution += gcr(
            self._apply_model, precondition, residual, tolerance, _MAX_MODEL_STEPS
        )
        change = np.empty(right.size + 1)
        x = solution[:-1].reshape(self.model.box.shape)[self._inside]
        np.multiply(x, unit, out=change[:-1].reshape(x.shape))
        change[-1] = float(solution[-1]) * unit * self.model.self_compliance
        return change

    def _balanced(self, change: np.ndarray, load: float) -> np.ndarray:
        """Add the change of height with which ``sum x - s z`` is the load."""
        x, z = change[:-1], 0.0
        if self._free:
            response, resistance, _ = self._height_response
            z = (total(x) - load) / resistance
            linear_combination([(1.0, x), (-z, response)], out=x)
        change[-1] = z
        return change

    @cached_property
    def _height_response(self) -> tuple[np.ndarray, float, float]:
        """Return ``M W D 1``, the resistance to a change of height, and ``|W D 1|``."""
        response = np.empty_like(self._d)
        if not self._free:
            return response, 0.0, 0.0
        push = self._d * self._weight
        self._precondition(push, response)
        return response, float(response.sum()) + self._spring, norm(push)

    def _apply_model(self, change: np.ndarray) -> np.ndarray:
        """Return ``W [x + D (C x + z)]``."""
        x, z, shape = change[:-1], change[-1], self.model.box.shape
        rows = np.empty_like(x)
        self.model.compliance(x.reshape(shape), rows.reshape(shape))
        rows += z
        rows *= self._d
        rows += x
        rows *= self._weight
        return rows

    def _precondition(self, rows: np.ndarray, out: np.ndarray) -> None:
        """Set ``out = M r``."""
        if self._inverse is None:
            out[:] = rows
            return
        np.multiply(rows, self._weight, out=out)
        out *= self._stiff
        field = out.reshape(self.model.box.shape)
        self._inverse(field, field)
        out -= rows
        out *= self._stiff
        out += rows

    def _embedded(self, values: np.ndarray, factor: float) -> np.ndarray:
        """Return values on the box times a factor, zero on the rest of the model."""
        field = np.zeros(self.model.box.shape, self.model.dtype)
        scale(field[self._inside], values, factor)
        return field.reshape(-1)
