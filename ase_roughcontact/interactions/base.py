"""What every wall has to know, and the hard wall."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np

Profile = tuple[np.ndarray, np.ndarray, np.ndarray]


class Interaction(ABC):
    """What a wall has to know: a function of the gap, and its range.

    A potential of your own needs the three attributes and `evaluate`; with attributes
    that are not numbers or strings also `todict`.

    Attributes
    ----------
    cutoff : float
        Gap beyond which energy, pressure and stiffness are all zero.
    contact_distance : float
        Gap below which the wall repels; an atom closer than this is in contact.
    attractive : bool
        Whether the wall pulls at any gap.
    """

    cutoff: float
    contact_distance: float
    attractive: bool

    @abstractmethod
    def evaluate(self, gap: np.ndarray) -> Profile:
        """Energy, pressure and stiffness at the given gaps.

        It is called for some atoms at a time, and by several threads at once: keep
        nothing from one call to the next, and look at each gap alone.

        Parameters
        ----------
        gap : ndarray, any shape
            Local gaps (length), also negative ones.

        Returns
        -------
        energy, pressure, stiffness : ndarray, shape of `gap`
            ``V`` (energy per area), ``-V'`` (pressure) and ``V''`` (pressure per
            length).
        """

    def todict(self) -> dict:
        """Parameters as plain numbers and strings."""
        return {"kind": type(self).__name__, **vars(self)}


@dataclass(frozen=True)
class HardWall(Interaction):
    """Impenetrable wall: ``g >= 0, p >= 0, g p = 0``.

    Its pressure is a reaction, not a function of the gap: where the gap is open it
    is zero, and where the atoms overlap energy, pressure and stiffness are infinite.
    Only a solver that knows the constraint can relax it.
    """

    cutoff = 0.0
    contact_distance = 0.0
    attractive = False

    def evaluate(self, gap: np.ndarray) -> Profile:
        """Zero at every allowed gap, infinite at a negative one."""
        wall = np.where(np.asarray(gap, dtype=float) < 0.0, np.inf, 0.0)
        return wall, wall.copy(), wall.copy()

    def todict(self) -> dict:
        """Parameters as plain numbers and strings."""
        return {"kind": "hard"}
