"""The ASE database of an ensemble, to which many workers write at the same time.

Marks of ASE's `reserve` do not name the worker, and stay when the worker is killed, as
does ASE's lock file. Two other mechanisms are used instead:

- A load step is added in a transaction that first checks that the step is missing. A
  step is therefore stored once, even if several workers calculate it.
- A worker locks the case that it calculates against other workers. The operating
  system or the database server releases the lock when the worker ends, for any reason.
"""

from __future__ import annotations

import hashlib
import os
import re
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, closing, contextmanager
from dataclasses import dataclass
from glob import escape, glob
from pathlib import Path
from typing import Any

from ase import Atoms
from ase.calculators.singlepoint import SinglePointCalculator
from ase.db import connect

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.locks import lock
from ase_roughcontact.ensemble.checks import (
    CHECKSUM,
    checksum,
    damaged,
    damaged_row,
    readable_errors,
)

# Statements that make other writers wait until the end of the transaction.
_EXCLUSIVE = {
    "db": "BEGIN IMMEDIATE",
    "postgresql": "SELECT pg_advisory_xact_lock(221601)",
}
# Longest time to wait for other writers to an SQLite file (ms).
_BUSY_TIMEOUT = 600_000


@dataclass(frozen=True)
class EnsembleDatabase:
    """Rows of load steps (``record=step``) and of cases (``record=case``), and locks.

    Parameters
    ----------
    address : str
        Address from `database_address`.
    """

    address: str

    def create(self) -> None:
        """Create the tables if missing, and remove lock files of killed processes.

        Raises
        ------
        ValueError
            If the database is damaged; it is then not changed.
        """
        with self._transaction() as db:
            damage = self._damage(db)
        if damage:  # not in the context: PostgreSQL's can't be left by an error
            raise damage
        for file in glob(f"{escape(self.address)}-*.lock"):
            with lock(file):
                pass

    def check(self) -> None:
        """Raise `ValueError` that describes the damage if the database is damaged."""
        with self._connected() as db:
            damage = self._damage(db)
        if damage:
            raise damage

    def select(
        self, selection: str | None = None, db: Any = None, **query: Any
    ) -> Iterator[Any]:
        """Yield the rows of load steps that match a query; see `ase.db`.

        `db` is ASE's database within a transaction; by default it is a new connection.
        """
        query = {"record": "step", "include_data": False, **query}
        if db is not None:
            yield from db.select(selection, **query)
            return
        with self._connected() as db:
            yield from db.select(selection, **query)

    def steps(self, after: int = 0, **query: Any) -> dict[int, tuple[str, int]]:
        """Return case and number of the stored load steps, by row id.

        Parameters
        ----------
        after : int
            Number of a row; only rows added later are returned.
        **query
            Values of keys.
        """
        columns = ["id", "key_value_pairs"]
        rows = self.select(f"id>{after}", columns=columns, **query)
        return {row.id: (row.case, row.step) for row in rows}

    def done(self) -> dict[str, int | None]:
        """Return the numbers of steps of the cases that ended without an error.

        The number is None if the row does not have it.
        """
        rows = self.select(record="case", state="done")
        return {row.case: row.get("steps") for row in rows}

    def add_steps(
        self, rows: Sequence[dict[str, Any]], data: dict[str, Any], **query: Any
    ) -> int:
        """Add the load steps that the database does not have yet.

        Parameters
        ----------
        rows : sequence of dict
            Values by column, see `step_types`.
        data : dict
            Data of ASE's row, stored with each step.
        **query
            Values of keys that all rows share, which makes the search for stored rows
            faster.

        Returns
        -------
        int
            Number of steps added.
        """
        with self._transaction() as db:
            stored = set(self.steps(db=db, **query).values())
            new = [row for row in rows if (row["case"], row["step"]) not in stored]
            for row in new:
                atoms = Atoms("X", positions=[[0.0, 0.0, row["height"]]])
                atoms.calc = SinglePointCalculator(atoms, energy=row["energy"])
                values = {key: row[key] for key in row if key != "energy"}
                pairs = {"record": "step", **_without_nan(values)}
                pairs[CHECKSUM] = checksum(pairs, row["energy"], data)
                db.write(atoms, pairs, data)
        return len(new)

    def set_state(
        self, case: str, state: str, data: dict[str, Any], **values: Any
    ) -> None:
        """Store how the calculation of a case ended, in place of an earlier end.

        Parameters
        ----------
        case : str
            Name of the case.
        state : {"done", "failed"}
            End of the calculation.
        data : dict
            Data of ASE's row.
        **values
            Further key-value pairs.
        """
        with self._transaction() as db:
            db.reserve(record="case", case=case)
            row = db.get(record="case", case=case)
            named = {"record": "case", "case": case, "state": state}
            pairs = named | _without_nan(values)
            pairs[CHECKSUM] = checksum(pairs, None, data)
            old = list(row.key_value_pairs.keys() - pairs.keys())
            db.update(row.id, delete_keys=old, data=data, **pairs)

    def lock(self, name: str) -> AbstractContextManager[bool]:
        """Lock a name until the end of the context or of this process.

        Parameters
        ----------
        name : str
            Name of a case or of a run.

        Returns
        -------
        context manager
            Context with the value true if the name was free.
        """
        if "://" in self.address:
            return _server_lock(self.address, name)
        return lock(f"{self.address}-{name}.lock")

    def checkpoint(self, case: str) -> Path | None:
        """Return the restart file of a case; None with a server."""
        if "://" in self.address:
            return None
        root, _ = os.path.splitext(self.address)
        return Path(f"{root}-checkpoints", f"{case}.npz")

    def is_locked(self, name: str) -> bool:
        """Whether a name is locked by a process that is alive."""
        with self.lock(name) as free:
            return not free

    def _damage(self, db: Any) -> ValueError | None:
        """Return the error about a damaged database; None if it is intact."""
        try:
            row = damaged_row(db)
        except sqlite3.OperationalError:
            raise
        except Exception as error:  # damage can cause any error
            return damaged(self.address, error)
        if row is None:
            return None
        address = without_password(self.address)
        return ValueError(
            f"row {row} of {address} is damaged: restore a copy of the database, or "
            f"delete the row with 'ase db {address} id={row} --delete', and start "
            "again to calculate it"
        )

    @contextmanager
    def _transaction(self) -> Iterator[Any]:
        """Begin a transaction of one writer, which is undone if its process dies."""
        with self._connected() as db:
            db.connection.cursor().execute(_EXCLUSIVE[db.type])
            yield db

    @contextmanager
    def _connected(self) -> Iterator[Any]:
        """Open the database, and wait for writers longer than the 20 s of ASE."""
        with readable_errors(self.address), _connect(self.address) as db:
            if db.type == "db":
                db.connection.execute(f"PRAGMA busy_timeout = {_BUSY_TIMEOUT}")
            yield db


