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
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ase_roughcontact._util.summary import Summarized
from ase_roughcontact.contact.history import HistoryEntry, declare
from ase_roughcontact.contact.state import State
from ase_roughcontact.elasticity.creep import Creep, CreepStep
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.elasticity.lattice import carried

#: Prefix of the names of the pressures ``q_k``.
CREEP_PRESSURE = declare(HistoryEntry("creep_pressure_", "eV/Å^3")).name
#: Prefixes of the names of the tractions ``q_k`` along x and y.
CREEP_TRACTIONS = tuple(
    declare(HistoryEntry(f"creep_traction_{axis}_", "eV/Å^3")).name for axis in "xy"
)
#: Rate of the pressure in the last time step.
PRESSURE_RATE = declare(HistoryEntry("pressure_rate", "eV/Å^3/s")).name
# Duration of a step, relative to a retardation time, below which means over the step
# are power series, as closed forms lose digits.
_MAX_SERIES_DURATION = 1e-3
# Part of the errors of successive steps that add up.
_ADDED_PART = 0.25


@dataclass(frozen=True, eq=False)
class CreepLoad(Summarized):
    """Pressures or tractions on a solid that creeps, and what each of them displaces.

    Attributes
    ----------
    present : ndarray
        Pressures or tractions p (pressure).
    depth : ndarray
        Displacement ``G * p`` of the instantaneous solid (length).
    past : sequence of ndarray
        Pressures or tractions ``q_k``, one for each term of the creep (pressure).
    past_depths : sequence of ndarray
        Displacements ``G * q_k`` (length).
    """

    present: np.ndarray
    depth: np.ndarray
    past: Sequence[np.ndarray] = ()
    past_depths: Sequence[np.ndarray] = ()

    @property
    def total_depth(self) -> np.ndarray:
        """Displacement by present and past (length)."""
        return sum(self.past_depths, self.depth)

    def held_depth(self, step: CreepStep | None) -> np.ndarray:
        """Return the displacement by the past at the end of a step (length)."""
        if step is None:
            return np.zeros(self.depth.shape)
        held = float(step.old.sum()) * self.depth
        for decay, depth in zip(step.decay, self.past_depths, strict=True):
            held += decay * depth
        return held

    def after(
        self, step: CreepStep | None, present: np.ndarray, depth: np.ndarray
    ) -> CreepLoad:
        """Return the load after a step over which it is linear in time."""
        if step is None:
            return CreepLoad(present, depth)

        def changed(
            old: np.ndarray, new: np.ndarray, past: Sequence[np.ndarray]
        ) -> list[np.ndarray]:
            factors = zip(step.decay, step.old, step.new, past, strict=True)
            return [e * q + c * old + d * new for e, c, d, q in factors]

        past = changed(self.present, present, self.past)
        depths = changed(self.depth, depth, self.past_depths)
        return CreepLoad(present, depth, past, depths)


class _Dashpot(NamedTuple):
    """Dashpot of the creep series under a load.

    Attributes
    ----------
    factor : float
        Dissipated power over the product of pressure and depth (1/time).
    rate : float
        Inverse of the retardation time; zero for the flow (1/time).
    pressure, depth : ndarray, shape (n, m)
        Pressure ``r_k``, or ``p`` for the flow, and the depth that it causes.
    """

    factor: float
    rate: float
    pressure: np.ndarray
    depth: np.ndarray


