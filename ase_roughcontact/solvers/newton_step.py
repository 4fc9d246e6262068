r"""A step of Newton's method for a soft wall.

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
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.kernels import dot, dots, linear_combination, total
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.circulant import CirculantModel, covering_model
from ase_roughcontact.solvers.energy import ContactEnergy, EnergyState
from ase_roughcontact.solvers.indenter_height import carrying_height, supports_indenter
from ase_roughcontact.solvers.newton_equations import NewtonEquations, on_window
from ase_roughcontact.solvers.options import NewtonKrylovOptions

# Residual pressure, in contact moduli, below which the negative stiffness of attractive
# walls is included; and the part of the forces below which it is included again.
_ATTRACTION_RESIDUAL = 0.3
# Steps with the inverse of a wall that need not decrease the residual.
_WATCHDOG = 20
# Lower bound to the curvatures of a combination, relative to those of its increments.
_LEAST_CURVATURE = 0.003
# Slope at which a line search stops, relative to the initial one.
_REMAINING_SLOPE = 0.3
# Largest number of lengths that it tries.
_TRIALS = 40


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
        # whether the inverse is used, least norm of its residual, and steps since then
        self._inverse = contact.interaction.invertible
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
        if energy.support and not supports_indenter(energy, state):
            # lower the indenter to where the surface, held fixed, carries the load
            height = carrying_height(energy, state.opening, state.height)
            if height is None or height == state.height:
                return None
            return energy.reevaluated(state, height)
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

        If several steps have not decreased the residual: None, and the state linearised
        in the gaps, from which the energy is lowered.
        """
        if state.residual_norm == math.inf:
            state = energy.reevaluated(state, by_pressure=True)
        self._futile += 1
        if state.residual_norm < self._least_residual:
            self._least_residual, self._futile = state.residual_norm, 0
        equations = self._equations(energy, state)
        if self._futile > _WATCHDOG or not equations.solvable:
            self._inverse = False
            return None, energy.reevaluated(state)
        change = equations.solution(reduction)
        del equations  # its memory is needed
        held = state.stiffness > 0.0  # there is no pressure on other atoms
        pressure = (state.pressure + on_window(state, change)) * held
        height = state.height + float(change[-1])
        return energy.state(pressure, height, by_pressure=True), state

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
        if not equations.solvable:
            return None
        change = equations.solution(reduction)
        increment = Increment.of(energy, state, change)
        refined = equations.refined(change, increment.opening, reduction)
        if refined is not change:
            increment = Increment.of(energy, state, refined)
        slope = slope_along(energy, state, increment)
        if not self._convex:  # a minimum ahead?
            curvature = hessian_along(energy, state, [increment])[0, 0]
            if not (slope < 0.0 and curvature > 0.0):
                return None
        if abs(slope) <= state.rounding:
            self._convex = False  # too close for the energy to decide
            return _moved(energy, state, increment, 1.0)
        if energy.wall.attractive:
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


@dataclass(frozen=True)
class Increment:
    """Change of the pressure, the opening that it causes, and change of the height."""

    pressure: np.ndarray
    opening: np.ndarray
    height: float

    @classmethod
    def of(
        cls, energy: ContactEnergy, state: EnergyState, change: np.ndarray
    ) -> Increment:
        """Return the increment of a solution of `NewtonEquations`: one convolution."""
        pressure = on_window(state, change)
        return cls(pressure, energy.opening(pressure), float(change[-1]))


def _moved(
    energy: ContactEnergy, state: EnergyState, increment: Increment, length: float
) -> EnergyState:
    """Return the state after an increment times a length."""
    return energy.state(
        linear_combination([(1.0, state.pressure), (length, increment.pressure)]),
        state.height + length * increment.height,
        linear_combination([(1.0, state.opening), (length, increment.opening)]),
    )


def slope_along(
    energy: ContactEnergy, state: EnergyState, increment: Increment
) -> float:
    """Return the first derivative of the energy along an increment."""
    work = dot(state.residual, increment.opening)
    return -energy.area * work - increment.height * state.load_residual


def hessian_along(
    energy: ContactEnergy, state: EnergyState, increments: list[Increment]
) -> np.ndarray:
    """Return the second derivatives of the energy along increments, shape (k, k)."""
    spring = energy.spring_stiffness(state.height)
    result = np.empty((len(increments), len(increments)))
    for i, one in enumerate(increments):
        stressed = state.stiffness * (one.opening + one.height)
        force = total(stressed) + spring * one.height / energy.area
        before = increments[: i + 1]
        elastic = dots([(one.pressure, other.opening) for other in before])
        wall = dots([(stressed, other.opening) for other in before])
        for j, other in enumerate(before):
            curvature = elastic[j] + wall[j] + force * other.height
            result[i, j] = result[j, i] = energy.area * curvature
    return result


def combine(
    energy: ContactEnergy, state: EnergyState, increments: list[Increment]
) -> Increment:
    r"""Return the combination of increments with the least energy.

    With slopes :math:`s_i` and Hessian :math:`H`, scaled to a unit diagonal, the
    weights are :math:`-|H|^{-1} s`, where the eigenvalues of :math:`|H|` are the
    magnitudes of those of :math:`H`, and at least 0.003.
    """
    slopes = np.array(
        [slope_along(energy, state, increment) for increment in increments]
    )
    hessian = hessian_along(energy, state, increments)
    scale = 1.0 / np.sqrt(abs(np.diag(hessian)) + 1e-300)
    values, modes = np.linalg.eigh(scale[:, None] * hessian * scale)
    along = modes.T @ (scale * slopes) / np.maximum(abs(values), _LEAST_CURVATURE)
    weights = -scale * (modes @ along)
    pairs = list(zip(weights.tolist(), increments, strict=True))
    return Increment(
        linear_combination([(w, increment.pressure) for w, increment in pairs]),
        linear_combination([(w, increment.opening) for w, increment in pairs]),
        sum(w * increment.height for w, increment in pairs),
    )


def line_search(
    energy: ContactEnergy, state: EnergyState, increment: Increment
) -> tuple[float, EnergyState | None]:
    """Search for a length of at most one at which the energy has fallen.

    The slope must have decreased to 30 %, too. The whole increment is tried first, as
    it is nearly always accepted. Then the length is bisected: the energy along an
    increment may have several minima, and its rounding errors decide at the end, so
    that a library's conditions of sufficient decrease would fail.

    Returns
    -------
    length : float
        Zero if no length is found at which the energy falls.
    state : EnergyState or None
        State at this length.
    """
    accepted = _REMAINING_SLOPE * abs(slope_along(energy, state, increment))
    best: tuple[float, EnergyState | None] = 0.0, None
    length, high = 1.0, 1.0
    for _ in range(_TRIALS):
        new = _moved(energy, state, increment, length)
        slope = slope_along(energy, new, increment)
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
