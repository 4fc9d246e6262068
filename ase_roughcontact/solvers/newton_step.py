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


class NewtonStepper:
    """Newton steps, with the earlier increments that they are combined with.

    Parameters
    ----------
    energy : ContactEnergy
        The energy to minimise.
    options : NewtonKrylovOptions
    """

    def __init__(self, energy: ContactEnergy, options: NewtonKrylovOptions) -> None:
        halfspace = energy.contact.halfspace
        self._energy, self._options = energy, options
        self._convex = True
        # forces below which the negative stiffness is included
        modulus = halfspace.contact_modulus
        self._small = options.attraction_residual * modulus * halfspace.cell_area
        self._history: list[Increment] = []
        self._equations = NewtonEquations(energy, options)
        self._inverse = energy.invertible
        self._best: EnergyState | None = None
        self._futile = 0

    @property
    def pairs(self) -> float:
        """FFT pairs so far, normalised to one pair on the grid of the half space."""
        return self._equations.pairs

    def step(self, state: EnergyState, tolerance: float) -> EnergyState | None:
        """Return the next state; None if none is found.

        Parameters
        ----------
        state : EnergyState
        tolerance : float
            Force at which the solver will stop.
        """
        energy, options = self._energy, self._options
        if energy.loaded and not supports_indenter(energy, state):
            return self._lowered(state)
        reduction = max(options.forcing, 0.3 * tolerance / state.error)
        if self._inverse:
            new, state = self._inverse_step(state, reduction, tolerance)
            if new is not None:
                return new
        increment = self._equations.increment(state, self._convex, reduction)
        if increment is None or not (
            self._convex or self._is_minimum(state, increment)
        ):
            return self._convex_step(state, tolerance)
        if abs(slope_along(energy, state, increment)) <= state.rounding:
            self._convex = False  # too close for the energy to decide
            return moved(energy, state, increment, 1.0)
        increment = self._combined(state, increment)
        length, new = line_search(energy, state, increment, options.remaining_slope)
        if new is None:
            return self._convex_step(state, tolerance)
        if length < 0.5 and not self._convex:
            self._make_convex(state)
        elif length >= 1.0 and state.error < self._small:
            self._convex = False
        return new

    def restart(self) -> None:
        """Discard earlier increments, and include the negative stiffness."""
        self._history, self._convex, self._inverse = [], False, False

    def _inverse_step(
        self, state: EnergyState, reduction: float, tolerance: float
    ) -> tuple[EnergyState | None, EnergyState]:
        """Return the state after a step with the inverse of the wall.

        If several steps have not decreased the residual: None, and the best state so
        far, linearised in the gaps.
        """
        energy = self._energy
        if not state.by_pressure:
            state = energy.state(
                state.pressure, state.height, state.opening, by_pressure=True
            )
        if self._best is None or state.residual_norm < self._best.residual_norm:
            self._best, self._futile = state, 0
        else:
            self._futile += 1
        new = None
        if self._futile <= self._options.watchdog:
            new = self._equations.inverse_step(state, reduction, tolerance)
        if new is None:
            best, self._best = self._best, None
            state = energy.state(best.pressure, best.height, best.opening)
        return new, state

    def _combined(self, state: EnergyState, increment: Increment) -> Increment:
        """Combine an increment with earlier ones under a wall with attraction."""
        if not self._energy.wall.attractive:
            return increment
        options, increments = self._options, [increment, *self._history]
        self._history = increments[: options.history]
        return combine(self._energy, state, increments, options.least_curvature)

    def _make_convex(self, state: EnergyState) -> None:
        self._convex = True
        self._small = self._options.attraction_residual * state.error

    def _convex_step(self, state: EnergyState, tolerance: float) -> EnergyState | None:
        """Try again without the negative stiffness, unless it was left out already."""
        if self._convex:
            return None
        self._make_convex(state)
        return self.step(state, tolerance)

    def _lowered(self, state: EnergyState) -> EnergyState | None:
        """Lower the indenter to where the surface, held fixed, carries the load."""
        height = carrying_height(self._energy, state.opening, state.height)
        if height is None or height == state.height:
            return None
        return self._energy.state(state.pressure, height, state.opening)

    def _is_minimum(self, state: EnergyState, increment: Increment) -> bool:
        """Return whether the energy falls along an increment, and is convex."""
        falls = slope_along(self._energy, state, increment) < 0.0
        return falls and hessian_along(self._energy, state, [increment])[0, 0] > 0.0
