"""Which steps of a path have a frame."""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

#: Which frames a trajectory keeps; see `Output`.
Keep: TypeAlias = Literal["thinned", "all", "last"]
KEPT = get_args(Keep)
# Largest number of frames of a trajectory that is thinned, beside the last one.
_MAX_FRAMES = 100


def has_frame(keep: str, step: int, last: int) -> bool:
    """Return whether a step has a frame if the path ends with another step.

    Parameters
    ----------
    keep : {"thinned", "all", "last"}
        "thinned": of a path of more than 100 steps every second, fourth, and so on, and
        the last one, so that 51 to 101 remain.
    step, last : int
        Numbers of steps, from zero.

    Returns
    -------
    bool
    """
    if step == last:
        return True
    return keep != "last" and step % _distance(keep, last) == 0


def number_of_frames(keep: str, steps: int) -> int:
    """Return the number of frames that a path of some steps has in the end."""
    if keep == "last" or steps < 2:
        return min(steps, 1)
    distance = _distance(keep, steps - 1)
    return 1 + (steps - 1 + distance - 1) // distance


def _distance(keep: str, last: int) -> int:
    """Return the distance of the steps that have a frame, a power of two."""
    distance = 1
    while keep == "thinned" and last // distance >= _MAX_FRAMES:
        distance *= 2
    return distance
