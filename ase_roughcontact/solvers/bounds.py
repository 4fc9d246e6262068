"""Pressures between zero and the hardness, with a given sum."""

from __future__ import annotations

import numpy as np

# Relative error of a sum that is accepted, and largest number of steps towards it.
_ROUNDING, _STEPS = 1e-14, 200


def clip_to_sum(values: np.ndarray, total: float, limit: float) -> np.ndarray:
    """Return the pressure ``clip(values + shift, 0, limit)`` whose sum is given.

    The shift is found by Newton's method, and by bisection where that leaves the
    bracket.

    Parameters
    ----------
    values : ndarray, shape (n, m)
    total : float
        Between zero and the limit times the number of values.
    limit : float
        Positive.

    Returns
    -------
    ndarray, shape (n, m)
    """
    values = values.astype(float) - values.max()  # so that small sums are exact, too
    low, high = 0.0, limit - float(values.min())
    shift = low
    for _ in range(_STEPS):
        clipped = np.clip(values + shift, 0.0, limit)
        missing = total - float(clipped.sum())
        if abs(missing) <= _ROUNDING * total:
            break
        low, high = (shift, high) if missing > 0.0 else (low, shift)
        free = np.count_nonzero((clipped > 0.0) & (clipped < limit))
        shift += missing / free if free else np.inf
        if not low <= shift <= high:
            shift = 0.5 * (low + high)
    return clipped


def with_sum(
    pressure: np.ndarray, total: float, limit: float, push: np.ndarray
) -> np.ndarray:
    """Return a pressure changed to a given sum.

    Values between the bounds are moved towards one of them. If these do not suffice,
    all values change; see `clip_to_sum`.

    Parameters
    ----------
    pressure : ndarray, shape (n, m)
        Between zero and the limit.
    total, limit : float
        See `clip_to_sum`.
    push : ndarray, shape (n, m)
        Added to the pressure if all values change: large where they are to rise first.

    Returns
    -------
    ndarray, shape (n, m)
    """
    missing = total - float(pressure.sum())
    share = limit - pressure if missing > 0.0 else pressure.copy()
    share *= (pressure > 0.0) & (pressure < limit)
    available = float(share.sum())
    if abs(missing) > available:
        return clip_to_sum(pressure + push, total, limit)
    return pressure + missing / available * share if available else pressure
