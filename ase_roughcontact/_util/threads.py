"""Number of threads, and a map of a function over items by several threads.

NumPy and the Fourier transforms release the interpreter's lock while they calculate, so
that threads are useful.
"""

from __future__ import annotations

import math
import os
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, suppress
from contextvars import ContextVar, copy_context
from typing import TypeVar

from ase_roughcontact._util.validation import integer

S = TypeVar("S")
T = TypeVar("T")

# Largest number of threads of the pool, which starts them on demand.
_MAX_THREADS = 256

# Number of threads that `threads` sets; zero stands for the default.
_threads: ContextVar[int] = ContextVar("threads", default=0)
# Whether the present thread runs a function of `thread_map`.
_inside: ContextVar[bool] = ContextVar("inside", default=False)
_pool: ThreadPoolExecutor


def _new_pool() -> None:
    global _pool
    _pool = ThreadPoolExecutor(_MAX_THREADS, "ase_roughcontact")


_new_pool()
if hasattr(os, "register_at_fork"):  # a forked process inherits no threads
    os.register_at_fork(after_in_child=_new_pool)


def processors() -> int:
    """Return the number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def available_threads() -> int:
    """Return the number of threads to use.

    It is set by `threads` or by ``OMP_NUM_THREADS``, and by default the number of
    processors. If the variable has a number for each level of nested parallelism, as in
    ``4,2``, the first one counts.
    """
    first = os.environ.get("OMP_NUM_THREADS", "").partition(",")[0].strip()
    default = int(first) if first.isdecimal() and int(first) else processors()
    return _threads.get() or default


@contextmanager
def threads(count: int) -> Iterator[None]:
    """Set `available_threads` within a ``with`` block, for the present thread."""
    before = _threads.set(integer("threads", count, 1))
    try:
        yield
    finally:
        _threads.reset(before)


def split(length: int, longest: int) -> list[slice]:
    """Cut a length into pieces of about equal length, up to `longest`.

    There is one piece, or an even number of pieces.
    """
    count = 1
    if length > longest:
        count = min(2 * math.ceil(length / (2 * max(longest, 1))), length)
    return [slice(k * length // count, (k + 1) * length // count) for k in range(count)]


def usable_threads(most: int) -> int:
    """Return a number of threads, or one within a function of `thread_map`."""
    return 1 if _inside.get() else most


def thread_map(function: Callable[[S], T], items: list[S], threads: int) -> list[T]:
    """Return ``[function(item) for item in items]``, calculated by several threads.

    The calling thread is one of them. A map within a function that is mapped uses the
    present thread only.
    """
    count = min(usable_threads(threads), len(items))
    if count == 1:
        return [function(item) for item in items]
    pending = iter(enumerate(items))  # shared: each thread takes the next item
    results: dict[int, T] = {}

    def work() -> None:
        _inside.set(True)
        try:
            for k, item in pending:
                results[k] = function(item)
        except BaseException:
            deque(pending, maxlen=0)  # no thread starts another item
            raise

    helpers: list[Future[None]] = []
    try:
        with suppress(RuntimeError):  # no thread can be started: work without it
            for _ in range(1, count):
                helpers.append(_pool.submit(copy_context().run, work))
        copy_context().run(work)
    finally:
        started = [helper for helper in helpers if not helper.cancel()]
        wait(started)
    for helper in started:
        helper.result()  # raises its error in the calling thread
    return [results[k] for k in range(len(items))]
