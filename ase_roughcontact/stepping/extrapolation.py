"""Extrapolation of the pressure along a path, from which the next step starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ase_roughcontact.contact import State
from ase_roughcontact.contact.state import EarlierState
from ase_roughcontact.elasticity.lattice import Box

# Largest number of points of a window for which earlier pressures are kept: in larger
# windows they save 2 % of the transforms, which is not worth their memory.
_MAX_POINTS = 4096 * 4096
# Largest distance of a target from the last one, in units of the last step.
_MAX_RELATIVE_DISTANCE = 2.0


def with_earlier(state: State, target: float, pressure: np.ndarray) -> State:
    """Return a relaxed state, kept in its own `earlier` for the next extrapolation.

    Parameters
    ----------
    state : State
    target : float
        Load or height that was prescribed, or the time.
    pressure : ndarray, shape (n, m)
        Pressure of the wall.

    Returns
    -------
    State
        The state, without earlier ones on a window that is too large for them.
    """
    if state.window.size > _MAX_POINTS:
        return state
    last = EarlierState(target, state.window, pressure, state.height)
    return replace(state, earlier=(*state.earlier[-1:], last))


def extrapolated(
    earlier: tuple[EarlierState, ...], window: Box, target: float
) -> tuple[np.ndarray, float] | None:
    """Return pressure and height on the line through two earlier states.

    Parameters
    ----------
    earlier : tuple of EarlierState
        Relaxed states of the last steps, in order.
    window : Box
        Window of the step.
    target : float
        Load, height or time of the step.

    Returns
    -------
    pressure : ndarray, shape (n, m)
        Extrapolated pressure; negative where a contact is lost.
    height : float
        None, in place of both, without two states of this window, or if the target is
        farther from the last one than twice the last step.
    """
    if len(earlier) < 2 or any(each.window != window for each in earlier):
        return None
    first, last = earlier
    step = last.target - first.target
    if not step or not abs(target - last.target) <= _MAX_RELATIVE_DISTANCE * abs(step):
        return None
    part = (target - last.target) / step
    pressure = last.pressure + part * (last.pressure - first.pressure)
    if not pressure.any():
        return None
    return pressure, last.height + part * (last.height - first.height)
