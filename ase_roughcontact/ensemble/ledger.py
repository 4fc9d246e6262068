"""The database of an ensemble: who works at which case, and the steps that are done.

It has one row per case (``record=case``), which tells how far it is and who works at
it, and one row per relaxed step (``record=step``). A worker changes them in
transactions of one writer at a time, which the database undoes if the worker dies in
the middle, and writes a step only while the case is its own. So a step stands there
once or not at all, whatever is killed, and whoever else is at work.
"""

from __future__ import annotations

import os
import re
import socket
import time
import uuid
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field, fields
from importlib.metadata import version
from typing import Any

from ase import Atoms
from ase.calculators.singlepoint import SinglePointCalculator
from ase.db import connect

from ase_roughcontact.ensemble.cases import inputs, tables
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.scene import Scene

PathName = str | os.PathLike

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


@dataclass(frozen=True)
class Standing:
    """How far a case is, and who works at it."""

    state: str = "waiting"  # running, stopping (after this step), done, failed
    holder: str = ""  # host:pid:token
    run: str = ""
    renewed: float = 0.0
    finished: int = 0
    message: str = ""

    @classmethod
    def of(cls, row: Any) -> Standing:
        """Read it off a row."""
        return cls(**{f.name: row.get(f.name, f.default) for f in fields(cls)})

    def settled(self, since: float) -> bool:
        """Whether nothing is left to do, or it has failed since then."""
        failed = self.state == "failed" and self.renewed >= since
        return self.state == "done" or failed

    def held(self, lease: float) -> bool:
        """Whether a worker is at work who may be alive."""
        if self.state not in ("running", "stopping"):
            return False
        if time.time() - self.renewed > lease:
            return False
        host, pid, _ = self.holder.rsplit(":", 2)
        return host != socket.gethostname() or _exists(int(pid))


@dataclass(frozen=True)
class Claim:
    """Right of one worker to write the steps of a case that are missing."""

    case: str
    scene: Scene
    row: int
    holder: str
    missing: list[int]


