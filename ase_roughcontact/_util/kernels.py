"""Arithmetic of large arrays, in parts that stay in the cache, shared among threads.

Numpy and the transforms let other threads run while they calculate. Sums over parts are
the same for any number of threads.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from contextvars import ContextVar, copy_context
from itertools import pairwise
from typing import TypeVar

import numpy as np

from ase_roughcontact._util.validation import integer

S = TypeVar("S")
T = TypeVar("T")

# Numbers in a part of an array: more of them leave the cache, and with fewer the calls
# of numpy take longer than what they do.
_PART = 131072

_THREADS: ContextVar[int] = ContextVar("threads", default=0)
# Whether this thread shares work with others already.
_SHARING: ContextVar[bool] = ContextVar("sharing", default=False)
# Threads at most, which begin when they are needed.
_MOST = 256
_POOL: ThreadPoolExecutor


def _new_pool() -> None:
    global _POOL
    _POOL = ThreadPoolExecutor(_MOST, "ase_roughcontact")


_new_pool()
if hasattr(os, "register_at_fork"):  # a child has the pool, but not its threads
    os.register_at_fork(after_in_child=_new_pool)


def processors() -> int:
    """Processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def available_threads() -> int:
    """Threads to use: those of `threads`, ``OMP_NUM_THREADS``, or all processors."""
    wanted = os.environ.get("OMP_NUM_THREADS", "")
    usual = int(wanted) if wanted.isdigit() and int(wanted) > 0 else processors()
    return _THREADS.get() or usual


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Choose the number of `available_threads` for what this thread does meanwhile."""
    before = _THREADS.set(integer("threads", count, 1))
    try:
        yield
    finally:
        _THREADS.reset(before)


def together(work: Callable[[int], T], count: int) -> list[T]:
    """Return ``[work(0), ..., work(count - 1)]``, called at the same time.

    Within such work, one after the other.

    Parameters
    ----------
    work : callable
        Of the number of the thread.
    count : int
        Number of threads.

    Returns
    -------
    list
    """
    if count < 2 or _SHARING.get():
        return [work(k) for k in range(count)]

    def alone(k: int) -> T:
        before = _SHARING.set(True)
        try:
            return work(k)
        finally:
            _SHARING.reset(before)

    def begun(future: Future[T], k: int) -> None:
        if future.set_running_or_notify_cancel():
            try:
                future.set_result(alone(k))
            except BaseException as error:  # for the thread that asked
                future.set_exception(error)

    tasks: list[Future[T]] = [Future() for _ in range(1, count)]
    try:
        try:
            with suppress(RuntimeError):  # no thread begins when the interpreter ends
                for k, task in enumerate(tasks, 1):
                    _POOL.submit(copy_context().run, begun, task, k)
            first = alone(0)
        finally:
            _end(tasks)
    finally:
        _end(tasks)  # an interrupt of the first must not leave them at work
    rest = enumerate(tasks, 1)
    late = (alone(k) if task.cancelled() else task.result() for k, task in rest)
    return [first, *late]


def _end(tasks: list[Future[T]]) -> None:
    """Wait for tasks that have begun, and let the others not begin any more."""
    wait([task for task in tasks if not task.cancel()])


def parts(length: int, most: int) -> list[slice]:
    """Cut a length into parts of about equal length, as a rule an even number.

    Parameters
    ----------
    length : int
        At least one.
    most : int
        Length of a part, at most.

    Returns
    -------
    list of slice
    """
    most = max(most, 1)
    count = min(2 * math.ceil(length / (2 * most)), length) if length > most else 1
    bounds = [k * length // count for k in range(count + 1)]
    return [slice(*ends) for ends in pairwise(bounds)]


def each(work: Callable[[S], T], items: list[S]) -> list[T]:
    """Do work on each of some items, shared among `available_threads`.

    Parameters
    ----------
    work : callable
        Of an item.
    items : list

    Returns
    -------
    list
        What it returned for each of them, in their order.
    """
    results: dict[int, T] = {}
    shared = iter(enumerate(items))

    def share(_: int) -> None:
        for k, item in shared:
            results[k] = work(item)

    # a thread that has but one of a few begins too late
    together(share, min(available_threads(), max(1, len(items) // 2)))
    return [results[k] for k in range(len(items))]


def by_rows(work: Callable[[slice], T], shape: tuple[int, ...]) -> list[T]:
    """Do work on the rows of arrays, some at a time; see `each`.

    Parameters
    ----------
    work : callable
        Of a slice of rows; must not touch others.
    shape : (int, ...)
        Of the arrays.

    Returns
    -------
    list
        What it returned for each of the slices, in their order.
    """
    if math.prod(shape) <= _PART:
        return [work(slice(0, shape[0]))]
    return each(work, parts(shape[0], _PART // math.prod(shape[1:])))


def dot(a: np.ndarray, b: np.ndarray) -> float:
    """Scalar product without BLAS, whose threads fight those of the transforms."""
    return float(dots([(a, b)])[0])


def dots(pairs: list[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Scalar products of pairs of arrays, all of one shape."""

    def products(rows: slice) -> list[float]:
        return [part_dot(a[rows], b[rows]) for a, b in pairs]

    found: np.ndarray = np.sum(by_rows(products, pairs[0][0].shape), axis=0)
    return found


def part_dot(a: np.ndarray, b: np.ndarray) -> float:
    """Scalar product of parts of arrays, in one thread."""
    return float(np.einsum("i,i", a.reshape(-1), b.reshape(-1)))


def same(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two arrays, not scalars, have one shape and the same entries."""
    if a.shape != b.shape:
        return False
    return all(by_rows(lambda rows: bool((a[rows] == b[rows]).all()), a.shape))


def largest(values: np.ndarray) -> float:
    """Largest magnitude; NaN if there is one."""

    def ends(rows: slice) -> tuple[float, float]:
        return float(values[rows].max()), -float(values[rows].min())

    return float(np.max(by_rows(ends, values.shape)))


def combined(
    terms: list[tuple[float, np.ndarray]], out: np.ndarray | None = None
) -> np.ndarray:
    """Sum of arrays of floats, of one shape, each times a number.

    Parameters
    ----------
    terms : list of (float, ndarray)
        At least one.
    out : ndarray, optional
        Where to put the sum, maybe one of the arrays; by default a new array.

    Returns
    -------
    ndarray
    """
    (first, array), *rest = terms
    result = np.empty(array.shape, array.dtype) if out is None else out

    def add(rows: slice) -> None:
        total = array[rows] * float(first)
        for factor, other in rest:
            total += other[rows] * float(factor)
        result[rows] = total

    by_rows(add, array.shape)
    return result
