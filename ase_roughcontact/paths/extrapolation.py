"""Extrapolation of the pressure along a path, from which the next step starts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ase_roughcontact.contact import State
from ase_roughcontact.elasticity.lattice import Box

# Points of a window above which two earlier pressures take more memory than the 2 % of
# transforms are worth that they save, beyond the start from the last one.
_LARGEST = 4096 * 4096
# Largest distance of a target from the last one, in units of the last step.
_FARTHEST = 2.0


class _Point(NamedTuple):
    window: Box
    target: float
    pressure: np.ndarray
    height: float


class Extrapolation:
    """Linear extrapolation of pressure and height from the last two steps."""

    def __init__(self) -> None:
        self._points: list[_Point] = []

    def add(self, target: float, state: State, pressure: np.ndarray) -> None:
        """Keep a relaxed state.

        Parameters
        ----------
        target : float
            Load or height that was prescribed, or the time.
        state : State
        pressure : ndarray, shape (n, m)
            Of the wall.
        """
        if state.window.size > _LARGEST:
            return
        point = _Point(state.window, target, pressure, state.height)
        self._points = [*self._points[-1:], point]

    def start(self, window: Box, target: float) -> tuple[np.ndarray, float] | None:
        """Return pressure and height from which to start.

        Parameters
        ----------
        window : Box
        target : float

        Returns
        -------
        pressure : ndarray, shape (n, m)
            Also a tension, where a contact is lost.
        height : float
            None, in place of both, without two states of this window, or if the
            target is farther from the last one than twice the last step.
        """
        if any(point.window != window for point in self._points):
            self._points = []
        if len(self._points) < 2:
            return None
        first, last = self._points
        step = last.target - first.target
        if not abs(target - last.target) <= _FARTHEST * abs(step) or not step:
            return None
        part = (target - last.target) / step
        pressure = last.pressure + part * (last.pressure - first.pressure)
        if not pressure.any():
            return None
        return pressure, last.height + part * (last.height - first.height)
