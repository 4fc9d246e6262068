"""Our wall as a potential of Adhesion, so that all codes have the very same one."""

from __future__ import annotations

from typing import Any

import numpy as np
from Adhesion.Interactions import Potential
from Adhesion.System import SmoothContactSystem

from ase_roughcontact.interactions import Interaction


class Wall(Potential):
    """Evaluates only the atoms in range, which costs Adhesion the least."""

    def __init__(self, wall: Interaction) -> None:
        super().__init__()
        self.wall = wall

    def __repr__(self) -> str:
        return f"Wall({self.wall})"

    @property
    def r_min(self) -> float:
        """Gap of the minimum."""
        return self.wall.contact_distance

    r_infl = r_min

    def evaluate(
        self,
        gap: np.ndarray,
        potential: bool = True,
        gradient: bool = False,
        curvature: bool = False,
        mask: np.ndarray | None = None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Energy per area and its first and second derivative."""
        near = gap < self.wall.cutoff
        energy, slope, stiffness = np.zeros((3, *gap.shape))
        energy[near], pressure, stiffness[near] = self.wall.evaluate(gap[near])
        slope[near] = -pressure
        return energy, slope, stiffness


def system(halfspace: Any, surface: Any, wall: Interaction) -> SmoothContactSystem:
    """Adhesion's contact of a half space and a surface through our wall."""
    return SmoothContactSystem(halfspace, Wall(wall), surface)
