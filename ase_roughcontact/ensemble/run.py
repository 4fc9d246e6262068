"""Distribution of the cases of an ensemble until the database has all load steps."""

from __future__ import annotations

import time
import uuid
from collections import defaultdict
from collections.abc import Generator, Iterable, Mapping, Sequence
from concurrent.futures import Executor, Future, wait
from contextlib import AbstractContextManager, ExitStack

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.lazy import lazy
from ase_roughcontact._util.validation import instance_of, positive
from ase_roughcontact._util.workers import worker_pool
from ase_roughcontact.ensemble.cases import case_names, case_of
from ase_roughcontact.ensemble.database import (
    EnsembleDatabase,
    database_address,
    without_password,
)
from ase_roughcontact.ensemble.foreseen import warn_of_problems
from ase_roughcontact.ensemble.progress import (
    WHOLE,
    Progress,
    ProgressMeter,
    expected_costs,
)
from ase_roughcontact.ensemble.worker import calculate_case
from ase_roughcontact.scene import Scene

# Largest share of the processor time that queries of the database may take.
_QUERY_SHARE = 0.02


@lazy
def run_ensemble(
    scenes: Iterable[Scene],
    database: PathName,
    executor: Executor | None = None,
    workers: int | None = None,
    *,
    interval: float = 1.0,
    steps: Iterable[Sequence[int] | None] | None = None,
) -> Generator[Progress, None, None]:
    """Calculate the load steps of all scenes that are missing in the database.

    A run may be interrupted or killed at any time, with some or all of its workers, and
    started again: only the steps in progress are lost. Several runs, on one machine or
    more, may use the same database at the same time and share the cases.

    Parameters
    ----------
    scenes : iterable of Scene
        The scenes, for example from `product`.
    database : path
        ASE database: an SQLite file (``.db``) on a file system that all workers share
        and that supports file locks, or ``postgresql://...`` (requires
        ``ase-db-backends``).
    executor : Executor, optional
        Executor of the cases: Dask's ``client.get_executor(pure=False)``, an
        ``MPIPoolExecutor``, a ``ThreadPoolExecutor``, ... It is not shut down. The
        default is a pool of processes on this machine; scripts that use it need
        ``if __name__ == "__main__":``. Cases that an executor runs in threads use one
        thread each, unless ``OMP_NUM_THREADS`` is set.
    workers : int, optional
        Number of processes of the default pool, by default one per processor. Unless
        ``OMP_NUM_THREADS`` is set, they share the processors.
    interval : float
        Least time between two queries of the database (s); it grows if a query takes
        more than 2 % of it.
    steps : iterable of sequence of int, optional
        Numbers of the wanted load steps of each scene, or None for all. Loops, sliding
        paths and paths in time have all their steps in any case. If states depend on
        the states before, all steps up to the last wanted one are needed. By default
        all steps of all scenes.

    Yields
    ------
    Progress
        Progress at the start, and whenever steps were added or cases failed. When the
        generator is closed, or on Ctrl-C, each worker finishes its current step.

    Raises
    ------
    ValueError
        If there are no scenes, a scene is invalid or does not have the wanted steps, or
        the database is of a kind without transactions, or damaged.
    TypeError
        If one of the scenes is no `Scene`.
    OSError
        If the database can't be used, as its disk is full or has no file locks.
    RuntimeError
        If a worker or a scheduler died, or the lock of the run was removed. All
        finished steps are in the database.

    Warns
    -----
    UserWarning
        If cases will probably fail, as a window or the domain of the roughness is too
        small, with the remedy.

    Notes
    -----
    Cases with the largest expected cost start first. A case that fails is stored as
    ``record=case,state=failed`` with its message, and calculated again by the next run.
    The locks of a machine that crashes may hold its cases on a network file system,
    until the file server releases them.

    The restart file of each case is in the folder ``<database>-checkpoints`` next to
    an SQLite file until the case is done: an interrupted case goes on as if it had not
    been. With PostgreSQL a case is calculated from its first step again, if its
    states depend on those before: with an attractive wall, or one that keeps the
    plastic shape, and along loops, sliding paths and paths in time.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from ase_roughcontact.ensemble import product, read_ensemble, run_ensemble
    >>> from ase_roughcontact.scene import Scene
    >>> scene = Scene.default().with_values({'path.loads': [2.0, 4.0]})
    >>> scenes = product(scene, {'roughness.seed': [1, 2]})
    >>> with TemporaryDirectory() as folder:
    ...     database = Path(folder) / 'spheres.db'
    ...     *_, last = run_ensemble(scenes, database, workers=1)
    ...     len(read_ensemble(database)['contact_area'])
    4
    """
    scenes = list(scenes)
    if not scenes:
        raise ValueError("an ensemble needs at least one scene, got none")
    for scene in scenes:
        instance_of(Scene, scenes=scene)
    positive(interval=interval)
    pool = worker_pool(executor, workers)
    chosen = [None] * len(scenes) if steps is None else steps
    tasks = {}
    for scene, numbers in zip(scenes, chosen, strict=True):
        costs = expected_costs(scene)
        if WHOLE not in costs and numbers is not None:
            unknown = [step for step in numbers if step not in costs]
            if unknown:
                raise ValueError(
                    f"steps must be numbers of load steps, from 0 to {len(costs) - 1}, "
                    f"got {unknown[0]}"
                )
            costs = {step: costs[step] for step in numbers}
        tasks[case_of(scene)] = scene, costs
    shared = EnsembleDatabase(database_address(database))
    shared.create()
    names, done = case_names({k: each for k, (each, _) in tasks.items()}), shared.done()
    missing = {case: scene for case, (scene, _) in tasks.items() if case not in done}
    warn_of_problems((names[case], scene) for case, scene in missing.items())
    return _run(shared, tasks, names, pool, interval)


