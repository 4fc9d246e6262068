"""Cases given to workers, until the database holds all their steps."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Iterable, Iterator, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor, wait
from contextlib import ExitStack
from pathlib import Path

from ase_roughcontact._util.kernels import processors
from ase_roughcontact._util.validation import integer, positive
from ase_roughcontact.ensemble.cases import case_of
from ase_roughcontact.ensemble.ledger import Ledger, PathName, Standing, address
from ase_roughcontact.ensemble.progress import Meter, Progress, costs_of
from ase_roughcontact.ensemble.worker import calculate
from ase_roughcontact.scene import Scene


def run_ensemble(
    scenes: Iterable[Scene],
    database: PathName,
    executor: Executor | None = None,
    workers: int | None = None,
    *,
    checkpoints: PathName | None = None,
    lease: float = 300.0,
    interval: float = 1.0,
) -> Iterator[Progress]:
    """Calculate all steps of all scenes that the database does not hold yet.

    It may be stopped or killed at any moment, workers or all, and started again; and
    several may run at once, on one machine or more: they share the cases.

    Parameters
    ----------
    scenes : iterable of Scene
        Such as `product` makes.
    database : path
        An ASE database: SQLite (``.db``) on a file system that all workers see and
        whose locks work, or ``postgresql://...`` (with ``ase-db-backends``).
    executor : Executor, optional
        Where the cases are calculated: Dask's ``client.get_executor()``, an
        ``MPIPoolExecutor``, ... It is not shut down. By default processes of this
        machine; a script that uses them needs ``if __name__ == "__main__":``. Where
        it calculates cases in threads each takes no others, unless
        ``OMP_NUM_THREADS`` is set.
    workers : int, optional
        Number of these processes, by default one per processor. Unless
        ``OMP_NUM_THREADS`` is set they share the processors.
    checkpoints : path, optional
        Folder for the last frame of each case whose wall attracts, by default
        ``<database>-checkpoints`` beside an SQLite database. Its steps depend on those
        before them: without the frame a case that was stopped takes them again, to
        get at those that are missing.
    lease : float
        A worker that has not been heard of for this time (s) is taken for dead. It is
        heard of four times as often, however long a step takes. A dead process of the
        same machine is noticed at once. Several machines compare their own clocks:
        these must agree to well within the lease, or a living worker is taken for dead.
    interval : float
        Time between looks at the database (s).

    Yields
    ------
    Progress
        At first, and when steps or failures were added. Closing the generator, or
        Ctrl-C, lets each worker end its step.

    Raises
    ------
    ValueError
        If there are no scenes, one is not what it should be, or the database is of a
        kind without transactions.
    RuntimeError
        If a worker died. What was calculated is kept.

    Notes
    -----
    Cases of largest expected cost go first. One that ends with an error is kept as
    ``state=failed`` with its message, and tried again by the next run.
    """
    cases = {case_of(scene): scene for scene in scenes}
    if not cases:
        raise ValueError("an ensemble needs at least one scene, got none")
    positive(lease=lease, interval=interval)
    if workers is not None:
        integer("workers", workers, 1)
    costs = {case: costs_of(scene) for case, scene in cases.items()}
    cases = {case: cases[case] for case in sorted(cases, key=lambda c: -costs[c][-1])}
    ledger = Ledger(address(database), lease)
    ledger.prepare()
    files = _checkpoints(ledger, cases, checkpoints)
    meter = Meter(costs, ledger.since)
    return _progress(ledger, cases, files, meter, executor, workers, interval)


def _progress(
    ledger: Ledger,
    cases: Mapping[str, Scene],
    files: Mapping[str, Path | None],
    meter: Meter,
    executor: Executor | None,
    workers: int | None,
    interval: float,
) -> Iterator[Progress]:
    """Submit cases as long as there are free ones, and tell how far they are."""
    futures: dict[Future, str] = {}
    told = None
    with ExitStack() as stack:
        pool = executor or stack.enter_context(_processes(workers))
        stack.callback(_stop, ledger, futures, interval)
        while True:
            known = ledger.standings()
            standings = {case: known.get(case, Standing()) for case in cases}
            progress = meter.read(standings)
            if progress != told:
                told = progress
                yield progress
            if all(standing.settled(ledger.since) for standing in standings.values()):
                return
            try:
                taken = set(futures.values())
                for case, standing in standings.items():
                    if case not in taken and ledger.free(standing):
                        given = ledger, case, cases[case], files[case]
                        futures[pool.submit(calculate, *given)] = case
                _collect(futures, interval)
            except Exception as error:
                raise RuntimeError(
                    "a worker died, killed or out of memory, or was not to be had "
                    f"({type(error).__name__}: {error}): what was calculated is in the "
                    "database; start again to go on"
                ) from error


def _checkpoints(
    ledger: Ledger, cases: Iterable[str], folder: PathName | None
) -> dict[str, Path | None]:
    """Files for the last frames of the cases."""
    if folder is None:
        if "://" in ledger.database:
            return dict.fromkeys(cases)
        folder = f"{os.path.splitext(ledger.database)[0]}-checkpoints"
    return {case: Path(folder) / f"{case}.traj" for case in cases}


def _collect(futures: dict[Future, str], interval: float) -> None:
    """Wait a while for cases to end, and raise if a worker could not work."""
    _pause(futures, interval)
    for task in [task for task in futures if task.done()]:
        del futures[task]
        task.result()


def _stop(ledger: Ledger, futures: Mapping[Future, str], interval: float) -> None:
    """End the work of a run once the steps that are begun are done."""
    for task in futures:
        task.cancel()
    # also those whose tasks the executor has given up
    while futures and (ledger.stop() or not all(task.done() for task in futures)):
        _pause(futures, interval)


def _pause(futures: Mapping[Future, str], interval: float) -> None:
    """Wait a while, or for all cases to end."""
    if all(task.done() for task in futures):
        time.sleep(interval)
    else:
        wait(futures, timeout=interval)


def _processes(workers: int | None) -> ProcessPoolExecutor:
    """Make processes that share the processors, and end with this one."""
    count = processors() if workers is None else workers
    return ProcessPoolExecutor(
        count,
        multiprocessing.get_context("spawn"),
        _begin_worker,
        (max(1, processors() // count),),
    )


def _begin_worker(threads: int) -> None:
    """Prepare a process: Ctrl-C is for its parent, without which it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.setdefault("OMP_NUM_THREADS", str(threads))
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End when the process that started this one does."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
