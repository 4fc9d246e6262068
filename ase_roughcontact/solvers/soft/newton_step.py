r"""A step of Newton's method for a soft wall.

If the inverse of a repulsive wall is known, the equation of an atom is ``w(q) = g``
with the gap ``w`` at which the wall has the pressure ``q``, and ``q = 0`` out of
contact (semismooth Newton method). Since ``w`` is nearly linear, whole steps converge.
If the last step has decreased the residual, but by less than a half, steps are combined
as in 2. below: the model is inaccurate in the longest waves, and the more so the larger
the contact. A step that has increased it has brought atoms into contact or out of it,
which whole steps find. If the residual has not decreased in several steps, and for all
other walls, a step lowers the energy:

1. Solve Newton's equations for an increment ``(x, z)``; see `newton_equations`.
2. Under attraction, minimise the quadratic model of the energy over the span of this
   increment and earlier ones, with the exact Hessian. Negative curvatures count as
   positive, so that the combination leads downhill. This makes progress near an
   instability, where one mode is far more compliant than all others.
3. Search along the combination for a length of at most one at which the energy has
   fallen and the slope has decreased to 30 %.

While forces are large, the negative stiffness of an attractive wall is set to zero: the
equations are then positive definite, and the surface follows the state that a slow
approach would find. At the end the negative stiffness is included, for quadratic
convergence.

An increment :math:`(x, G x, z)` contains the opening :math:`G x` of the gap, so that
slopes and curvatures of the energy along it (see `energy`) cost no convolution:

.. math:: s = -a_0^2\, r \cdot G x - F z, \qquad
    H_{ij} = a_0^2 \left[x_i \cdot G x_j
    + \sum V'' (G x_i + z_i)(G x_j + z_j)\right] + U'' z_i z_j .

References
----------
M. Hintermüller, K. Ito, K. Kunisch, SIAM J. Optim. 13, 865 (2002) (semismooth Newton
methods and active sets).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ase_roughcontact._util.kernels import linear_combination
from ase_roughcontact.elasticity.circulant import CirculantModel, covering_model
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.solvers.options import NewtonKrylovOptions
from ase_roughcontact.solvers.soft.energy import EnergyState, Increment
from ase_roughcontact.solvers.soft.indenter_height import (
    carrying_height,
    supports_indenter,
)
from ase_roughcontact.solvers.soft.newton_equations import NewtonEquations

# Residual pressure below which the negative stiffness of attractive walls is included,
# in contact moduli; after a failed step, relative to the forces at this step.
_ATTRACTION_RESIDUAL = 0.3
# Largest number of steps with the inverse of a wall that do not decrease the residual.
_MAX_STALLED = 20
# Ratio of the residuals after and before a step, above which steps are combined, up to
# a ratio of one.
_SLOW_CONTRACTION = 0.5
# Smallest curvature of a combination, relative to the curvatures of its increments.
_MIN_CURVATURE = 0.003
# Largest slope at the end of a line search, relative to the initial slope.
_MAX_SLOPE_RATIO = 0.3
# Largest number of lengths that a line search tries.
_MAX_TRIALS = 40


class NewtonStepper:
    """Newton steps, which use earlier increments.

    Parameters
    ----------
    halfspace : HalfSpace
        Half space of the contact.
    options : NewtonKrylovOptions
        Options of the solver.
    """

    def __init__(self, halfspace: HalfSpace, options: NewtonKrylovOptions) -> None:
        self._halfspace, self._options = halfspace, options
        self._model: CirculantModel | None = None
        self._history: list[Increment] = []
        # whether negative stiffness is set to zero, until forces are small
        self._convex = True
        modulus, area = self._halfspace.contact_modulus, self._halfspace.cell_area
        self._small = _ATTRACTION_RESIDUAL * modulus * area
        # smallest norm of the residual by the inverse of the wall, and steps since then
        self._least_residual, self._stalled = math.inf, 0
        self._last_residual = math.inf

    def step(self, state: EnergyState, tolerance: float) -> EnergyState | None:
        """Return the next state; None if no state of lower energy is found.

        Parameters
        ----------
        state : EnergyState
            Present state.
        tolerance : float
            Largest force at which the solver will stop.
        """
        energy = state.function
        if not energy.support.fixed and not supports_indenter(state):
            # lower the indenter until the fixed surface carries the load
            height = carrying_height(energy, state.opening, state.height)
            if height is None or height == state.height:
                return None
            return state.again(height=height)
        reduction = max(self._options.forcing, 0.3 * tolerance / state.error)
        if energy.inverse:
            new = self._inverse_step(state, reduction)
            if new is not None:
                return new
            state = state.again(replace(energy, inverse=False))
        new = self._descent(state, reduction)
        if new is None and not self._convex:
            self._leave_out_negative_stiffness(state)
            new = self._descent(state, reduction)
        return new

    def restart(self) -> None:
        """Discard earlier increments, and include the negative stiffness."""
        self._history, self._convex = [], False

    def _inverse_step(self, state: EnergyState, reduction: float) -> EnergyState | None:
        """Return the state after a step with the inverse of the wall.

        None if several steps have not decreased the residual.
        """
        self._stalled += 1
        if state.residual_norm < self._least_residual:
            self._least_residual, self._stalled = state.residual_norm, 0
        equations = self._equations(state)
        if self._stalled > _MAX_STALLED or not equations.solvable:
            return None
        change, model = equations.solution(reduction), equations.model
        del equations  # frees memory
        held = state.stiffness > 0.0  # there is no pressure on other atoms
        pressure = (state.pressure + state.on_window(change)) * held
        height = state.height + float(change[-1])
        last = self._last_residual
        slow = _SLOW_CONTRACTION * last < state.residual_norm < last
        self._last_residual = state.residual_norm
        if model.exact:
            return EnergyState(state.function, pressure, height)
        opening = state.function.opening(pressure)
        increment = Increment.between(state, pressure, opening, height)
        if slow and self._history:
            del pressure, opening
            increment = combine(state, [increment, *self._history])
            self._history = [increment]
            return state.moved(increment, 1.0)
        self._history = [increment]
        return EnergyState(state.function, pressure, height, opening, exact=True)

    def _equations(self, state: EnergyState, convex: bool = False) -> NewtonEquations:
        """Return the equations at a state, with a model that covers its box."""
        if self._model is None or not self._model.box.contains(state.box):
            self._model = covering_model(self._halfspace, state.box)
        return NewtonEquations(state, self._model, convex)

    def _descent(self, state: EnergyState, reduction: float) -> EnergyState | None:
        """Return a state of lower energy; None if no such state is found."""
        equations = self._equations(state, self._convex)
        if not equations.solvable:
            return None
        change = equations.solution(reduction)
        increment = Increment.of(state, change)
        refined = equations.refined(change, increment.opening, reduction)
        if refined is not change:
            increment = Increment.of(state, refined)
        slope = state.slope(increment)
        if not self._convex:  # there must be a minimum along the increment
            curvature = state.hessian([increment])[0, 0]
            if not (slope < 0.0 and curvature > 0.0):
                return None
        if state.function.wall.attractive:
            increments = [increment, *self._history]
            self._history = increments[: self._options.history]
            increment = combine(state, increments)
        if abs(slope) <= state.rounding:
            self._convex = False  # rounding errors of the energy hide its change
            return state.moved(increment, 1.0)
        length, new = line_search(state, increment)
        if new is not None and length < 0.5 and not self._convex:
            self._leave_out_negative_stiffness(state)
        elif length >= 1.0 and state.error < self._small:
            self._convex = False
        return new

    def _leave_out_negative_stiffness(self, state: EnergyState) -> None:
        self._convex = True
        self._small = _ATTRACTION_RESIDUAL * state.error


def combine(state: EnergyState, increments: list[Increment]) -> Increment:
    r"""Return the combination of increments with the least energy.

    With slopes :math:`s_i` and Hessian :math:`H`, scaled to a unit diagonal, the
    weights are :math:`-|H|^{-1} s`, where the eigenvalues of :math:`|H|` are the
    magnitudes of the eigenvalues of :math:`H`, and at least 0.003.
    """
    slopes = np.array([state.slope(increment) for increment in increments])
    hessian = state.hessian(increments)
    scale = 1.0 / np.sqrt(abs(np.diag(hessian)) + 1e-300)
    values, modes = np.linalg.eigh(scale[:, None] * hessian * scale)
    along = modes.T @ (scale * slopes) / np.maximum(abs(values), _MIN_CURVATURE)
    weights = -scale * (modes @ along)
    pairs = list(zip(weights.tolist(), increments, strict=True))
    return Increment(
        linear_combination([(w, increment.pressure) for w, increment in pairs]),
        linear_combination([(w, increment.opening) for w, increment in pairs]),
        sum(w * increment.height for w, increment in pairs),
    )


def line_search(
    state: EnergyState, increment: Increment
) -> tuple[float, EnergyState | None]:
    """Search for a length of at most one at which the energy has fallen.

    The slope must also have decreased to 30 %. The whole increment is tried first, as
    it is nearly always accepted. Then the length is bisected. Conditions of sufficient
    decrease, as in libraries, would fail: the energy along an increment may have
    several minima, and its rounding errors are large at the end.

    Returns
    -------
    length : float
        Length; zero if no length is found at which the energy falls.
    state : EnergyState or None
        State at this length; None if no length is found.
    """
    accepted = _MAX_SLOPE_RATIO * abs(state.slope(increment))
    best: tuple[float, EnergyState | None] = 0.0, None
    length, high = 1.0, 1.0
    for _ in range(_MAX_TRIALS):
        new = state.moved(increment, length)
        slope = new.slope(increment)
        falls = new.energy - state.energy <= state.rounding
        if falls and (slope <= accepted if length == 1.0 else abs(slope) <= accepted):
            return length, new
        if falls and slope < 0.0:
            best = length, new
        else:
            high = length
        length = (best[0] + high) / 2.0
        if high - best[0] < 0.05 * best[0]:
            break
    return best