def database_address(database: PathName) -> str:
    """Return the URL of a database server, or the absolute path of an SQLite file.

    Raises
    ------
    ValueError
        If this kind of database has no transactions.
    """
    name = os.fspath(database)
    if name.startswith(("postgresql://", "postgres://")):
        return name
    if "://" not in name and name.endswith(".db"):
        return os.path.abspath(name)
    raise ValueError(
        "an ensemble needs a database with transactions: an SQLite file (a path that "
        f"ends in .db) or postgresql://..., got {without_password(name)!r}"
    )


def without_password(address: str) -> str:
    """Return an address with its password replaced by asterisks."""
    hidden = re.sub(r"(?<=://)([^:@/]*):.*@", r"\1:***@", address)
    return re.sub(r"(?<=password=)[^&]*", "***", hidden)


def _connect(address: str) -> Any:
    """Open a database without ASE's lock file, independently of other MPI ranks."""
    db = connect(address, use_lock_file=False)
    db.serial = True
    return db


@contextmanager
def _server_lock(address: str, name: str) -> Iterator[bool]:
    """Lock a name on a PostgreSQL server as long as a connection lasts."""
    import psycopg2  # required by ase-db-backends

    digest = hashlib.sha256(name.encode()).digest()
    number = int.from_bytes(digest[:8], "big", signed=True)
    with closing(psycopg2.connect(address)) as connection:
        connection.autocommit = True
        with connection.cursor() as cursor:
            cursor.execute("SELECT pg_try_advisory_lock(%s)", [number])
            yield cursor.fetchone()[0]


def _without_nan(values: dict[str, Any]) -> dict[str, Any]:
    """Return the values that are not NaN."""
    return {key: value for key, value in values.items() if value == value}
