"""Pools of worker processes on this machine."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from concurrent.futures import (
    Executor,
    Future,
    InvalidStateError,
    ProcessPoolExecutor,
)
from contextlib import AbstractContextManager, nullcontext, suppress
from typing import Any

from ase_roughcontact._util.threads import processors
from ase_roughcontact._util.validation import integer


def worker_pool(
    executor: Executor | None, workers: int | None
) -> AbstractContextManager[Executor]:
    """Return a context with an executor, by default of processes on this machine.

    These processes share the processors and end with this process. By default there is
    one process per processor. Each process uses its share of the processors, or
    ``OMP_NUM_THREADS`` threads if this variable is set.
    """
    if executor is not None:
        return nullcontext(executor)
    count = number_of_workers(workers)
    return _Pool(
        count,
        multiprocessing.get_context("spawn"),
        _initialize_worker,
        (max(1, processors() // count),),
    )


def number_of_workers(workers: int | None) -> int:
    """Return the number of processes; by default one per processor."""
    return processors() if workers is None else integer("workers", workers, 1)


class _Task(Future):
    """Future that may be cancelled when a process of its pool has died.

    In Python 3.11 the thread of the pool otherwise ends with an error, which it prints.
    """

    def set_exception(self, exception: BaseException | None) -> None:
        with suppress(InvalidStateError):
            super().set_exception(exception)


class _Pool(ProcessPoolExecutor):
    """Pool of processes that ignore Ctrl-C, which the parent handles."""

    def submit(self, *task: Any, **options: Any) -> Any:
        submitted = self._submit(*task, **options)
        submitted.__class__ = _Task
        return submitted

    def _submit(self, *task: Any, **options: Any) -> Any:
        if not hasattr(signal, "pthread_sigmask"):  # on Windows
            return super().submit(*task, **options)
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:  # processes start here
            return super().submit(*task, **options)
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _initialize_worker(threads: int) -> None:
    """Set the number of threads, and end this process when the parent ends."""
    os.environ.setdefault("OMP_NUM_THREADS", str(threads))
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process when its parent process ends."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
