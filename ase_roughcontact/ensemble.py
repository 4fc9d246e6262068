"""Ensembles: many scenes, calculated by many workers, kept in one ASE database.

A case is a scene. The database has one row per case (``record=case``), which tells how
far it is and who works at it, and one row per relaxed step (``record=step``). A worker
changes them in transactions of one writer at a time, which the database undoes if the
worker dies in the middle, and writes a step only while the case is its own. So a step
stands there once or not at all, whatever is killed, and whoever else is at work.
"""

from __future__ import annotations

import csv
import hashlib
import itertools
import json
import math
import multiprocessing
import os
import signal
import socket
import threading
import time
import uuid
from collections.abc import Generator, Iterable, Iterator, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor, wait
from contextlib import ExitStack, closing, contextmanager
from dataclasses import asdict, dataclass, field, fields, replace
from datetime import timedelta
from importlib.metadata import version
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
from ase import Atoms
from ase.calculators.singlepoint import SinglePointCalculator
from ase.db import connect

from ase_roughcontact.checks import finite_array, integer, positive, unknown
from ase_roughcontact.record import LoadStep
from ase_roughcontact.scene import RoughnessTable, Scene

PathName = str | os.PathLike

_RECORD = {k: kind for k, kind in get_type_hints(LoadStep).items() if k != "step"}

#: Columns of a table of steps, and their types; see `read_ensemble`.
COLUMNS: dict[str, type] = {
    "case": str,
    "step": int,
    "control": str,
    "target": float,
    "radius": float,
    "rms_slope": float,
    "hurst": float,
    "short_wavelength": float,
    "long_wavelength": float,
    "seed": int,
    "kind": str,
    "work_of_adhesion": float,
    "spacing": float,
    "contact_modulus": float,
    **_RECORD,
    "version": str,
}
_MISSING: dict[type, Any] = {str: "", float: math.nan, int: -1, bool: False}

# What makes a writer the only one until the end of its transaction. ASE's lock file
# would stay when its owner is killed.
_ALONE = {
    "db": ("PRAGMA busy_timeout = 600000", "BEGIN IMMEDIATE"),
    "postgresql": ("SELECT pg_advisory_xact_lock(221601)",),
}
# Without these every change of a row reads those of all others (12 instead of 6 ms a
# step among 4000).
_INDICES = [
    f"CREATE INDEX IF NOT EXISTS {table}_of_row ON {table}(id)"
    for table in ("keys", "species", "text_key_values", "number_key_values")
]
# A step of a small window takes as long as this many atoms in contact of a large one.
_LEAST_COST = 5000.0


def product(scene: Scene, choices: Mapping[str, Iterable]) -> list[Scene]:
    """Combine all values of some keys of a scene.

    Parameters
    ----------
    scene : Scene
        Gives everything else.
    choices : mapping
        Values by key, in the units of the scene file: ``"sphere.radius"``,
        ``"roughness.seed"``; or whole tables by title, where keys go together:
        ``"interaction": [InteractionTable("hard"), InteractionTable("full", 0.05)]``.

    Returns
    -------
    list of Scene
        The last key varies fastest.

    Raises
    ------
    ValueError
        If there is no such table or key, or no value for it.
    """
    values = {
        key: [_scalar(value) for value in given] for key, given in choices.items()
    }
    for key, given in values.items():
        if not given:
            raise ValueError(f"{key} must have at least one value, got none")
    scenes = []
    for chosen in itertools.product(*values.values()):
        changed = scene
        for key, value in zip(values, chosen, strict=True):
            changed = _changed(changed, key, value)
        scenes.append(changed)
    return scenes


def case_of(scene: Scene) -> str:
    """Name of a scene's case: "c" and the start of the SHA-256 of all that it says.

    Defaults are left out, so that keys to come do not change it, and numbers count to
    twelve digits, so that another machine's rounding does not. A letter comes first
    since ASE's databases take no text that reads as a number.
    """
    text = json.dumps(_told(scene), sort_keys=True)
    return "c" + hashlib.sha256(text.encode()).hexdigest()[:15]


