"""Friction law of the atoms of a window, at the pressures of a step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ase_roughcontact.interactions.friction import SLIP, FrictionLaw, bound_of

# Points and weights by which bounds are integrated over the slip of a step.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True, eq=False)
class LocalFriction:
    """Friction law of the atoms of a window, at the pressures of a step.

    Attributes
    ----------
    law : FrictionLaw
    pressure : ndarray, shape (n, m)
        Pressures of the atoms (pressure).
    contact : ndarray of bool, shape (n, m)
        Whether each atom is in contact.
    spacing : float
        Distance of the atoms (length).
    origin : (float, float)
        Position of the first atom from the indenter's axis (length).
    history : mapping of str to ndarray of shape (n, m)
        History of the surface at the start of the step; histories of the law that are
        not in it have their first values.
    """

    law: FrictionLaw
    pressure: np.ndarray
    contact: np.ndarray
    spacing: float
    origin: tuple[float, float]
    history: Mapping[str, np.ndarray] = field(default_factory=dict)

    def bounds(self, slipped: np.ndarray | float = 0.0) -> np.ndarray:
        """Return the largest magnitude of the traction of each atom.

        Parameters
        ----------
        slipped : ndarray, shape (n, m), or float
            Way that each atom has slipped in the step (length).

        Returns
        -------
        ndarray, shape (n, m)
            Bounds (pressure), at least zero; zero for atoms out of contact.

        Raises
        ------
        ValueError
            If `FrictionLaw.bound` does not return a number for each atom in contact.
        """
        values = np.asarray(bound_of(self.law, *self._arguments(slipped)), dtype=float)
        count = len(self._touching[0])
        if values.shape not in ((), (count,)) or np.isnan(values).any():
            slip = (
                "" if self.law.weakens else "; slip is known with histories = (SLIP,)"
            )
            raise ValueError(
                f"{type(self.law).__name__}.bound must return a number for each of the "
                f"{count} atoms in contact, got {values.size} with "
                f"{np.isnan(values).sum()} of NaN{slip}"
            )
        bounds = np.zeros(self.pressure.shape)
        bounds[self.contact] = np.maximum(values, 0.0)
        return bounds

    def mean_bounds(self, slipped: np.ndarray) -> np.ndarray:
        """Return the means of the bounds over the way that each atom has slipped."""
        parts = 0.5 * (1.0 + _POINTS)
        bounds = [self.bounds(part * slipped) for part in parts]
        return 0.5 * np.tensordot(_WEIGHTS, bounds, 1)

    def ended(self, slipped: np.ndarray) -> dict[str, np.ndarray]:
        """Return the histories of the law at the end of a step.

        Parameters
        ----------
        slipped : ndarray, shape (n, m)
            Way that each atom has slipped in the step (length).

        Returns
        -------
        dict of ndarray, shape (n, m)

        Raises
        ------
        ValueError
            If `FrictionLaw.evolved` leaves out a history.
        """
        arguments = self._arguments(slipped)
        values = dict(self.law.evolved(*arguments))
        if self.law.weakens:
            values[SLIP.name] = arguments[1]
        histories = {}
        for entry in self.law.histories:
            if entry.name not in values:
                raise ValueError(
                    f"{type(self.law).__name__}.evolved must return the history "
                    f"{entry.name!r}, got {', '.join(values) or 'none'}"
                )
            histories[entry.name] = np.full(self.pressure.shape, entry.entering)
            histories[entry.name][self.contact] = values[entry.name]
        return histories

    def slipped_further(self, slipped: np.ndarray) -> LocalFriction:
        """Return the friction after a part of a step, at the same pressures."""
        history = {**self.history, **self.ended(slipped)}
        return LocalFriction(
            self.law, self.pressure, self.contact, self.spacing, self.origin, history
        )

    @cached_property
    def _touching(self) -> tuple[Any, ...]:
        """Pressure, histories, and places along x and y of the atoms in contact."""
        contact = self.contact
        i, j = contact.nonzero()
        x, y = (o + self.spacing * k for o, k in zip(self.origin, (i, j), strict=True))
        history = {}
        for entry in self.law.histories:
            known = self.history.get(entry.name)
            if known is None:
                known = np.full(contact.shape, entry.first)
            history[entry.name] = known[contact]
        return self.pressure[contact], history, x, y

    def _arguments(self, slipped: np.ndarray | float) -> tuple[Any, ...]:
        """Return the arguments of `FrictionLaw.bound`."""
        pressure, history, x, y = self._touching
        slip = unknown = np.full(pressure.size, np.nan)
        if self.law.weakens:
            way = np.broadcast_to(slipped, self.contact.shape)[self.contact]
            slip = history[SLIP.name] + way
        return pressure, slip, unknown, np.nan, history, x, y
