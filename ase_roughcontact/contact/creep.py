r"""History of a viscoelastic contact: one pressure for each term of the creep series.

A creep compliance of several terms (see `elasticity.creep`) displaces the surface by

.. math:: u = -G * \left(p + \sum_k q_k\right), \qquad \theta_k \dot q_k = J_k p - q_k .

Over a time step with a pressure that is linear in time,
:math:`q_k' = e_k q_k + c_k p + d_k p'`. The first two terms are known before the step.
Their sum is kept in `State.history`, and its depth, the convolution with :math:`G`, in
`State.depths`; the surface is lowered by these depths in the step. The last term
increases the compliance of the solid by the factor :math:`1 + \sum_k d_k`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from ase_roughcontact.contact.history import HistoryEntry, declare
from ase_roughcontact.contact.state import State
from ase_roughcontact.elasticity.creep import Creep, CreepStep
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.elasticity.lattice import carried

#: Prefix of the names of the pressures ``q_k``.
CREEP_PRESSURE = declare(HistoryEntry("creep_pressure_", "eV/Å^3")).name
#: Rate of the pressure in the last time step.
PRESSURE_RATE = declare(HistoryEntry("pressure_rate", "eV/Å^3/s")).name
# Duration of a step, relative to a retardation time, below which means over the step
# are power series, as closed forms lose digits.
_MAX_SERIES_DURATION = 1e-3


def creep_pressures(history: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the pressures ``q_k`` of a history, by key."""
    return {k: q for k, q in history.items() if k.startswith(CREEP_PRESSURE)}


def check_past(state: State, creep: Creep | None) -> None:
    """Raise `ValueError` if a surface has the history of another solid."""
    if creep_pressures(state.history) and state.creep != creep:
        raise ValueError(
            f"the surface has crept in a solid with {state.creep or 'another series'}, "
            f"but this solid has {creep or 'no creep'}: use the same solid, or start "
            "from new atoms"
        )


def before_step(state: State, step: CreepStep) -> State:
    r"""Return the state from which a time step starts, with :math:`e_k q_k + c_k p`.

    Parameters
    ----------
    state : State
        State at the end of the last step.
    step : CreepStep
        Coefficients of the time step.

    Returns
    -------
    State
        State with the displacement that its pressure causes over the step.
    """
    aged = _changed(state, step.decay, step.old)
    if state.displacement is None:
        return aged
    return replace(aged, displacement=step.compliance * state.displacement)


def after_step(state: State, step: CreepStep) -> State:
    r"""Return a relaxed state with the history :math:`q_k'` at the end of the step.

    The displacement is the displacement of the instantaneous solid.
    """
    if state.displacement is not None:
        state = replace(state, displacement=state.displacement / step.compliance)
    return _changed(state, np.ones_like(step.new), step.new)


def with_depths(state: State, halfspace: HalfSpace) -> State:
    """Return a state with all depths; each missing depth costs one FFT pair.

    Parameters
    ----------
    state : State
        The state.
    halfspace : HalfSpace
        Half space of the instantaneous solid, on the window of the state.

    Returns
    -------
    State
        State with the depths of all pressures ``q_k``.
    """
    depths = dict(state.depths)
    for key, pressure in creep_pressures(state.history).items():
        if key not in depths:
            depths[key] = -np.asarray(halfspace.displacement(pressure), dtype=float)
    return replace(state, depths=depths)


def past_of(state: State) -> tuple[np.ndarray, np.ndarray]:
    """Return the sum of the pressures ``q_k`` and the sum of their depths."""
    keys, zeros = creep_pressures(state.history), np.zeros(state.window.shape)
    pressure = sum((state.history[key] for key in keys), zeros)
    return pressure, sum((state.depths[key] for key in keys), zeros)


def creep_energy(state: State, creep: Creep) -> float:
    r"""Return the energy stored by the pressures ``q_k``, per area of a cell.

    .. math:: \tfrac{1}{2} \sum_i \sum_k q_k\, G * q_k / J_k

    is stored in addition to the energy of the instantaneous solid under the present
    pressure.

    Parameters
    ----------
    state : State
        State at the end of a step, with displacement and depths.
    creep : Creep
        Creep compliance of the solid.

    Returns
    -------
    float
        Stored energy (energy per area).
    """
    energy = 0.0
    for k, compliance in enumerate(creep.compliances):
        key = _key(k)
        energy += float(np.sum(state.history[key] * state.depths[key])) / compliance
    return 0.5 * energy


