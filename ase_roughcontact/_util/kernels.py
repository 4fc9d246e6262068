"""Operations on large arrays, in blocks of rows that threads share.

A function decorated with `rowwise` is written in plain NumPy, as for whole arrays. It
is called with blocks of rows that fit into the cache of a processor. Results are added
in the order of the blocks, so that sums do not depend on the number of threads.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np

from ase_roughcontact._util.threads import available_threads, split, thread_map

#: Number of array elements per block. Larger blocks leave the cache of a processor;
#: smaller blocks are dominated by the overhead of NumPy's calls.
BLOCK_SIZE = 131072
# Length of vectors for which BLAS does not start threads, which OpenBLAS does above
# 10 000.
_SINGLE_THREAD_LENGTH = 8192

P = ParamSpec("P")
T = TypeVar("T")


def rowwise(
    combine: np.ufunc | None = None,
) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Decorate a function of arrays so that threads run it on blocks of their rows.

    All arrays in the arguments, and in lists and tuples of the arguments, must have
    equal numbers of rows. The first argument must be an array, or contain one first.
    Other arguments are passed on unchanged. The function may write to the rows.

    Parameters
    ----------
    combine : ufunc, optional
        Function that combines the results for the blocks, numbers or tuples of numbers:
        ``np.add``, ``np.maximum`` ... By default the function returns nothing.
    """

    def decorate(function: Callable[P, T]) -> Callable[P, T]:
        @wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> Any:
            first: Any = args[0]
            while not isinstance(first, np.ndarray):  # the first of nested lists
                first = first[0]
            size = BLOCK_SIZE * (2 if first.itemsize <= 4 else 1)  # of equal memory
            if first.size <= size:  # blocks of small arrays do not pay
                return function(*args, **kwargs)
            blocks = split(len(first), size * len(first) // first.size)
            results: list[Any] = thread_map(
                lambda rows: function(*_block(args, rows), **kwargs),
                blocks,
                # a thread with a single block starts too late to help
                min(available_threads(), len(blocks) // 2),
            )
            if combine is None:
                return None
            combined = combine.reduce(results, axis=0).tolist()
            return tuple(combined) if isinstance(combined, list) else combined

        return call

    return decorate


def _block(argument: Any, rows: slice) -> Any:
    """Return an argument with some rows of its arrays."""
    if isinstance(argument, np.ndarray):
        return argument[rows]
    if isinstance(argument, list | tuple):
        return [_block(item, rows) for item in argument]
    return argument


def inner(a: np.ndarray, b: np.ndarray) -> float:
    """Return ``a . b`` in one thread.

    BLAS is called for pieces that are too short for threads of its own, as the number
    of these threads would change the result.
    """
    a, b = a.reshape(-1), b.reshape(-1)
    length = _SINGLE_THREAD_LENGTH
    if a.size <= length:
        return float(a @ b)
    whole = a.size // length * length
    rows = a[:whole].reshape(-1, 1, length)
    columns = b[:whole].reshape(-1, length, 1)
    return float((rows @ columns).sum(dtype=float) + a[whole:] @ b[whole:])


@rowwise(np.add)
def dot(a: np.ndarray, b: np.ndarray) -> float:
    """Return the scalar product ``a . b`` of two arrays."""
    return inner(a, b)


@rowwise(np.add)
def dots(pairs: list[tuple[np.ndarray, np.ndarray]]) -> tuple[float, ...]:
    """Return the scalar products ``a . b`` of pairs of arrays in one pass."""
    return tuple(inner(a, b) for a, b in pairs)


def norm(a: np.ndarray) -> float:
    """Return the Euclidean norm ``sqrt(a . a)``."""
    return dot(a, a) ** 0.5


@rowwise(np.maximum)
def max_abs(a: np.ndarray) -> float:
    """Return ``max |a|``; NaN if an entry is NaN."""
    return float(max(a.max(), -a.min()))


@rowwise(np.add)
def total(a: np.ndarray) -> float:
    """Return the sum of an array."""
    return float(a.sum())


@rowwise(np.add)
def total_abs(a: np.ndarray) -> float:
    """Return the sum of the magnitudes of an array."""
    return float(abs(a).sum())


@rowwise(np.add)
def subtract_and_dot(
    a: np.ndarray, factor: float, b: np.ndarray, c: np.ndarray
) -> float:
    """Set ``a -= factor b``, then return ``a . c``; `c` may be `a` itself."""
    a -= factor * b
    return inner(a, c)


@rowwise()
def scale(out: np.ndarray, a: np.ndarray, factor: float) -> None:
    """Set ``out = factor a``, rounded to the precision of `out`."""
    np.multiply(a, factor, out=out, casting="same_kind")


def linear_combination(
    terms: list[tuple[float, np.ndarray]], out: np.ndarray | None = None
) -> np.ndarray:
    """Return ``sum(factor * array)`` over pairs of a factor and an array.

    Parameters
    ----------
    terms : list of (float, ndarray)
        Arrays of floats of one shape.
    out : ndarray, optional
        Array for the result, which may be the first term; by default a new array.

    Returns
    -------
    ndarray
        The sum.
    """
    result = np.empty_like(terms[0][1]) if out is None else out
    if result is terms[0][1] and terms[0][0] == 1.0:
        _add(result, terms[1:])
    else:
        _set_linear_combination(result, terms)
    return result


@rowwise()
def _add(out: np.ndarray, terms: list[tuple[float, np.ndarray]]) -> None:
    for factor, array in terms:
        out += array if factor == 1.0 else float(factor) * array


@rowwise()
def _set_linear_combination(
    out: np.ndarray, terms: list[tuple[float, np.ndarray]]
) -> None:
    (factor, array), *others = terms
    if others and factor == 1.0:  # one pass less
        second, b = others.pop(0)
        np.add(array, b if second == 1.0 else float(second) * b, out=out)
    else:
        np.multiply(array, float(factor), out=out)
    _add(out, others)


def array_equal(a: np.ndarray, b: np.ndarray) -> bool:
    """Return whether two arrays have the same shape and the same entries."""
    return a.shape == b.shape and _all_equal(a, b)


@rowwise(np.logical_and)
def _all_equal(a: np.ndarray, b: np.ndarray) -> bool:
    return np.count_nonzero(a == b) == a.size  # for small arrays faster than `all`