@dataclass(frozen=True)
class Progress:
    """How far an ensemble is.

    Attributes
    ----------
    steps, total : int
        Steps that are done, and all of them.
    elapsed : float
        Time since the start of this run (s).
    left : float
        Time left (s); NaN before the first step. A step is taken to cost as much as
        5000 atoms (measured: copper, from 1 nN to 2 µN on a radius of 1000 atoms) and
        the atoms in the contact of a smooth sphere; the time of such a unit is measured
        on all steps of this run, by all workers.
    failures : dict
        Messages of cases that ended with an error, by case.
    """

    steps: int
    total: int
    elapsed: float = field(default=0.0, compare=False)
    left: float = field(default=math.nan, compare=False)
    failures: dict[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        parts = [f"{self.steps}/{self.total} steps"]
        if self.failures:
            parts.append(f"{len(self.failures)} failed")
        if math.isfinite(self.left):
            parts.append(f"about {timedelta(seconds=round(self.left))} left")
        return ", ".join(parts)


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
        machine; a script that uses them needs ``if __name__ == "__main__":``.
    workers : int, optional
        Number of these processes, by default one per processor. Unless
        ``OMP_NUM_THREADS`` is set they share the processors among their transforms.
    checkpoints : path, optional
        Folder for the last frame of each case whose wall attracts, by default
        ``<database>-checkpoints`` beside an SQLite database. Its steps depend on those
        before them: without the frame a case that was stopped takes them again, to
        get at those that are missing.
    lease : float
        A worker that has not been heard of for this time (s) is taken for dead. It is
        heard of four times as often, however long a step takes. A dead process of the
        same machine is noticed at once.
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
    costs = {case: _costs(scene) for case, scene in cases.items()}
    cases = dict(sorted(cases.items(), key=lambda item: -costs[item[0]][-1]))
    address = _address(database)
    folder = checkpoints
    if folder is None and "://" not in address:
        folder = f"{os.path.splitext(address)[0]}-checkpoints"
    ledger = _Ledger(address)
    ledger.prepare()
    run = _Run(address, folder, lease, f"r{uuid.uuid4().hex[:15]}", time.time())
    return _progress(run, ledger, cases, costs, executor, workers, interval)


def read_ensemble(
    database: PathName, selection: str | None = None, **query: Any
) -> dict[str, np.ndarray]:
    """Read the steps of an ensemble as columns.

    Parameters
    ----------
    database : path
        Of `run_ensemble`.
    selection : str, optional
        Query as for ``ase db``: ``"radius>100,kind=hard"``.
    **query
        Values that keys must have: ``seed=1``.

    Returns
    -------
    dict of ndarray, shape (steps,)
        By name, see `COLUMNS`, sorted by case and step. Inputs are in the units of the
        scene file: lengths of sphere and roughness in spacings, works of adhesion in
        J/m^2; all else is in ASE's: ``spacing`` in Å, ``contact_modulus`` in eV/Å^3,
        ``target`` in Å or, under ``control == "load"``, eV/Å, and what `LoadStep` has.
        What a case does not have is NaN, -1 or "".

    Raises
    ------
    ValueError
        If there is no such database.
    """
    rows = _opened(database).select(
        selection, record="step", include_data=False, **query
    )
    return _columns(
        {name: row.get(name, _MISSING[kind]) for name, kind in COLUMNS.items()}
        for row in rows
    )


def write_table(
    database: PathName, table: PathName, selection: str | None = None, **query: Any
) -> None:
    """Write the steps of an ensemble as CSV, every number to its last digit.

    Parameters
    ----------
    database, selection, **query
        See `read_ensemble`.
    table : path
        File to be written.
    """
    columns = read_ensemble(database, selection, **query)
    lists = [values.tolist() for values in columns.values()]
    with open(table, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*lists, strict=True))