def creep_pressures(history: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the pressures ``q_k`` of a history, by key."""
    return {
        key: pressure
        for key, pressure in history.items()
        if key.startswith(CREEP_PRESSURE)
    }


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
    return stored_by_past(_load_of(state, creep), creep)


def stored_by_past(load: CreepLoad, creep: Creep) -> float:
    """Return the energy stored by the past of a load; see `creep_energy`."""
    energy = 0.0
    # the flow, if any, stores nothing
    for compliance, past, depth in zip(
        creep.compliances, load.past, load.past_depths, strict=False
    ):
        energy += float(np.sum(past * depth)) / compliance
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
    power = 0.0
    for dashpot in _dashpots(_load_of(state, creep), creep):
        power += dashpot.factor * np.vdot(dashpot.pressure, dashpot.depth)
    return float(power)


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
    old, new = _load_of(before, creep), _load_of(after, creep)
    if before.window == after.window:
        return dissipated_by(old, new, creep, elapsed)

    def on_window(values: np.ndarray) -> np.ndarray:
        return carried(values, before.window, after.window)

    return dissipated_by(old, new, creep, elapsed, on_window)


def dissipated_by(
    before: CreepLoad,
    after: CreepLoad,
    creep: Creep,
    elapsed: float,
    carry: Callable[[np.ndarray], np.ndarray] = np.asarray,
) -> float:
    """Return the energy that a step dissipates under a load; see `dissipated_energy`.

    Parameters
    ----------
    before, after : CreepLoad
        Loads at the start and at the end.
    creep, elapsed
        See `dissipated_energy`.
    carry : callable
        Function that puts pressures before the step on the atoms after it.
    """
    energy = 0.0
    dashpots = zip(_dashpots(before, creep), _dashpots(after, creep), strict=True)
    for old, new in dashpots:
        old_weight, mixed_weight, new_weight = _means(elapsed * old.rate)
        work = old_weight * np.vdot(old.pressure, old.depth)
        work += mixed_weight * np.vdot(carry(old.pressure), new.depth)
        work += new_weight * np.vdot(new.pressure, new.depth)
        energy += old.factor * work
    return float(elapsed * energy)


def _dashpots(load: CreepLoad, creep: Creep) -> Iterator[_Dashpot]:
    """Yield the dashpots of all terms, and of the flow if there is one."""
    terms = zip(
        creep.compliances, creep.times, load.past, load.past_depths, strict=False
    )
    for value, time, past, depth in terms:
        pressure = value * load.present - past
        yield _Dashpot(
            1.0 / (value * time), 1.0 / time, pressure, value * load.depth - depth
        )
    if creep.flow:
        yield _Dashpot(creep.flow, 0.0, load.present, load.depth)


def _load_of(state: State, creep: Creep) -> CreepLoad:
    """Return pressure and past of a state, with displacement and depths."""
    keys = [_key(k) for k in range(creep.terms)]
    past = [state.history[key] for key in keys]
    depths = [state.depths[key] for key in keys]
    return CreepLoad(state.pressure, _depth(state), past, depths)


def interpolation_error(
    creep: Creep, elapsed: float, change: float, bend: float
) -> float:
    r"""Return the error of the past by taking a pressure as linear in time in a step.

    .. math:: \epsilon = \sum_k J_k\, \kappa(\Delta t/\theta_k)\, n_k\, b, \qquad
              \kappa(x) = \frac{x}{12 + 2 x^2}, \qquad
              n_k = \max\left[1, \tfrac14 \min\left(\frac{\theta_k}{\Delta t},
              \frac{c}{b}\right)\right] ,

    for the change c and the bend b. The errors of :math:`n_k` successive steps add up
    while the pressures bend and the surface remembers.

    Parameters
    ----------
    creep : Creep
        Creep compliance of the solid.
    elapsed : float
        Duration of the step, positive (time).
    change : float
        Sum of the magnitudes of the changes of the pressure over the step (pressure).
    bend : float
        Sum of the magnitudes of its second derivatives, times the square of the
        duration (pressure).

    Returns
    -------
    float
        Error of the pressures ``q_k``, summed (pressure).
    """
    steps = change / bend if bend else 0.0  # over which the pressures bend
    x = elapsed / np.array(creep.times)
    repeated = np.maximum(_ADDED_PART * np.minimum(1.0 / x, steps), 1.0)
    weights = np.array(creep.compliances) * x / (12.0 + 2.0 * x**2)
    weight = float(weights @ repeated)
    weight += creep.flow * elapsed / 12.0 * max(_ADDED_PART * steps, 1.0)
    return weight * bend


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