def dissipation_rate(state: State, creep: Creep) -> float:
    r"""Return the power that a state dissipates per area of a cell.

    .. math:: \sum_i \left[\sum_k
              \frac{J_k p - q_k}{J_k \theta_k}\, G * (J_k p - q_k)
              + \phi\, p\, G * p\right]

    Parameters
    ----------
    state, creep
        See `creep_energy`.

    Returns
    -------
    float
        Dissipated power (energy per area and time).
    """
    terms = _dashpots(state, creep)
    return float(sum(rate * np.vdot(flow, depth) for rate, _, flow, depth in terms))


def dissipated_energy(
    before: State, after: State, creep: Creep, elapsed: float
) -> float:
    r"""Return the energy that a time step dissipates per area of a cell.

    This is the integral of `dissipation_rate`. It is exact for a pressure that is
    linear in time, where :math:`r_k = J_k p - q_k` changes as

    .. math:: r_k(t) = r_k + f_k(t) (r_k' - r_k), \qquad
              f_k(t) = \frac{1 - e^{-t/\theta_k}}{1 - e^{-\Delta t/\theta_k}} .

    Parameters
    ----------
    before, after : State
        States at the end of the last step and of this step, with displacement and
        depths.
    creep : Creep
        Creep compliance of the solid.
    elapsed : float
        Duration of the step, positive (time).

    Returns
    -------
    float
        Dissipated energy (energy per area).
    """
    energy = 0.0
    terms = zip(_dashpots(before, creep), _dashpots(after, creep), strict=True)
    for (factor, rate, old, old_depth), (_, _, new, new_depth) in terms:
        same = before.window == after.window
        kept = old if same else carried(old, before.window, after.window)
        pairs = (old, old_depth), (kept, new_depth), (new, new_depth)
        means = zip(_means(elapsed * rate), pairs, strict=True)
        energy += factor * sum(mean * np.vdot(*pair) for mean, pair in means)
    return float(elapsed * energy)


def _dashpots(
    state: State, creep: Creep
) -> Iterator[tuple[float, float, np.ndarray, np.ndarray]]:
    """Yield factor of the power, rate, pressure and depth of the pressure, by term.

    The pressures are ``r_k``; the last one is ``p`` if there is a flow.
    """
    pressure, depth = state.pressure, _depth(state)
    for k, (value, time) in enumerate(zip(creep.compliances, creep.times, strict=True)):
        flowing, sinking = value * pressure, value * depth
        flowing -= state.history[_key(k)]
        sinking -= state.depths[_key(k)]
        yield 1.0 / (value * time), 1.0 / time, flowing, sinking
    if creep.flow:
        yield creep.flow, 0.0, pressure, depth


def _means(x: float) -> tuple[float, float, float]:
    """Return the means of (1 - f)^2, 2 f (1 - f) and f^2 over a step.

    The duration x of the step is in units of the retardation time.
    """
    if x < _MAX_SERIES_DURATION:
        return (4.0 - x) / 12.0, 1.0 / 3.0, (4.0 + x) / 12.0
    reached, mean = -math.expm1(-x), -math.expm1(-x) / x
    first = (1.0 - mean) / reached
    second = (1.0 - 2.0 * mean - math.expm1(-2.0 * x) / (2.0 * x)) / reached**2
    return 1.0 - 2.0 * first + second, 2.0 * (first - second), second


def _key(term: int) -> str:
    return f"{CREEP_PRESSURE}{term + 1}"


def _changed(state: State, decay: np.ndarray, weights: np.ndarray) -> State:
    """Return a state with the history ``decay_k q_k + weight_k p``, and its depths.

    The displacement of the given state is the displacement of the instantaneous solid.
    """
    depth = None if state.displacement is None else _depth(state)
    history, depths = dict(state.history), {}
    for k, (kept, weight) in enumerate(zip(decay, weights, strict=True)):
        key = _key(k)
        new, old = weight * state.pressure, state.history.get(key)
        history[key] = new if old is None else kept * old + new
        if depth is not None and (old is None or key in state.depths):
            depths[key] = kept * state.depths.get(key, 0.0) + weight * depth
    return replace(state, history=history, depths=depths)


def _depth(state: State) -> np.ndarray:
    """Return the depth ``G * p`` on the window; the state must have a displacement."""
    if state.displacement is None:
        raise ValueError("the displacement of the state is not known")
    n, m = state.window.shape
    return -state.displacement[:n, :m]
