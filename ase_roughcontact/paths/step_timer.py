"""Expected time of a step, from FFTs timed on this machine."""

from __future__ import annotations

import math
import time

import numpy as np

from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.interactions import Interaction

# Time of a step, in exact convolutions on the full grid.
_PAIRS_HARD, _PAIRS_REPULSIVE, _PAIRS_ATTRACTIVE = 150, 180, 320
# Time of a step with hardly any atoms (s).
_SHORTEST = 0.05
# Largest grid on which convolutions are timed; for larger ones the time is
# extrapolated as n log(n).
_TIMED_POINTS = 1024**2


class StepTimer:
    """Time of steps on grids of any size, from convolutions timed on this machine.

    Parameters
    ----------
    halfspace : HalfSpace
    wall : Interaction
    """

    def __init__(self, halfspace: HalfSpace, wall: Interaction) -> None:
        self._halfspace = halfspace
        self._pairs = _PAIRS_ATTRACTIVE if wall.attractive else _PAIRS_REPULSIVE
        if wall.hard:
            self._pairs = _PAIRS_HARD
        self._timed: dict[tuple[int, int], float] = {}

    def seconds(self, grid: tuple[int, int]) -> float:
        """Return the time of a step.

        Parameters
        ----------
        grid : (int, int)
            Shape of its FFT grid.

        Returns
        -------
        float
            Seconds.
        """
        points = math.prod(grid)
        scale = min(1.0, (_TIMED_POINTS / points) ** 0.5)
        timed = max(8, int(grid[0] * scale)), max(8, int(grid[1] * scale))
        if timed not in self._timed:
            self._timed[timed] = self._time_of_convolution(timed)
        size = math.prod(timed)
        ratio = points * math.log(points) / (size * math.log(size))
        return _SHORTEST + self._pairs * ratio * self._timed[timed]

    def _time_of_convolution(self, grid: tuple[int, int]) -> float:
        periodic = self._halfspace.periodic
        shape = grid if periodic else (grid[0] // 2, grid[1] // 2)
        halfspace = self._halfspace.resized(shape, self._halfspace.spacing)
        pressure, times = np.ones(shape), []
        for _ in range(3):
            start = time.perf_counter()
            halfspace.displacement(pressure)
            times.append(time.perf_counter() - start)
        return min(times)
