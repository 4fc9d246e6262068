"""A step of Newton's method for a soft wall.

If the inverse of a repulsive wall is known, the equation of an atom is ``w(q) = g``
with the gap ``w`` at which the wall has the pressure ``q``, and ``q = 0`` out of
contact (semismooth Newton method). Since ``w`` is nearly linear, whole steps converge.
If the residual has not decreased in several of them, and for all other walls, a step
lowers the energy:

1. Solve Newton's equations for an increment ``(x, z)``; see `newton_equations`.
2. Under attraction, minimise the quadratic model of the energy over the span of this
   increment and the last ones before it, with the exact Hessian. Negative curvatures
   count as positive, so that the combination leads downhill. Near an instability, where
   one mode is far softer than all others, this is what makes progress along it.
3. Search along the combination for a length of at most one at which the energy has
   fallen and the slope has decreased to 30 %.

While forces are large, the negative stiffness of an attractive wall is set to zero: the
equations are positive definite, and the surface follows the state that a slow approach
would find. It is included for the quadratic convergence at the end.

References
----------
M. Hintermüller, K. Ito, K. Kunisch, SIAM J. Optim. 13, 865 (2002) (semismooth Newton
methods and active sets).
"""

from __future__ import annotations

import math

import numpy as np

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.circulant import CirculantModel, covering_model
from ase_roughcontact.solvers.energy import ContactEnergy, EnergyState
from ase_roughcontact.solvers.increments import (
    Increment,
    combine,
    hessian_along,
    line_search,
    moved,
    slope_along,
)
from ase_roughcontact.solvers.indenter_height import carrying_height, supports_indenter
from ase_roughcontact.solvers.newton_equations import NewtonEquations
from ase_roughcontact.solvers.options import NewtonKrylovOptions

# Residual pressure, in contact moduli, below which the negative stiffness of attractive
# walls is included; and the part of the forces below which it is included again.
_ATTRACTION_RESIDUAL = 0.3
# Steps with the inverse of a wall that need not decrease the residual.
_WATCHDOG = 10


class NewtonStepper:
    """Newton steps, with what they remember of earlier ones.

    Parameters
    ----------
    contact : Contact
    options : NewtonKrylovOptions
    """

    def __init__(self, contact: Contact, options: NewtonKrylovOptions) -> None:
        self._halfspace, self._options = contact.halfspace, options
        self._model: CirculantModel | None = None
        self._model_work = 0  # of earlier models, less that of the present one before
        self._history: list[Increment] = []
        # whether negative stiffness counts as zero, and forces below which it does not
        self._convex = True
        modulus, area = self._halfspace.contact_modulus, self._halfspace.cell_area
        self._small = _ATTRACTION_RESIDUAL * modulus * area
        # whether the inverse is used, pressure and height of the best state with it,
        # norm of its residual, and steps since then
        self._inverse = contact.interaction.invertible
        self._best: tuple[np.ndarray, float] | None = None
        self._least_residual, self._futile = math.inf, 0

    @property
    def pairs(self) -> float:
        """FFT pairs so far, normalised to one pair on the grid of the half space."""
        work = self._model_work + (self._model.work if self._model else 0)
        return self._halfspace.pairs + work / math.prod(self._halfspace.grid)

    def step(
        self, energy: ContactEnergy, state: EnergyState, tolerance: float
    ) -> EnergyState | None:
        """Return the next state; None if none is found.

        Parameters
        ----------
        energy : ContactEnergy
            The energy to minimise.
        state : EnergyState
        tolerance : float
            Force at which the solver will stop.
        """
        if energy.loaded and not supports_indenter(energy, state):
            return _lowered(energy, state)
        reduction = max(self._options.forcing, 0.3 * tolerance / state.error)
        if self._inverse:
            new, state = self._inverse_step(energy, state, reduction)
            if new is not None:
                return new
        new = self._descent(energy, state, reduction)
        if new is None and not self._convex:
            self._leave_out_negative_stiffness(state)
            new = self._descent(energy, state, reduction)
        return new

    def restart(self) -> None:
        """Discard earlier increments, and include the negative stiffness."""
        self._history, self._convex, self._inverse = [], False, False

    def _inverse_step(
        self, energy: ContactEnergy, state: EnergyState, reduction: float
    ) -> tuple[EnergyState | None, EnergyState]:
        """Return the state after a step with the inverse of the wall.

        If several steps have not decreased the residual: None, and the best state so
        far, linearised in the gaps.
        """
        if not state.by_pressure:
            state = energy.reevaluated(state, by_pressure=True)
        if self._best is None or state.residual_norm < self._least_residual:
            self._best = state.pressure, state.height
            self._least_residual, self._futile = state.residual_norm, 0
        else:
            self._futile += 1
        new = None
        if self._futile <= _WATCHDOG:
            new = self._equations(energy, state).inverse_step(reduction)
        if new is None:
            state, self._best = energy.state(*self._best), None
        return new, state

    def _equations(
        self, energy: ContactEnergy, state: EnergyState, convex: bool = False
    ) -> NewtonEquations:
        """Return the equations at a state, with a model that covers its box."""
        if self._model is None or not self._model.box.contains(state.box):
            self._model_work += self._model.work if self._model else 0
            self._model = covering_model(self._halfspace, state.box)
            self._model_work -= self._model.work
        return NewtonEquations(energy, state, self._model, convex)

    def _descent(
        self, energy: ContactEnergy, state: EnergyState, reduction: float
    ) -> EnergyState | None:
        """Return a state of lower energy; None if none is found."""
        equations = self._equations(energy, state, self._convex)
        increment = equations.increment(reduction)
        if increment is None:
            return None
        slope = slope_along(energy, state, increment)
        if not self._convex:  # a minimum ahead?
            curvature = hessian_along(energy, state, [increment])[0, 0]
            if not (slope < 0.0 and curvature > 0.0):
                return None
        if abs(slope) <= state.rounding:
            self._convex = False  # too close for the energy to decide
            return moved(energy, state, increment, 1.0)
        if energy.attractive:
            increments = [increment, *self._history]
            self._history = increments[: self._options.history]
            increment = combine(energy, state, increments)
        length, new = line_search(energy, state, increment)
        if new is not None and length < 0.5 and not self._convex:
            self._leave_out_negative_stiffness(state)
        elif length >= 1.0 and state.error < self._small:
            self._convex = False
        return new

    def _leave_out_negative_stiffness(self, state: EnergyState) -> None:
        self._convex = True
        self._small = _ATTRACTION_RESIDUAL * state.error


def _lowered(energy: ContactEnergy, state: EnergyState) -> EnergyState | None:
    """Lower the indenter to where the surface, held fixed, carries the load."""
    height = carrying_height(energy, state.opening, state.height)
    if height is None or height == state.height:
        return None
    return energy.reevaluated(state, height)
