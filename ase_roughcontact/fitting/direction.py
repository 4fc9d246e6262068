"""Direction of measured heights: whether they increase away from the surface.

Where the format does not define it, it follows, for all segments of a file together,
from the order of the measurement: an approach moves towards the surface, a retraction
away from it, and points in one series turn where they are nearest. Points on one way
have their largest force nearest to the surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import median_filter

from ase_roughcontact._util.validation import FloatArray

# Smallest distance of a turn from both ends of a series, relative to the range of the
# heights.
_MIN_TURN = 0.1
# Number of points of a running median, which suppresses outliers.
_MEDIAN_POINTS = 3
# Smallest distance of the ends of a segment that has a direction, relative to the range
# of its heights.
_MIN_CHANGE = 0.5


@dataclass(frozen=True, eq=False)
class Heights:
    """Heights of the base in a segment, in the order of the file.

    Attributes
    ----------
    kind : str or None
        "approach", "hold", "retraction", or None.
    height, force : ndarray, shape (k,)
        Heights (Å), and forces in any unit.
    """

    kind: str | None
    height: FloatArray
    force: FloatArray


def increases_away(segments: Sequence[Heights]) -> bool:
    """Return whether the heights increase away from the surface.

    Parameters
    ----------
    segments : sequence of Heights
        The segments of one file.

    Returns
    -------
    bool
    """
    votes: set[bool | None] = set()
    for segment in segments:
        if segment.kind is None:
            votes.add(_by_turn(segment.height))
        elif segment.kind != "hold" and (falls := _falls(segment.height)) is not None:
            votes.add(falls == (segment.kind == "approach"))
    votes.discard(None)  # segments that run neither way
    if len(votes) == 1:
        return bool(votes.pop())
    return _by_force(segments)


def is_reversed(kind: str | None, distance: FloatArray) -> bool:
    """Return whether a segment was written against the order of the measurement.

    Parameters
    ----------
    kind : str or None
        Kind of the segment.
    distance : ndarray, shape (k,)
        Heights of the base, positive away from the surface.

    Returns
    -------
    bool
    """
    falls = _falls(distance)
    if kind not in ("approach", "retraction") or falls is None:
        return False
    return falls != (kind == "approach")


def _falls(height: FloatArray) -> bool | None:
    """Return whether heights fall from the first to the last; None for neither."""
    change = height[-1] - height[0] if len(height) else 0.0
    return bool(change < 0.0) if abs(change) > _MIN_CHANGE * np.ptp(height) else None


def _by_turn(height: FloatArray) -> bool | None:
    """Return the direction from where a series turns; None if it does not."""
    below = min(height[0], height[-1]) - height.min()
    above = height.max() - max(height[0], height[-1])
    if max(below, above) < _MIN_TURN * np.ptp(height):
        return None
    return bool(below > above)


def _by_force(segments: Sequence[Heights]) -> bool:
    """Return the direction from where the force is largest."""
    height = np.concatenate([segment.height for segment in segments])
    force = np.concatenate([segment.force for segment in segments])
    order = np.argsort(height)
    smooth = median_filter(force[order], _MEDIAN_POINTS, mode="nearest")
    nearest = height[order][int(np.argmax(smooth))]
    return bool(nearest <= 0.5 * (height.min() + height.max()))
