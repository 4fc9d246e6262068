"""The hard wall."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact.interactions.base import Interaction, Profile


@dataclass(frozen=True)
class HardWall(Interaction):
    """Impenetrable wall: ``g >= 0, p >= 0, g p = 0``.

    The pressure is the reaction to the constraint, not a function of the gap: it needs
    a solver for constraints, `ActiveSet`.
    """

    kind = "hard"
    hard = True
    cutoff = 0.0
    contact_distance = 0.0
    work_of_adhesion = 0.0
    attraction_range = 0.0

    def evaluate(self, gap: np.ndarray) -> Profile:
        """Return zero at gaps that are allowed, and infinity at negative ones.

        Parameters
        ----------
        gap : ndarray, any shape
            Local gaps (length).

        Returns
        -------
        energy, pressure, stiffness : ndarray, shape of `gap`
        """
        wall = np.where(np.asarray(gap, dtype=float) < 0.0, np.inf, 0.0)
        return wall, wall.copy(), wall.copy()
