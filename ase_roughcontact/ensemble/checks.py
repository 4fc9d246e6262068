"""Checks for damage of the database of an ensemble."""

from __future__ import annotations

import json
import sqlite3
import zlib
from collections import defaultdict
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

#: Key of the checksum of a row.
CHECKSUM = "checksum"

# Words in SQLite's errors about a database that can't be used, but is not damaged.
_UNUSABLE_WORDS = ("locked", "unable to open", "disk I/O", "full", "readonly")
# Answer of SQLite's integrity check for an intact database.
_INTACT_ANSWER = [("ok",)]


def checksum(values: Mapping[str, Any], energy: float | None, data: Any) -> int:
    """Return the CRC-32 of the content of a row without the checksum."""
    kept = {key: value for key, value in values.items() if key != CHECKSUM}
    return zlib.crc32(json.dumps([kept, energy, data], sort_keys=True).encode())


def damaged_row(db: Any) -> int | None:
    """Return the number of the first damaged row; None if no row is damaged.

    Parameters
    ----------
    db : Database
        ASE's database, within its context.

    Raises
    ------
    Exception
        Any error, if rows can't be read.
    """
    if db.type == "db":
        if not db.connection.in_transaction:
            db.connection.execute("BEGIN")  # all checks see the same content
        found = db.connection.execute("PRAGMA integrity_check(1)").fetchall()
        if found != _INTACT_ANSWER:
            raise sqlite3.DatabaseError(found[0][0])
        _ = db.metadata  # creates the tables of a new file
        index = _index(db.connection)
    for row in db.select(include_data=True):
        values = row.key_value_pairs
        if CHECKSUM not in values and values.get("record") not in ("step", "case"):
            continue  # a row of another program
        try:
            found = checksum(values, row.get("energy"), row.data)
        except (ValueError, TypeError, KeyError):  # data that can't be decoded
            return row.id
        if found != values.get(CHECKSUM):
            return row.id
        if db.type == "db" and index[row.id] != set(values.items()):
            return row.id
    return None


def _index(connection: sqlite3.Connection) -> defaultdict[int, set[tuple[str, Any]]]:
    """Return keys and values in the tables by which SQLite selects rows, by row."""
    index: defaultdict[int, set[tuple[str, Any]]] = defaultdict(set)
    for table in ("text_key_values", "number_key_values"):
        for key, value, row in connection.execute(f"SELECT * FROM {table}"):
            index[row].add((key, value))
    return index


@contextmanager
def readable_errors(address: str) -> Iterator[None]:
    """Replace errors of SQLite by errors with the name of the database and advice.

    Raises
    ------
    OSError
        If the database can't be used, as its disk is full or has no locks.
    ValueError
        If the database is damaged.
    """
    try:
        yield
    except sqlite3.OperationalError as error:
        if not any(word in str(error) for word in _UNUSABLE_WORDS):
            raise damaged(address, error) from error
        raise OSError(
            f"can't use {address}: {error}. SQLite needs space on the disk and a file "
            "system with locks, such as a local disk"
        ) from error
    except sqlite3.DatabaseError as error:
        raise damaged(address, error) from error


def damaged(address: str, error: Exception) -> ValueError:
    """Return the error about a damaged database."""
    return ValueError(
        f"{address} is damaged ({error}): restore a copy, copy readable rows by "
        f"'sqlite3 {address} .recover', or name another database"
    )
