"""Threads: how many to use, and a map of a function over them.

Threads pay since NumPy and the Fourier transforms release the interpreter's lock while
they calculate.
"""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from contextvars import ContextVar, copy_context
from typing import TypeVar

from ase_roughcontact._util.validation import integer

S = TypeVar("S")
T = TypeVar("T")

# The thread pool starts threads on demand, up to this number.
_MAX_THREADS = 256
# Array elements per block: larger blocks leave the cache of a processor, and smaller
# ones are dominated by the overhead of NumPy's calls.
_BLOCK_SIZE = 131072

_threads: ContextVar[int] = ContextVar("threads", default=0)
_block_size: ContextVar[int] = ContextVar("block_size", default=_BLOCK_SIZE)
# Whether the present thread runs a function of `thread_map`.
_inside: ContextVar[bool] = ContextVar("inside", default=False)
_pool: Executor


def _new_pool() -> None:
    global _pool
    _pool = ThreadPoolExecutor(_MAX_THREADS, "ase_roughcontact")


_new_pool()
os.register_at_fork(after_in_child=_new_pool)  # a forked process inherits no threads


def processors() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def available_threads() -> int:
    """Return the number set by `threads`, by ``OMP_NUM_THREADS``, or of processors.

    The variable may have a number for each level of nested parallelism, as in ``4,2``:
    the first one counts.
    """
    first = os.environ.get("OMP_NUM_THREADS", "").partition(",")[0].strip()
    default = int(first) if first.isdecimal() and int(first) else processors()
    return _threads.get() or default


def block_size() -> int:
    """Return the largest number of array elements in a block of `rowwise` functions."""
    return _block_size.get()


@contextmanager
def threads(count: int, block_size: int = _BLOCK_SIZE) -> Iterator[None]:
    """Set the number of threads within a ``with`` block, for the present thread.

    Parameters
    ----------
    count : int
        What `available_threads` returns.
    block_size : int
        Elements per block of the arrays that threads work on.
    """
    before = _threads.set(integer("threads", count, 1))
    size = _block_size.set(integer("block_size", block_size, 1))
    try:
        yield
    finally:
        _block_size.reset(size)
        _threads.reset(before)


def split(length: int, longest: int) -> list[slice]:
    """Cut a length into pieces of about equal length, an even number if more than one.

    Parameters
    ----------
    length : int
        At least one.
    longest : int
        Upper bound to the length of a piece.

    Returns
    -------
    list of slice
    """
    count = 1
    if length > longest:
        count = min(2 * math.ceil(length / (2 * max(longest, 1))), length)
    return [slice(k * length // count, (k + 1) * length // count) for k in range(count)]


def thread_map(
    function: Callable[[S], T],
    items: list[S],
    threads: int,
    executor: Executor | None = None,
) -> list[T]:
    """Return ``[function(item) for item in items]``, calculated by several threads.

    The calling thread takes part. Within a function that is mapped, another map uses
    the present thread only.

    Parameters
    ----------
    function : callable
        Function of an item.
    items : list
    threads : int
        Number of threads, that of the caller included.
    executor : Executor, optional
        Where the other threads come from; by default a pool of the package.

    Returns
    -------
    list
    """
    count = 1 if _inside.get() else min(threads, len(items))
    if count == 1:
        return [function(item) for item in items]
    pending = iter(enumerate(items))  # shared: each thread takes the next item
    results: dict[int, T] = {}

    def work() -> None:
        before = _inside.set(True)
        try:
            for k, item in pending:
                results[k] = function(item)
        except BaseException:
            deque(pending, maxlen=0)  # no thread starts another item
            raise
        finally:
            _inside.reset(before)

    helpers: list[Future[None]] = []
    try:
        with suppress(RuntimeError):  # no thread can be started: work without it
            for _ in range(1, count):
                helper = (executor or _pool).submit(copy_context().run, work)
                helpers.append(helper)
        work()
    finally:
        started = [helper for helper in helpers if not helper.cancel()]
        wait(started)
    for helper in started:
        helper.result()  # raises its error in the calling thread
    return [results[k] for k in range(len(items))]
