"""Pressures between zero and the hardness, with a given sum."""

from __future__ import annotations

import math

import numpy as np

#: Relative rounding error of a sum of pressures, or of a pressure at the limit.
PRESSURE_ROUNDING = 1e-14


def clip_to_sum(values: np.ndarray, total: float, limit: float) -> np.ndarray:
    """Return the pressure ``clip(values + shift, 0, limit)`` with a given sum.

    Newton's method finds the shift. A step of bisection replaces a step of Newton's
    method that ends outside of the bracket, or follows one that has not halved the
    missing sum.

    Parameters
    ----------
    values : ndarray, shape (n, m)
        Values before the shift (pressure).
    total : float
        Sum, between zero and the limit times the number of values (pressure).
    limit : float
        Largest pressure, positive.

    Returns
    -------
    ndarray, shape (n, m)
        Pressures with this sum.
    """
    values = values.astype(float) - values.max()  # small sums are exact then
    low, high = 0.0, limit - float(values.min())
    shift, last = 0.5 * high, math.inf
    while low < shift < high:
        clipped = _clipped(values, shift, limit)
        missing = total - float(clipped.sum())
        if abs(missing) <= PRESSURE_ROUNDING * total:
            return clipped
        low, high = (shift, high) if missing > 0.0 else (low, shift)
        free = np.count_nonzero((clipped > 0.0) & (clipped < limit))
        shift += missing / free if free else np.inf
        if not low < shift < high or abs(missing) > 0.5 * last:
            shift = 0.5 * (low + high)
        last = abs(missing)
    # no number is between the ends of the bracket: interpolate
    below, above = (_clipped(values, end, limit) for end in (low, high))
    lower = float(below.sum())
    part = (total - lower) / (float(above.sum()) - lower)
    return np.minimum(below + part * (above - below), limit)


def _clipped(values: np.ndarray, shift: float, limit: float) -> np.ndarray:
    """Return the shifted values between zero and the limit, rounded to the limit."""
    clipped = np.clip(values + shift, 0.0, limit)
    clipped[clipped >= (1.0 - PRESSURE_ROUNDING) * limit] = limit
    return clipped


def with_sum(
    pressure: np.ndarray, total: float, limit: float, push: np.ndarray
) -> np.ndarray:
    """Return a pressure changed to a given sum.

    Values between the bounds are moved towards one of the bounds. If these values do
    not suffice, all values change; see `clip_to_sum`. Without a limit, the pressure is
    scaled.

    Parameters
    ----------
    pressure : ndarray, shape (n, m)
        Pressures between zero and the limit, which are overwritten.
    total, limit : float
        Sum and largest pressure, see `clip_to_sum`; the limit may be infinity.
    push : ndarray, shape (n, m)
        Pressure that is added if all values change, large where values rise first. It
        is not used without a limit.

    Returns
    -------
    ndarray, shape (n, m)
        Pressures with this sum.
    """
    if limit == math.inf:
        pressure *= total / pressure.sum()
        return pressure
    missing = total - float(pressure.sum())
    if abs(missing) <= PRESSURE_ROUNDING * total:
        return pressure
    share = limit - pressure if missing > 0.0 else pressure.copy()
    share *= (pressure > 0.0) & (pressure < limit)
    available = float(share.sum())
    if abs(missing) > available:
        return clip_to_sum(pressure + push, total, limit)
    return pressure + missing / available * share
