"""Checks of arguments, with errors that give the expected and the given value."""

from __future__ import annotations

import math
import operator
import re
import reprlib
from collections.abc import Callable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, TypeAlias
from unicodedata import normalize

import numpy as np
from numpy.typing import NDArray

FloatArray: TypeAlias = NDArray[np.float64]
#: Number of points along x and y.
Shape: TypeAlias = tuple[int, int]
#: Position (x, y).
Point: TypeAlias = tuple[float, float]

#: Largest magnitude of a number in a file; powers of it do not overflow.
LARGEST = 1e30
# Largest number of grid points along x or y: more do not fit into any memory.
_MAX_POINTS = 10**9
# Types of numbers.
_NUMBERS = (int, float, np.integer, np.floating)
# Smallest similarity of a known name that is suggested for an unknown one.
_MIN_SIMILARITY = 0.6
# Beginning of a number with a unit in a text.
_QUANTITY = re.compile(r"\s*[-+]?[\d.]+(e[-+]?\d+)?\s*[^\W\d_]", re.IGNORECASE)
# Representation of values in messages, shortened.
_shortened = reprlib.Repr()
_shortened.maxstring = _shortened.maxother = _shortened.maxlong = 100


def shown(value: Any) -> str:
    """Return a value as text for a message, shortened if it is long."""
    return _shortened.repr(value)


def _number(value: Any) -> bool:
    """Return whether a value is a finite number."""
    if isinstance(value, bool) or not isinstance(value, _NUMBERS):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # an integer that is too large for a float
        return False


def positive(**values: Any) -> None:
    """Raise `ValueError` for a value that is not a finite number > 0."""
    _check(values, "a finite number > 0", lambda value: value > 0)


def nonnegative(**values: Any) -> None:
    """Raise `ValueError` for a value that is not a finite number >= 0."""
    _check(values, "a finite number >= 0", lambda value: value >= 0)


def finite(**values: Any) -> None:
    """Raise `ValueError` for a value that is not a finite number."""
    _check(values, "a finite number", lambda value: True)


def boolean(**values: Any) -> None:
    """Raise `ValueError` for a value that is neither true nor false."""
    for name, value in values.items():
        if not isinstance(value, (bool, np.bool_)):
            raise ValueError(f"{name} must be true or false, got {shown(value)}")


def check_poisson(**values: Any) -> None:
    """Raise `ValueError` for a value that can't be a Poisson's ratio."""
    kind = "above -1 and at most 1/2"
    _check(values, kind, lambda value: -1.0 < value <= 0.5)


def _check(values: dict[str, Any], kind: str, holds: Callable[[Any], bool]) -> None:
    for name, value in values.items():
        if not (_number(value) and holds(value)):
            raise ValueError(
                f"{name} must be {kind}, got {shown(value)}{_advice_on(value)}"
            )


def _advice_on(value: Any) -> str:
    """Return the advice for a number with a unit in a text, as in scene files."""
    if isinstance(value, str) and _QUANTITY.match(value):
        return ": give a number in units of ASE (Å, eV), as in 30 * nm"
    return ""


def instance_of(kind: type | tuple[type, ...], **values: Any) -> None:
    """Raise `TypeError` for a value that is not an instance of the given classes."""
    kinds = kind if isinstance(kind, tuple) else (kind,)
    for name, value in values.items():
        if not isinstance(value, kinds):
            names = " or ".join(each.__name__ for each in kinds)
            article = "an" if names[0] in "AEIOUaeiou" else "a"
            raise TypeError(f"{name} must be {article} {names}, got {shown(value)}")


def function(**values: Any) -> None:
    """Raise `TypeError` for a value that can't be called."""
    for name, value in values.items():
        if not callable(value):
            raise TypeError(f"{name} must be callable, got {shown(value)}")


def one_of(known: Sequence[str], **values: Any) -> None:
    """Raise `ValueError` for a value that is not one of two or more known words."""
    for name, value in values.items():
        if not (isinstance(value, str) and value in known):
            *first, last = map(repr, known)
            words = f"{', '.join(first)} or {last}"
            raise ValueError(f"{name} must be {words}, got {shown(value)}")


def check_options(options: Any) -> None:
    """Raise `ValueError` if a field of a dataclass is not a number or infinity."""
    for name, value in vars(options).items():
        if not (
            _number(value) or (isinstance(value, float) and abs(value) == math.inf)
        ):
            raise ValueError(f"{name} must be a number, got {shown(value)}")


def positive_array(name: str, value: Any) -> FloatArray:
    """Return numbers as an array; raise `ValueError` if one is not finite and > 0."""
    return _checked_array(name, value, "finite and > 0", lambda array: array > 0)


def nonnegative_array(name: str, value: Any) -> FloatArray:
    """Return numbers as an array; raise `ValueError` if one is not finite and >= 0."""
    return _checked_array(name, value, "finite and >= 0", lambda array: array >= 0)


def finite_array(name: str, value: Any) -> FloatArray:
    """Return numbers as an array; raise `ValueError` if one is not finite."""
    return _checked_array(name, value, "finite", np.isfinite)