@dataclass(frozen=True)
class Ledger:
    """The rows of an ensemble in one run, changed by one writer at a time.

    Parameters
    ----------
    database : str
        From `address`.
    lease : float
        A worker that has not been heard of for this time (s), by the clocks of its
        machine and of this one, is taken for dead.
    run : str
        Name of the run.
    since : float
        When the run began, as `time.time` tells it.
    """

    database: str
    lease: float = 300.0
    run: str = field(default_factory=lambda: f"r{uuid.uuid4().hex[:15]}")
    since: float = field(default_factory=time.time)

    def prepare(self) -> None:
        """Make the tables of the database if they are not there."""
        with self._alone() as db:
            _ = db.metadata  # commits where it makes them
        with self._alone() as db:
            for statement in _INDICES:
                db.connection.cursor().execute(statement)

    def standings(self) -> dict[str, Standing]:
        """Return how far the cases are."""
        rows = open_database(self.database).select(record="case", include_data=False)
        return {row.case: Standing.of(row) for row in rows}

    def free(self, standing: Standing) -> bool:
        """Whether a worker may take a case."""
        return not (standing.settled(self.since) or standing.held(self.lease))

    def claim(self, case: str, scene: Scene) -> Claim | None:
        """Take a case, unless it is done or a living worker has it."""
        with self._alone() as db:
            db.reserve(record="case", case=case)
            row = db.get(record="case", case=case)
            if not self.free(Standing.of(row)):
                return None
            done = db.select(record="step", case=case, include_data=False)
            steps = {row.step for row in done}
            missing = sorted(set(range(len(scene.steps))) - steps)
            token = uuid.uuid4().hex[:8]
            holder = f"{socket.gethostname()}:{os.getpid()}:{token}"
            standing = Standing("running", holder, self.run, time.time(), len(steps))
            pairs = _known({**asdict(standing), **inputs(scene)})
            db.update(row.id, data=_data(scene), **pairs)
            return Claim(case, scene, row.id, holder, missing)

    def write(self, claim: Claim, record: LoadStep) -> bool:
        """Write a step of a case that is held; return whether to go on."""
        with self._alone() as db:
            standing = Standing.of(db.get(id=claim.row))
            if standing.holder != claim.holder:
                return False
            row = {
                "case": claim.case,
                "target": float(claim.scene.steps[record.step]),
                **inputs(claim.scene),
                **asdict(record),
                # with a letter, since a bare number is no text in ASE's databases
                "version": f"v{version('ase-roughcontact')}",
            }
            _add_step(db, row, _data(claim.scene))
            finished = standing.finished + 1
            db.update(claim.row, finished=finished, renewed=time.time())
            return standing.state == "running"

    def renew(self, claim: Claim, **values: Any) -> None:
        """Tell that the worker lives, and change its case, if it is still held."""
        with self._alone() as db:
            if db.get(id=claim.row).holder == claim.holder:
                db.update(claim.row, renewed=time.time(), **values)

    def stop(self) -> bool:
        """Ask the run's workers to end after their step; return if any is at work."""
        with self._alone() as db:
            rows = list(db.select(record="case", run=self.run, include_data=False))
            for row in rows:
                if row.state == "running":
                    db.update(row.id, state="stopping")
        return any(Standing.of(row).held(self.lease) for row in rows)

    def fill(self, steps: Mapping[str, list[dict[str, Any]]]) -> int:
        """Write cases that are not there, with their steps; return their number."""
        added = 0
        with self._alone() as db:
            for case, rows in steps.items():
                known = db.reserve(record="case", case=case)
                if known is None:
                    continue
                db.update(known, **asdict(Standing(finished=len(rows))))
                for row in rows:
                    _add_step(db, row, {})
                added += len(rows)
        return added

    @contextmanager
    def _alone(self) -> Iterator[Any]:
        """Begin a transaction of one writer at a time."""
        with open_database(self.database) as db:
            cursor = db.connection.cursor()
            for statement in _ALONE[db.type]:
                cursor.execute(statement)
            yield db


def address(database: PathName) -> str:
    """URL of a database server, or the whole path of an SQLite file.

    Raises
    ------
    ValueError
        If the database is of a kind without transactions.
    """
    name = os.fspath(database)
    if name.startswith(("postgresql://", "postgres://")):
        return name
    if "://" not in name and name.endswith(".db"):
        return os.path.abspath(name)
    raise ValueError(
        "an ensemble needs a database with transactions, SQLite (a path that ends in "
        f".db) or postgresql://, got {without_password(name)!r}"
    )


def without_password(address: str) -> str:
    """Return an address to be shown."""
    hidden = re.sub(r"(?<=://)([^:@/]*):.*@", r"\1:***@", address)
    return re.sub(r"(?<=password=)[^&]*", "***", hidden)


def open_database(address: str) -> Any:
    """Database without ASE's lock file, and without a part in MPI."""
    db = connect(address, use_lock_file=False)
    db.serial = True
    return db


def _data(scene: Scene) -> dict[str, Any]:
    """Return all that a scene says, as the data of a row."""
    return {"scene": tables(scene)}


def _add_step(db: Any, row: dict[str, Any], data: dict[str, Any]) -> None:
    """Write the row of a step: the indenter, its energy, and key-value pairs."""
    atoms = Atoms("X", positions=[[0.0, 0.0, row["height"]]])
    atoms.calc = SinglePointCalculator(atoms, energy=row["energy"])
    pairs = {key: value for key, value in _known(row).items() if key != "energy"}
    db.write(atoms, {"record": "step", **pairs}, data)


def _known(values: dict[str, Any]) -> dict[str, Any]:
    """Values that are not NaN."""
    return {key: value for key, value in values.items() if value == value}


def _exists(pid: int) -> bool:
    """Whether this machine has such a process."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        pass
    return True
