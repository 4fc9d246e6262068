"""Expected time of a step, from FFTs timed on this machine."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from functools import cache

import numpy as np

from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.interactions import Interaction

# Time of a step, in exact convolutions on the full grid.
_PAIRS = {"hard": 150, "soft": 180, "attractive": 320}
# Time of a step with hardly any atoms (s).
_SHORTEST = 0.05
# Side of the largest grid on which convolutions are timed; for larger ones the time is
# extrapolated as n log(n).
_TIMED_SIDE = 1024


def step_timer(
    halfspace: HalfSpace, wall: Interaction
) -> Callable[[tuple[int, int]], float]:
    """Return a function of the shape of an FFT grid: the time of a step on it (s)."""

    @cache
    def convolution(n: int, m: int) -> float:
        shape = (n, m) if halfspace.periodic else (n // 2, m // 2)
        timed = halfspace.resized(shape, halfspace.spacing)
        pressure, times = np.ones(shape), []
        for _ in range(3):
            start = time.perf_counter()
            timed.displacement(pressure)
            times.append(time.perf_counter() - start)
        return min(times)

    def seconds(grid: tuple[int, int]) -> float:
        points = math.prod(grid)
        scale = min(1.0, _TIMED_SIDE / math.sqrt(points))
        n, m = (max(8, int(side * scale)) for side in grid)
        ratio = points * math.log(points) / (n * m * math.log(n * m))
        return _SHORTEST + _PAIRS[wall.family] * ratio * convolution(n, m)

    return seconds
