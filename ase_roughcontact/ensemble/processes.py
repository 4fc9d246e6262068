"""Worker processes on this machine."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import AbstractContextManager, nullcontext

from ase_roughcontact._util.threads import processors
from ase_roughcontact._util.validation import integer


def worker_pool(
    executor: Executor | None, workers: int | None
) -> AbstractContextManager[Executor]:
    """Return a context of an executor, by default of `process_pool`."""
    return process_pool(workers) if executor is None else nullcontext(executor)


def process_pool(workers: int | None = None) -> ProcessPoolExecutor:
    """Return a pool of processes that share the processors and end with this process.

    Parameters
    ----------
    workers : int, optional
        Number of processes, by default one per processor. Each uses its share of the
        processors, or ``OMP_NUM_THREADS`` threads if that is set.

    Returns
    -------
    ProcessPoolExecutor
    """
    count = processors() if workers is None else integer("workers", workers, 1)
    return ProcessPoolExecutor(
        count,
        multiprocessing.get_context("spawn"),
        _initialize_worker,
        (max(1, processors() // count),),
    )


def _initialize_worker(threads: int) -> None:
    """Ignore Ctrl-C, which the parent handles, and end when the parent ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.setdefault("OMP_NUM_THREADS", str(threads))
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process when the one that started it ends."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
