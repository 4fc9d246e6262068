r"""The linear system of a Newton step for a soft wall, with a model of the half space.

For the residual pressure :math:`r` and the missing load :math:`t`, the changes
:math:`x` of the pressure and :math:`z` of the height of the indenter solve

.. math:: x + D (C x + z) = r, \qquad \sum x - s z = t

on the atoms in range of the wall, where :math:`D` is the stiffness of the wall,
:math:`C` the circulant model and :math:`s` the stiffness of springs on the indenter per
area of an atom. If the height is fixed, :math:`z = 0` replaces the second equation.

*Scaling.* With the self-compliance :math:`c` of an atom, the rows are multiplied by

.. math:: W = (1 + c D_+)^{-1/2}, \qquad D_+ = \max(D, 0).

The norm of a scaled residual measures its energy: a large residual pressure on an atom
deep in the core of the wall counts no more than the small displacement that removes it.

*Preconditioner.* In units in which :math:`c = 1`,

.. math:: 1 + D C = (1 + D) [s + (1 - s) C], \qquad s = 1/(1 + D).

:math:`s`, the compliance of the wall as a part of that of wall and atom in series,
varies much less than :math:`D`. Its mean :math:`\bar s` over the atoms with
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
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.gcr import gcr

# The missing load changes the residual of the pressures. What is smaller than this part
# of that residual is lost in single precision.
_LEAST_RESIDUAL = 0.01
# Residual due to a missing load that counts as small, relative to what may be left.
_SMALL_LOAD = 0.1


class NewtonSystem:
    """Scaled Newton equations at a state of the contact.

    A change of the state is a flat array: the pressures on the box, and the height as
    the last number. Internally it covers the box of the model, in single precision and
    in units in which the self-compliance is one.

    Parameters
    ----------
    model : CirculantModel
        Model of the half space.
    box : Box
        Atoms under consideration, within the box of the model.
    stiffness : ndarray, shape of the box
        Stiffness of the wall (pressure per length).
    spring : float, optional
        Stiffness of springs on the indenter per area of an atom; by default the height
        is fixed.
    """

    def __init__(
        self,
        model: CirculantModel,
        box: Box,
        stiffness: np.ndarray,
        spring: float | None,
    ) -> None:
        self._model, self._stiffness, self._spring = model, stiffness, spring
        self.exact = model.exact
        self._inside = box.slices_in(model.box)
        self._d = self._embedded(stiffness, model.self_compliance)
        self._weight = 1.0 / np.sqrt(1.0 + np.maximum(self._d, 0.0))
        self._stiff = (self._d > 0.0).astype(self._d.dtype)
        self._inverse = None
        if count := total(self._stiff):
            softness = dot(self._stiff * self._weight, self._weight) / count
            self._inverse = model.preconditioner(softness)

    @property
    def work(self) -> int:
        """Grid points that the model has transformed, forward and back."""
        return self._model.work

    def scaled(self, pressure: np.ndarray) -> np.ndarray:
        """Return ``W r``.

        Parameters
        ----------
        pressure : ndarray, shape of the box

        Returns
        -------
        ndarray, shape (k,)
        """
        stiffness = self._model.self_compliance * np.maximum(self._stiffness, 0.0)
        return (pressure / np.sqrt(1.0 + stiffness)).reshape(-1)

    def applied(self, change: np.ndarray, opening: np.ndarray) -> np.ndarray:
        """Return ``W [x + D (G x + z)]`` for the exact opening ``G x``.

        Parameters
        ----------
        change : ndarray, shape (k + 1,)
        opening : ndarray, shape of the box

        Returns
        -------
        ndarray, shape (k,)
        """
        x, z = change[:-1].reshape(opening.shape), float(change[-1])
        return self.scaled(x + self._stiffness * (opening + z))

    def solve(
        self, right: np.ndarray, load: float, reduction: float, max_steps: int
    ) -> np.ndarray | None:
        """Solve by preconditioned generalised conjugate residuals.

        Parameters
        ----------
        right : ndarray, shape (k,)
            Scaled residual ``W r`` (pressure).
        load : float
            Missing load ``t`` (pressure); ignored if the height is fixed.
        reduction : float
            Norm of the residual at which to stop, relative to that of `right`.
        max_steps : int
            Maximum number of steps.

        Returns
        -------
        ndarray, shape (k + 1,)
            Changes of pressure and height; None if neither wall nor springs resist a
            change of height.
        """
        model = self._model
        unit = max(max_abs(right), abs(load) / right.size) or 1.0
        load = load / unit
        response, resistance, push = self._height_response
        if self._spring is not None and not resistance > 0.0:
            return None

        def precondition(residual: np.ndarray) -> np.ndarray:
            change = self._new_change()
            self._precondition(residual, change[:-1])
            return self._balanced(change, 0.0, response, resistance)

        solution = self._new_change()
        solution[:] = 0.0
        residual = self._embedded(right.reshape(self._stiffness.shape), 1.0 / unit)
        first = norm(residual)
        # a load that is all but carried needs no transform of its own
        small = abs(load) * push <= _SMALL_LOAD * reduction * first * resistance
        if load and self._spring is not None:
            self._balanced(solution, load, response, resistance)
        if load and self._spring is not None and not small:
            terms = [(1.0, residual), (-1.0, self._apply_model(solution))]
            linear_combination(terms, out=residual)
        tolerance = reduction * max(first, _LEAST_RESIDUAL * norm(residual))
        solution += gcr(self._apply_model, precondition, residual, tolerance, max_steps)
        change = np.empty(right.size + 1)
        x = solution[:-1].reshape(model.box.shape)[self._inside]
        np.multiply(x, unit, out=change[:-1].reshape(x.shape))
        change[-1] = float(solution[-1]) * unit * model.self_compliance
        return change

    def _balanced(
        self, change: np.ndarray, load: float, response: np.ndarray, resistance: float
    ) -> np.ndarray:
        """Add the change of height that makes ``sum x - s z`` equal the load."""
        x, z = change[:-1], 0.0
        if self._spring is not None:
            z = (total(x) - load) / resistance
            linear_combination([(1.0, x), (-z, response)], out=x)
        change[-1] = z
        return change

    @cached_property
    def _height_response(self) -> tuple[np.ndarray, float, float]:
        """Return ``M W D 1``, the resistance to a change of height, and ``|W D 1|``."""
        response = np.empty_like(self._d)
        if self._spring is None:
            return response, 0.0, 0.0
        push = self._d * self._weight
        self._precondition(push, response)
        spring = self._spring * self._model.self_compliance
        return response, float(response.sum()) + spring, norm(push)

    def _apply_model(self, change: np.ndarray) -> np.ndarray:
        """Return ``W [x + D (C x + z)]``."""
        x, z, shape = change[:-1], change[-1], self._model.box.shape
        rows = np.empty_like(x)
        self._model.compliance(x.reshape(shape), rows.reshape(shape))
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
        field = out.reshape(self._model.box.shape)
        self._inverse(field, field)
        out -= rows
        out *= self._stiff
        out += rows

    def _new_change(self) -> np.ndarray:
        return np.empty(self._model.box.size + 1, self._model.dtype)

    def _embedded(self, values: np.ndarray, factor: float) -> np.ndarray:
        """Return values on the box times a factor, zero on the rest of the model."""
        field = np.zeros(self._model.box.shape, self._model.dtype)
        scale(field[self._inside], values, factor)
        return field.reshape(-1)
