r"""The energy along increments of pressure and height, and steps that lower it.

An increment :math:`(x, G x, z)` contains the opening :math:`G x` of the gap, so that
slopes and curvatures of the energy along it (see `energy`) cost no convolution:

.. math:: s = -a_0^2\, r \cdot G x - F z, \qquad
    H_{ij} = a_0^2 \left[x_i \cdot G x_j
    + \sum V'' (G x_i + z_i)(G x_j + z_j)\right] + U'' z_i z_j .
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.kernels import dot, dots, linear_combination, total
from ase_roughcontact.solvers.energy import ContactEnergy, EnergyState

# Lower bound to the curvatures of a combination, relative to those of its increments.
_LEAST_CURVATURE = 0.003
# Slope at which a line search stops, relative to the initial one.
_REMAINING_SLOPE = 0.3
# Largest number of lengths that it tries.
_TRIALS = 40


@dataclass(frozen=True)
class Increment:
    """Change of the pressure, the opening that it causes, and change of the height."""

    pressure: np.ndarray
    opening: np.ndarray
    height: float

    @classmethod
    def combination(
        cls, weights: list[float], increments: list[Increment]
    ) -> Increment:
        """Return the sum of increments times weights."""
        pairs = list(zip(weights, increments, strict=True))
        return cls(
            linear_combination([(w, increment.pressure) for w, increment in pairs]),
            linear_combination([(w, increment.opening) for w, increment in pairs]),
            sum(w * increment.height for w, increment in pairs),
        )


def moved(
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
    return Increment.combination(weights.tolist(), increments)


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
        new = moved(energy, state, increment, length)
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