def _run(
    database: EnsembleDatabase,
    tasks: Mapping[str, tuple[Scene, Mapping[int, float]]],
    names: Mapping[str, str],
    pool: AbstractContextManager[Executor],
    interval: float,
) -> Generator[Progress, None, None]:
    """Submit cases, and report progress until all are complete or failed.

    Tasks are scenes and expected costs of the wanted steps, by case; names are for
    messages.
    """
    run = f"run-{uuid.uuid4().hex}"
    submitted: dict[Future, str] = {}
    newest, reported = 0, None
    stored: defaultdict[str, set[int]] = defaultdict(set)  # steps by case
    costs = {case: costs for case, (_, costs) in tasks.items()}
    largest_first = sorted(costs, key=lambda case: -sum(costs[case].values()))
    meter = ProgressMeter({case: costs[case] for case in largest_first}, names)
    whole = any(WHOLE in steps for steps in costs.values())
    with ExitStack() as stack:
        executor = stack.enter_context(pool)
        stack.callback(_cancel, submitted)
        stack.enter_context(database.lock(run))  # workers stop when it is released
        while True:
            begin = time.process_time()
            new = database.steps(after=newest)
            newest = max(new, default=newest)
            for case, step in new.values():
                stored[case].add(step)
                meter.finish(case, step)
            for case, count in database.done().items() if whole else ():
                last = max(stored[case], default=0)
                if len(stored[case]) == (count or last + 1):
                    meter.finish(case, WHOLE)
            pause = max(interval, (time.process_time() - begin) / _QUERY_SHARE)
            progress = meter.progress()
            if progress != reported:
                reported = progress
                yield progress
            unfinished = meter.unfinished()
            if not unfinished:
                _cancel(submitted)  # workers store how their cases ended
                return
            try:
                waiting = set(submitted.values())
                for case in unfinished:
                    if case not in waiting:
                        scene, steps = tasks[case][0], list(costs[case])
                        task = executor.submit(
                            calculate_case, database, run, case, scene, steps
                        )
                        submitted[task] = case
                wait(submitted, timeout=pause)
                states = set[str]()  # states of the tasks that have ended
                for task in [task for task in submitted if task.done()]:
                    state, message = task.result()
                    case = submitted.pop(task)
                    states.add(state)
                    if state == "failed":
                        meter.failures[case] = message
            except OSError:
                raise
            except Exception as error:
                raise RuntimeError(
                    "a worker or the scheduler ended, perhaps without memory, or could "
                    f"not start ({type(error).__name__}: {error}): finished steps are "
                    "in the database; start the ensemble again to continue"
                ) from error
            if "stopped" in states:
                address = without_password(database.address)
                raise RuntimeError(
                    f"the lock {address}-{run}.lock of this run was removed: finished "
                    "steps are in the database; start the ensemble again to continue"
                )
            if "busy" in states:  # other runs work on some of the cases
                time.sleep(pause)


def _cancel(submitted: Mapping[Future, str]) -> None:
    """Cancel the cases that have not started, and wait for the others to stop."""
    wait([task for task in submitted if not task.cancel()])