def read_table(table: PathName) -> dict[str, np.ndarray]:
    """Read what `write_table` wrote, as `read_ensemble` does.

    Parameters
    ----------
    table : path

    Returns
    -------
    dict of ndarray

    Raises
    ------
    ValueError
        If the table has other columns, or values that are not of their types.
    """
    with open(table, newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        if reader.fieldnames is None or list(reader.fieldnames) != list(COLUMNS):
            raise ValueError(
                f"{os.fspath(table)} must have the columns {', '.join(COLUMNS)}; "
                f"got {', '.join(reader.fieldnames or ['none'])}"
            )
        return _columns(
            {name: _parsed(row[name], kind) for name, kind in COLUMNS.items()}
            for row in reader
        )


def fill_database(database: PathName, table: PathName) -> int:
    """Put the steps of a table into a database, so that a run can go on from them.

    Parameters
    ----------
    database : path
        Made if it is not there. Cases that it has already stay as they are.
    table : path
        From `write_table`.

    Returns
    -------
    int
        Number of steps added.
    """
    columns = read_table(table)
    steps: dict[str, list[dict[str, Any]]] = {}
    for values in zip(*(x.tolist() for x in columns.values()), strict=True):
        row = dict(zip(columns, values, strict=True))
        steps.setdefault(row["case"], []).append(row)
    ledger = _Ledger(_address(database))
    ledger.prepare()
    return ledger.fill(steps)


@dataclass(frozen=True)
class _Run:
    """What the workers of a run have to know."""

    database: str
    checkpoints: PathName | None
    lease: float
    name: str
    since: float

    def checkpoint(self, case: str) -> Path | None:
        """File of the last frame of a case."""
        if self.checkpoints is None:
            return None
        return Path(self.checkpoints) / f"{case}.traj"


@dataclass(frozen=True)
class _Claim:
    """Right of one worker to write the steps of a case."""

    row: int
    holder: str
    case: str
    missing: list[int]


@dataclass(frozen=True)
class _Standing:
    """How far a case is, and who works at it."""

    state: str = "waiting"  # running, stopping (after this step), done, failed
    holder: str = ""  # host:pid:token
    run: str = ""
    renewed: float = 0.0
    finished: int = 0
    message: str = ""

    @classmethod
    def of(cls, row: Any) -> _Standing:
        """Read it off a row."""
        given = {f.name: row.get(f.name, f.default) for f in fields(cls)}
        return cls(**given)

    def settled(self, since: float) -> bool:
        """Whether nothing is left to do, or it has failed since then."""
        failed = self.state == "failed" and self.renewed >= since
        return self.state == "done" or failed

    def held(self, lease: float) -> bool:
        """Whether a living worker is at work."""
        begun = self.state in ("running", "stopping")
        return begun and _alive(self.holder, time.time() - self.renewed, lease)

    def free(self, since: float, lease: float) -> bool:
        """Whether a worker may take the case."""
        return not self.settled(since) and not self.held(lease)


class _Ledger:
    """The rows of an ensemble, changed by one writer at a time."""

    def __init__(self, database: str) -> None:
        self._db = _connect(database)

    def prepare(self) -> None:
        """Make the tables of the database if they are not there."""
        with self._alone() as db:
            _ = db.metadata  # commits where it makes them
        with self._alone() as db:
            for statement in _INDICES:
                db.connection.cursor().execute(statement)

    def standings(self) -> dict[str, _Standing]:
        """Return how far the cases are."""
        rows = self._db.select(record="case", include_data=False)
        return {row.case: _Standing.of(row) for row in rows}

    def claim(self, run: _Run, case: str, scene: Scene) -> _Claim | None:
        """Take a case, unless it is done or a living worker has it."""
        with self._alone() as db:
            db.reserve(record="case", case=case)
            (row,) = list(db.select(record="case", case=case))
            if not _Standing.of(row).free(run.since, run.lease):
                return None
            done = db.select(record="step", case=case, include_data=False)
            steps = {row.step for row in done}
            missing = sorted(set(range(len(scene.steps))) - steps)
            token = uuid.uuid4().hex[:8]
            holder = f"{socket.gethostname()}:{os.getpid()}:{token}"
            standing = _Standing("running", holder, run.name, time.time(), len(steps))
            inputs = _known(_inputs(scene))
            db.update(row.id, data=_tables(scene), **asdict(standing), **inputs)
            return _Claim(row.id, holder, case, missing)

    def write(self, claim: _Claim, scene: Scene, record: LoadStep) -> bool:
        """Write a step of a case that is held; return whether to go on."""
        with self._alone() as db:
            standing = self._held(db, claim)
            if standing is None:
                return False
            row = {
                "case": claim.case,
                "target": float(scene.steps[record.step]),
                **_inputs(scene),
                **asdict(record),
                "version": _version(),
            }
            _add_step(db, row, _tables(scene))
            finished = standing.finished + 1
            db.update(claim.row, finished=finished, renewed=time.time())
            return standing.state == "running"

    def renew(self, claim: _Claim) -> None:
        """Tell that the worker lives."""
        self._update(claim, renewed=time.time())

    def release(self, claim: _Claim, state: str, message: str) -> None:
        """Leave a case."""
        self._update(claim, state=state, message=message, renewed=time.time())

    def stop(self, run: str) -> None:
        """Ask the workers of a run to end after the step at which they are."""
        with self._alone() as db:
            for row in list(db.select(record="case", run=run, state="running")):
                db.update(row.id, state="stopping")

    def fill(self, steps: Mapping[str, list[dict[str, Any]]]) -> int:
        """Write cases that are not there, with their steps; return their number."""
        added = 0
        with self._alone() as db:
            for case, rows in steps.items():
                known = db.reserve(record="case", case=case)
                if known is None:
                    continue
                db.update(known, **asdict(_Standing(finished=len(rows))))
                for row in rows:
                    _add_step(db, row, {})
                added += len(rows)
        return added

    def _update(self, claim: _Claim, **values: Any) -> None:
        """Change the row of a case if it is still held."""
        with self._alone() as db:
            if self._held(db, claim) is not None:
                db.update(claim.row, **values)

    def _held(self, db: Any, claim: _Claim) -> _Standing | None:
        """How far a case is, or None if another worker has taken it."""
        standing = _Standing.of(db.get(id=claim.row))
        return standing if standing.holder == claim.holder else None

    @contextmanager
    def _alone(self) -> Iterator[Any]:
        """Begin a transaction of one writer at a time."""
        with self._db as db:
            cursor = db.connection.cursor()
            for statement in _ALONE[db.type]:
                cursor.execute(statement)
            yield db


def _progress(
    run: _Run,
    ledger: _Ledger,
    cases: Mapping[str, Scene],
    costs: Mapping[str, np.ndarray],
    executor: Executor | None,
    workers: int | None,
    interval: float,
) -> Iterator[Progress]:
    """Submit cases as long as there are free ones, and tell how far they are."""
    meter = _Meter(costs)
    futures: dict[Future, str] = {}
    told = None
    with ExitStack() as stack:
        pool = executor or stack.enter_context(_processes(workers))
        stack.callback(_stop, run, ledger, futures, interval)
        while True:
            known = ledger.standings()
            standings = {case: known.get(case, _Standing()) for case in cases}
            progress = meter.read(standings, run.since)
            if progress != told:
                told = progress
                yield progress
            if all(standing.settled(run.since) for standing in standings.values()):
                return
            try:
                taken = set(futures.values())
                for case, standing in standings.items():
                    if case not in taken and standing.free(run.since, run.lease):
                        task = pool.submit(_calculate, run, case, cases[case])
                        futures[task] = case
                _collect(futures, interval)
            except Exception as error:
                raise RuntimeError(
                    "a worker died, killed or out of memory, or was not to be had "
                    f"({type(error).__name__}: {error}): what was calculated is in the "
                    "database; start again to go on"
                ) from error


class _Meter:
    """Tells progress, and the time left by the expected cost of what is left."""

    def __init__(self, costs: Mapping[str, np.ndarray]) -> None:
        self._costs = costs
        self._start = time.perf_counter()
        self._before: float | None = None

    def read(self, standings: Mapping[str, _Standing], since: float) -> Progress:
        """Read it off how far the cases are."""
        elapsed = time.perf_counter() - self._start
        done = {case: self._costs[case][s.finished] for case, s in standings.items()}
        spent = sum(done.values())
        if self._before is None:
            self._before = spent
        ahead = sum(
            self._costs[case][-1] - done[case]
            for case, standing in standings.items()
            if not standing.settled(since)
        )
        new = spent - self._before
        return Progress(
            sum(standing.finished for standing in standings.values()),
            sum(len(cost) - 1 for cost in self._costs.values()),
            elapsed,
            _left(ahead, elapsed, new),
            {
                case: standing.message
                for case, standing in standings.items()
                if standing.state == "failed" and standing.settled(since)
            },
        )


def _left(ahead: float, elapsed: float, spent: float) -> float:
    """Time for the cost that is ahead, at the rate so far."""
    if ahead == 0.0:
        return 0.0
    return float(ahead * elapsed / spent) if spent > 0.0 else math.nan


def _costs(scene: Scene) -> np.ndarray:
    """Return the expected cost before each step of a scene, and after the last."""
    _ = scene.wall, scene.surface
    steps = finite_array("the path", scene.steps)
    if not steps.size:
        raise ValueError("a path must have at least one step, got none")
    if scene.shape:
        areas = np.full(steps.shape, float(math.prod(scene.shape)))
    elif scene.path.control == "load":
        areas = scene.hertz_area(np.maximum(steps, 0.0)) / scene.spacing**2
    else:
        from_top = steps.max() - steps
        depths = steps if scene.path.control == "penetration" else from_top
        areas = np.pi * scene.radius * np.maximum(depths, 0.0) / scene.spacing**2
    return np.append(0.0, np.cumsum(_LEAST_COST + areas))


def _processes(workers: int | None) -> ProcessPoolExecutor:
    """Make processes that share the processors, and end with this one."""
    count = _processors() if workers is None else workers
    return ProcessPoolExecutor(
        count,
        multiprocessing.get_context("spawn"),
        _begin_worker,
        (max(1, _processors() // count),),
    )


def _processors() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _begin_worker(threads: int) -> None:
    """Prepare a process: Ctrl-C is for its parent, without which it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.environ.setdefault("OMP_NUM_THREADS", str(threads))
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _collect(futures: dict[Future, str], interval: float) -> None:
    """Wait a while for cases to end, and raise if a worker could not work."""
    _pause(futures, interval)
    for task in [task for task in futures if task.done()]:
        del futures[task]
        task.result()


def _pause(futures: Mapping[Future, str], interval: float) -> None:
    if all(task.done() for task in futures):
        time.sleep(interval)
    else:
        wait(futures, timeout=interval)


def _stop(
    run: _Run, ledger: _Ledger, futures: Mapping[Future, str], interval: float
) -> None:
    """End the work of a run once the steps that are begun are done."""
    for task in futures:
        task.cancel()
    while futures:
        ledger.stop(run.name)
        at_work = any(
            standing.run == run.name and standing.held(run.lease)
            for standing in ledger.standings().values()
        )
        if not at_work and all(task.done() for task in futures):
            return
        _pause(futures, interval)


def _calculate(run: _Run, case: str, scene: Scene) -> None:
    """Calculate what is missing of a case, unless another worker does."""
    ledger, file = _Ledger(run.database), run.checkpoint(case)
    claim = ledger.claim(run, case, scene)
    if claim is None:
        return
    state, message = "waiting", ""
    try:
        with _heartbeat(run, claim), closing(_relaxed(scene, claim, file)) as steps:
            if all(ledger.write(claim, scene, record) for record in steps):
                state = "done"
                if file is not None:
                    file.unlink(missing_ok=True)
    except Exception as error:
        state, message = "failed", f"{type(error).__name__}: {error}"
    finally:
        ledger.release(claim, state, message)


@contextmanager
def _heartbeat(run: _Run, claim: _Claim) -> Iterator[None]:
    """Tell that the worker lives, as long as a step may take."""
    over = threading.Event()

    def beat() -> None:
        ledger = _Ledger(run.database)
        while not over.wait(run.lease / 4.0):
            ledger.renew(claim)

    thread = threading.Thread(target=beat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def _relaxed(
    scene: Scene, claim: _Claim, file: Path | None
) -> Generator[LoadStep, None, None]:
    """Relax the steps that are missing, and those that they depend on."""
    missing = claim.missing
    if not missing:
        return
    if not scene.wall.attractive:  # one state, however it is come by
        records = scene.relax(scene.steps[missing])
        for number, record in zip(missing, records, strict=True):
            yield replace(record, step=number)
    else:
        for record in _resumed(scene, missing[0], file):
            if record.step in missing:
                yield record


def _resumed(scene: Scene, first: int, file: Path | None) -> Iterator[LoadStep]:
    """Follow the path from the frame in a file, if it is not beyond a first step."""
    if file is None:
        return scene.relax()
    file.parent.mkdir(parents=True, exist_ok=True)
    try:
        steps = scene.relax(trajectory=file, keep="last", resume=True)
        record = next(steps)
    except ValueError:  # not a frame of this path, or a path that fails again below
        pass
    else:
        if record.step <= first:
            return itertools.chain([record], steps)
    return scene.relax(trajectory=file, keep="last")


def _changed(scene: Scene, key: str, value: Any) -> Scene:
    """Scene with another value of a key, or another table."""
    title, _, name = key.partition(".")
    tables = [f.name for f in fields(Scene)]
    if title not in tables:
        raise ValueError(unknown(title, tables, "table"))
    if not name:
        return replace(scene, **{title: value})
    table = getattr(scene, title)
    if table is None:
        table = RoughnessTable()
    keys = [f.name for f in fields(table)]
    if name not in keys:
        raise ValueError(f"[{title}]: {unknown(name, keys, 'key')}")
    return replace(scene, **{title: replace(table, **{name: value})})


def _scalar(value: Any) -> Any:
    """Return a plain number in place of one of numpy's."""
    return value.item() if isinstance(value, np.generic) else value


def _told(scene: Scene) -> dict[str, Any]:
    """Return what a scene says that is not the default, its numbers rounded."""
    told = {}
    for part in fields(scene):
        table = getattr(scene, part.name)
        if table is not None:
            usual = asdict(type(table)())
            given = asdict(table).items()
            told[part.name] = {k: _rounded(v) for k, v in given if v != usual[k]}
    return told


def _rounded(value: Any) -> Any:
    """Return a value with all its numbers to twelve digits."""
    value = _canonical(value)
    if isinstance(value, list):
        return [_rounded(inner) for inner in value]
    return f"{value:.12g}" if isinstance(value, float) else value


def _canonical(value: Any) -> Any:
    """Return what JSON knows, the same for equal values."""
    value = value.tolist() if isinstance(value, np.ndarray) else _scalar(value)
    if isinstance(value, dict):
        return {key: _canonical(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_canonical(inner) for inner in value]
    if isinstance(value, float) and value.is_integer():
        return int(value)
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise ValueError(f"a scene must hold words and numbers only, got {value!r}")


def _inputs(scene: Scene) -> dict[str, Any]:
    """Columns that a scene has from the start."""
    rough = scene.roughness
    work = scene.interaction.work_of_adhesion
    return {
        "control": scene.path.control,
        "radius": float(scene.sphere.radius),
        "rms_slope": 0.0 if rough is None else float(rough.rms_slope),
        "hurst": math.nan if rough is None else float(rough.hurst),
        "short_wavelength": math.nan if rough is None else rough.short_wavelength,
        "long_wavelength": math.nan if rough is None else rough.long_wavelength,
        "seed": -1 if rough is None else int(rough.seed),
        "kind": scene.interaction.kind,
        "work_of_adhesion": math.nan if work is None else float(work),
        "spacing": float(scene.spacing),
        "contact_modulus": float(scene.contact_modulus),
    }


def _tables(scene: Scene) -> dict[str, Any]:
    """Return all that a scene says, as the data of a row."""
    return {"scene": _canonical(asdict(scene))}


def _add_step(db: Any, row: dict[str, Any], data: dict[str, Any]) -> None:
    """Write the row of a step: the indenter, its energy, and key-value pairs."""
    atoms = Atoms("X", positions=[[0.0, 0.0, row["height"]]])
    atoms.calc = SinglePointCalculator(atoms, energy=row["energy"])
    pairs = {key: value for key, value in _known(row).items() if key != "energy"}
    db.write(atoms, {"record": "step", **pairs}, data)


def _known(values: dict[str, Any]) -> dict[str, Any]:
    """Values that are not NaN."""
    return {key: value for key, value in values.items() if value == value}


def _columns(rows: Iterable[dict[str, Any]]) -> dict[str, np.ndarray]:
    """Columns of rows, sorted by case and step."""
    ordered = sorted(rows, key=lambda row: (row["case"], row["step"]))
    return {
        name: np.array([row[name] for row in ordered], dtype=kind)
        for name, kind in COLUMNS.items()
    }


def _parsed(text: str | None, kind: type) -> Any:
    """Value of a table's field."""
    if text is not None and kind is bool and text in ("True", "False"):
        return text == "True"
    if text is None or kind is bool:
        raise ValueError(f"a table of steps has {text!r} where a {kind.__name__} is")
    return kind(text)


def _version() -> str:
    """Version of the package; a bare number is no text in ASE's databases."""
    return f"v{version('ase-roughcontact')}"


def _alive(holder: str, age: float, lease: float) -> bool:
    """Whether a worker that was heard of some time ago may still be at work."""
    if age > lease:
        return False
    host, pid, _ = holder.rsplit(":", 2)
    if host != socket.gethostname():
        return True
    try:
        os.kill(int(pid), 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True


def _address(database: PathName) -> str:
    """URL of a database server, or the whole path of an SQLite file."""
    name = os.fspath(database)
    if name.startswith(("postgresql://", "postgres://")):
        return name
    if "://" not in name and name.endswith(".db"):
        return os.path.abspath(name)
    raise ValueError(
        "an ensemble needs a database with transactions, SQLite (a path that ends in "
        f".db) or postgresql://, got {name!r}"
    )


def _opened(database: PathName) -> Any:
    """Database that is there already."""
    address = _address(database)
    if "://" not in address and not Path(address).exists():
        raise ValueError(f"there is no database {address}")
    return _connect(address)


def _connect(address: str) -> Any:
    """Database without ASE's lock file, and without a part in MPI."""
    db = connect(address, use_lock_file=False)
    db.serial = True
    return db
