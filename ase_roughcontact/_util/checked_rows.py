"""Rows of a CSV file with a checksum each, by which an interrupted run continues."""

from __future__ import annotations

import csv
import json
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from ase_roughcontact._util.files import PathName, table_rows

#: Column of the checksum.
CHECKSUM = "checksum"


def with_checksum(row: Mapping[str, str]) -> dict[str, str]:
    """Return a row with its checksum."""
    return {**row, CHECKSUM: _checksum(row)}


@contextmanager
def checked_rows(file: PathName) -> Iterator[list[dict[str, str]]]:
    """Read the rows of a file.

    The last row is left out if its line has no end, as when a run was killed in it. A
    row without a checksum is not checked.

    Parameters
    ----------
    file : path

    Yields
    ------
    list of dict of str to str
        Rows by the names of the columns, without their units.

    Raises
    ------
    ValueError
        If a row does not have its checksum, or an error in the context shows that it is
        damaged.
    """
    try:
        with open(file, newline="", encoding="utf-8") as table:
            lines = table.readlines()
        if lines and not lines[-1].endswith("\n"):
            del lines[-1]
        rows = list(table_rows(lines))
        for number, row in enumerate(rows, 1):
            if CHECKSUM in row and row[CHECKSUM] != _checksum(row):
                raise ValueError(f"row {number} does not have its checksum")
        yield rows
    except (KeyError, TypeError, ValueError, csv.Error) as error:
        raise ValueError(
            f"{file} is damaged ({error}): delete this row, or the file, and start "
            "again to calculate what is missing"
        ) from error


def _checksum(row: Mapping[str, str]) -> str:
    """Return the CRC-32 of the names and texts of a row without the checksum."""
    texts = {name: text for name, text in row.items() if name != CHECKSUM}
    return f"{zlib.crc32(json.dumps(texts, sort_keys=True).encode()):08x}"
