"""Checks of numbers given by the user, with messages that help."""

from __future__ import annotations

import math
import operator
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]

# Points of a grid along x or y, at most: more are beyond any memory.
_WIDEST = 10**9
_NUMBERS = (int, float, np.integer, np.floating)


def _number(value: Any) -> bool:
    if isinstance(value, bool) or not isinstance(value, _NUMBERS):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        return False


def positive(**values: Any) -> None:
    """Raise `ValueError` for a value that is not a finite number above zero."""
    for name, value in values.items():
        if not (_number(value) and value > 0):
            raise ValueError(f"{name} must be a finite number > 0, got {value!r}")


def nonnegative(**values: Any) -> None:
    """Raise `ValueError` for a value that is not a finite number, zero or above."""
    for name, value in values.items():
        if not (_number(value) and value >= 0):
            raise ValueError(f"{name} must be a finite number >= 0, got {value!r}")


def finite(**values: Any) -> None:
    """Raise `ValueError` for a value that is not a finite number."""
    for name, value in values.items():
        if not _number(value):
            raise ValueError(f"{name} must be a finite number, got {value!r}")


def positive_array(name: str, value: Any) -> FloatArray:
    """Return numbers as an array, or raise `ValueError` unless all are above zero."""
    array = _float_array(name, value)
    if not np.all(np.isfinite(array) & (array > 0)):
        raise ValueError(f"{name} must be finite and > 0, got {value!r}")
    return array


def nonnegative_array(name: str, value: Any) -> FloatArray:
    """Return numbers as an array, or raise `ValueError` unless all are >= 0."""
    array = _float_array(name, value)
    if not np.all(np.isfinite(array) & (array >= 0)):
        raise ValueError(f"{name} must be finite and >= 0, got {value!r}")
    return array


def finite_array(name: str, value: Any) -> FloatArray:
    """Return numbers as an array, or raise `ValueError` unless all are finite."""
    array = _float_array(name, value)
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name} must be finite, got {value!r}")
    return array


def _float_array(name: str, value: Any) -> FloatArray:
    try:
        given = np.asarray(value)
        if given.dtype.kind not in "iufO":  # NumPy takes words and truth for numbers
            raise TypeError(f"{given.dtype} is no real number")
        return given.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(
            f"{name} must be a number or an array of them, got {value!r}"
        ) from error


def height_array(heights: Any) -> FloatArray:
    """Return a copy of a map of heights, or raise `ValueError`."""
    array = np.asarray(heights)
    if array.ndim != 2 or not array.size or array.dtype.kind not in "iuf":
        raise ValueError(
            "heights must be a two-dimensional array of real numbers, got shape "
            f"{array.shape} of {array.dtype}"
        )
    bad = int(array.size - np.isfinite(array).sum())
    if bad:
        raise ValueError(
            f"heights must be finite, got {bad} values that are nan or infinite"
        )
    return array.astype(np.float64)


def integer(name: str, value: Any, least: int) -> int:
    """Return `value` as an int, or raise `ValueError`."""
    try:
        number = operator.index(value)
    except TypeError:
        number = least - 1
    if number < least:
        raise ValueError(f"{name} must be an integer >= {least}, got {value!r}")
    return number


def grid_shape(shape: Any) -> tuple[int, int]:
    """Return `shape` as a pair of ints, or raise `ValueError`."""
    try:
        n, m = shape
        whole = n == int(n) >= 1 and m == int(m) >= 1
    except (TypeError, ValueError, OverflowError):
        whole = False
    if not whole:
        raise ValueError(f"shape must be two whole numbers >= 1, got {shape!r}")
    if max(n, m) > _WIDEST:
        raise ValueError(f"shape must be at most {_WIDEST} points wide, got {shape!r}")
    return int(n), int(m)


def window(
    shape: Any, spacing: Any, origin: Any
) -> tuple[tuple[int, int], float, tuple[float, float]]:
    """Return a grid to sample heights on as plain numbers, or raise `ValueError`."""
    positive(spacing=spacing)
    try:
        x, y = origin
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"origin must be two numbers (x, y), got {origin!r}"
        ) from error
    finite(origin_x=x, origin_y=y)
    return grid_shape(shape), float(spacing), (float(x), float(y))


def surface(**values: Any) -> None:
    """Raise `ValueError` for a value that has no heights."""
    for name, value in values.items():
        if isinstance(value, type) or not callable(getattr(value, "heights", None)):
            raise ValueError(
                f"{name} must be a surface with a method heights, got {value!r}"
            )


def unknown(word: str, known: Sequence[str], what: str) -> str:
    """Message for a word that is not known, with the nearest one that is."""
    near = get_close_matches(word, known, n=1, cutoff=0.0)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return f"unknown {what} {word!r}{hint} Known: {', '.join(known) or 'none'}"


def lookup(name: Any, choices: Mapping[str, Any], what: str) -> Any:
    """Return the choice of a name, or raise `ValueError` with the closest name."""
    if name not in choices:
        raise ValueError(unknown(str(name), list(choices), what))
    return choices[name]
