"""Extrapolation of the pressure along a path, from which the next step starts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ase_roughcontact.contact import Contact, ContactState
from ase_roughcontact.elasticity.halfspace import HalfSpace

# Largest distance of a target from the last one, in units of the last step.
_FARTHEST = 2.0


class _Point(NamedTuple):
    halfspace: HalfSpace
    target: float
    pressure: np.ndarray
    height: float


class Extrapolation:
    """Linear extrapolation of pressure and height from the last two steps.

    Walls with attraction are left out: their state depends on the start.
    """

    def __init__(self) -> None:
        self._points: list[_Point] = []

    def add(
        self, contact: Contact, target: float, state: ContactState, height: float
    ) -> None:
        """Keep a relaxed state.

        Parameters
        ----------
        contact : Contact
        target : float
            Load or height that was prescribed.
        state : ContactState
        height : float
            Of the indenter.
        """
        if not contact.interaction.attractive:
            point = _Point(contact.halfspace, target, state.pressure, height)
            self._points = [*self._points[-1:], point]

    def start(self, contact: Contact, target: float) -> tuple[np.ndarray, float] | None:
        """Return pressure and height from which to start.

        Parameters
        ----------
        contact : Contact
        target : float

        Returns
        -------
        pressure : ndarray, shape (n, m)
            Not negative.
        height : float
            None, in place of both, without two states of this half space, or if the
            target is farther from the last one than twice the last step.
        """
        if any(point.halfspace is not contact.halfspace for point in self._points):
            self._points = []  # the window was exchanged
        if len(self._points) < 2:
            return None
        first, last = self._points
        step = last.target - first.target
        if not abs(target - last.target) <= _FARTHEST * abs(step) or not step:
            return None
        part = (target - last.target) / step
        pressure = last.pressure + part * (last.pressure - first.pressure)
        np.maximum(pressure, 0.0, out=pressure)
        if not pressure.any():
            return None
        return pressure, last.height + part * (last.height - first.height)
