"""Characteristic values of sliding paths: static friction, and energies of loops."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import FloatArray

# Distance of the ends of a closed loop, relative to the range of the path.
_CLOSED = 1e-3


def static_friction(steps: Sequence[Any]) -> float:
    """Return the largest lateral force until all atoms in contact slip.

    Parameters
    ----------
    steps : sequence of SlidingStep

    Returns
    -------
    float
        eV/Å; NaN if in no step all atoms in contact slip. The smaller the steps, the
        smaller its error.
    """
    forces = [np.hypot(s.lateral_force_x, s.lateral_force_y) for s in steps]
    for number, step in enumerate(steps):
        if step.slip_area > 0.0 and step.stick_area == 0.0:
            return float(max(forces[: number + 1]))
    return float("nan")


def loop_energies(steps: Sequence[Any]) -> FloatArray:
    """Return the energies that are lost in closed loops of the lateral displacement.

    Parameters
    ----------
    steps : sequence of SlidingStep
        Along a line, there and back.

    Returns
    -------
    ndarray, shape (loops,)
        From each turning point to the next one at the same displacement (eV).

    Raises
    ------
    ValueError
        If there are no steps.
    """
    if not len(steps):
        raise ValueError("a loop needs the steps of a sliding path, got none")
    points = np.array([[s.lateral_x, s.lateral_y] for s in steps])
    points -= points[0]
    farthest = points[np.hypot(*points.T).argmax()]
    along = points @ farthest / (np.hypot(*farthest) or 1.0)
    ends = turning_points(along)
    closed = _CLOSED * np.ptp(along)
    return np.array(
        [
            steps[b].dissipated_energy - steps[a].dissipated_energy
            for a, b in zip(ends, ends[2:], strict=False)
            if abs(along[b] - along[a]) <= closed
        ]
    )


def turning_points(values: FloatArray) -> list[int]:
    """Return the first index, those after which values turn back, and the last one."""
    ways = np.sign(np.diff(values))
    moves = np.flatnonzero(ways).tolist()
    turns = [a + 1 for a, b in pairwise(moves) if ways[a] != ways[b]]
    return [0, *turns, len(values) - 1]
