"""Characteristic values of sliding paths: static friction, and energies of loops."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import FloatArray

# Distance of the ends of a closed loop, relative to the range of the path.
_CLOSED = 1e-3
# Relative change of the load below which a contact slides under the same one.
_SAME_LOAD = 1e-2


def static_friction(steps: Sequence[Any]) -> float:
    """Return the largest lateral force of the first slide.

    That is until the indenter turns back, or the load changes by 1 %, after the first
    step in which all atoms in contact slip. It is at most `largest_friction`, which it
    approaches: tractions of atoms that have just begun to slip are not yet parallel.

    Parameters
    ----------
    steps : sequence of SlidingStep

    Returns
    -------
    float
        eV/Å; NaN if in no step all atoms in contact slip.
    """
    slides = [s.slip_area > 0.0 and s.stick_area == 0.0 for s in steps]
    if not any(slides):
        return float("nan")
    start = end = slides.index(True)
    forces = np.array([[s.lateral_force_x, s.lateral_force_y] for s in steps])
    points = np.array([[s.lateral_x, s.lateral_y] for s in steps])
    onward = np.diff(points, axis=0) @ forces[start] >= 0.0
    loads = np.array([s.normal_force for s in steps])
    same = abs(loads - loads[start]) <= _SAME_LOAD * abs(loads[start])
    while end + 1 < len(steps) and onward[end] and same[end + 1]:
        end += 1
    return float(np.hypot(*forces[: end + 1].T).max())


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