def increasing_array(name: str, value: Any) -> FloatArray:
    """Return edges of bins as an array; raise `ValueError` if they do not increase."""
    edges = finite_array(name, value)
    if edges.ndim != 1 or len(edges) < 2 or not (np.diff(edges) > 0.0).all():
        raise ValueError(
            f"edges of {name} must be two or more increasing numbers, got {value!r}"
        )
    return edges


def _checked_array(
    name: str, value: Any, kind: str, holds: Callable[[FloatArray], Any]
) -> FloatArray:
    try:
        array = unmasked(value)
        if array.dtype.kind not in "iufO":  # strings and bools are refused
            raise TypeError(f"{array.dtype} is not a real number")
        array = array.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(
            f"{name} must be a number or an array of them, got {shown(value)}"
            f"{_advice_on(value)}"
        ) from error
    if not np.all(np.isfinite(array) & holds(array)):
        raise ValueError(f"{name} must be {kind}, got {shown(value)}")
    return array


def unmasked(values: Any) -> NDArray[Any]:
    """Return values as an array, with NaN in place of masked values."""
    if np.ma.is_masked(values):
        return values.astype(np.float64).filled(np.nan)
    return np.asarray(values)


def check_matrix(array: np.ndarray) -> None:
    """Raise `ValueError` if an array of heights is not a matrix of real numbers."""
    if array.ndim != 2 or not array.size or array.dtype.kind not in "iuf":
        raise ValueError(
            "heights must be a two-dimensional array of real numbers, got shape "
            f"{array.shape} of {array.dtype}"
        )


def height_array(heights: Any) -> FloatArray:
    """Return a copy of a height map; raise `ValueError` for a wrong shape or type."""
    array = unmasked(heights)
    check_heights(array)
    return array.astype(np.float64)


def check_heights(array: np.ndarray) -> None:
    """Raise `ValueError` if an array is not a matrix of finite real numbers.

    Numbers above `LARGEST` are refused, too.
    """
    check_matrix(array)
    wrong = int(array.size - np.count_nonzero(np.abs(array) <= LARGEST))
    if wrong:
        raise ValueError(
            f"heights must be finite, got {wrong} values that are nan, infinite, "
            f"above {LARGEST:g} or masked: HeightMap.from_topography interpolates "
            "missing points"
        )


def integer(name: str, value: Any, least: int) -> int:
    """Return an integer as int; raise `ValueError` if it is below the least value."""
    if isinstance(value, (bool, np.ndarray)):
        value = None
    try:
        number = operator.index(value)
    except TypeError:
        number = least - 1
    if number < least:
        raise ValueError(f"{name} must be an integer >= {least}, got {shown(value)}")
    return number


def grid_shape(shape: Any) -> tuple[int, int]:
    """Return a shape as two ints; raise `ValueError` if they are not >= 1."""
    try:
        n, m = shape
        valid = n == int(n) >= 1 and m == int(m) >= 1
    except (TypeError, ValueError, OverflowError):
        valid = False
    if not valid:
        raise ValueError(f"shape must be two whole numbers >= 1, got {shown(shape)}")
    if max(n, m) > _MAX_POINTS:
        raise ValueError(
            f"shape must be at most {_MAX_POINTS} points wide, got {shown(shape)}"
        )
    return int(n), int(m)


def window(
    shape: Any, spacing: Any, origin: Any
) -> tuple[tuple[int, int], float, tuple[float, float]]:
    """Return shape, spacing and origin of a grid as plain numbers, checked."""
    positive(spacing=spacing)
    try:
        x, y = origin
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"origin must be two numbers (x, y), got {shown(origin)}"
        ) from error
    finite(origin_x=x, origin_y=y)
    return grid_shape(shape), float(spacing), (float(x), float(y))


def surface(**values: Any) -> None:
    """Raise `ValueError` for a value without a method `heights`."""
    for name, value in values.items():
        if isinstance(value, type) or not callable(getattr(value, "heights", None)):
            raise ValueError(
                f"{name} must be a surface with a method heights, got {shown(value)}"
            )


def unknown(
    name: str, known: Sequence[str], what: str, hints: Mapping[str, str] | None = None
) -> str:
    """Return the error message for an unknown name, with the most similar known one.

    `hints` says what to give for some unknown names, in lower case.
    """
    if advice := (hints or {}).get(name.lower()):
        return f"unknown {what} {shown(name)}: give {advice}"
    similar = get_close_matches(name[:100], known, n=1, cutoff=_MIN_SIMILARITY)
    hint = f"; did you mean {similar[0]!r}?" if similar else "."
    distinct = dict.fromkeys(normalize("NFKC", name) for name in known)
    known_names = ", ".join(distinct) or "none"
    return f"unknown {what} {shown(name)}{hint} Known: {known_names}"


def lookup(
    name: Any,
    choices: Mapping[str, Any],
    what: str,
    hints: Mapping[str, str] | None = None,
) -> Any:
    """Return the value of a name; raise `ValueError` with the closest known name."""
    if name not in choices:
        raise ValueError(unknown(str(name), list(choices), what, hints))
    return choices[name]
