"""Safe writing of files: completely or not at all, and named in errors."""

from __future__ import annotations

import csv
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from itertools import zip_longest
from pathlib import Path
from typing import IO, Any

if sys.version_info >= (3, 11):
    import tomllib as tomllib
else:
    import tomli as tomllib  # noqa: F401

PathName = str | os.PathLike


def check_is_there(name: PathName, file: IO[Any]) -> None:
    """Raise `OSError` if an open file is not the one of a name any more."""
    if not is_file_of_name(name, file):
        raise OSError(
            f"{os.fspath(name)} was removed or replaced while it was written: all "
            "finished steps are in the restart file, if there is one; start again to "
            "go on"
        )


def is_file_of_name(name: PathName, file: IO[Any]) -> bool:
    """Return whether a name still belongs to an open file."""
    try:
        return os.path.samestat(os.fstat(file.fileno()), os.stat(name))
    except FileNotFoundError:
        return False


@contextmanager
def replaced(file: PathName) -> Iterator[str]:
    """Yield the name of a new file that replaces another one when it is complete.

    A symbolic link is replaced, not followed.
    """
    new = f"{os.fspath(file)}.new"
    Path(new).unlink(missing_ok=True)
    try:
        with named_in_errors(file):
            yield new
        os.replace(new, file)
    except BaseException:
        Path(new).unlink(missing_ok=True)
        raise


@contextmanager
def named_in_errors(file: PathName) -> Iterator[None]:
    """Add the name of a file to errors that occur while the file is written."""
    try:
        yield
    except OSError as error:
        if error.filename is not None:
            raise
        full = f"the disk is full, or a limit of sizes reached ({error})"
        cause = error.strerror or full
        raise OSError(f"can't write {os.fspath(file)}: {cause}") from error


def table_rows(lines: Iterable[str]) -> Iterator[dict[str, str]]:
    """Yield the rows of a CSV file by the names of the columns, without their units."""
    rows = csv.reader(lines)
    names = [head.partition(" (")[0] for head in next(rows, [])]
    for row in filter(None, rows):
        yield dict(zip_longest(names, row[: len(names)], fillvalue=""))


@contextmanager
def table_writer(
    file: PathName, columns: Mapping[str, str], rows: Iterable[Mapping[str, Any]]
) -> Iterator[Callable[[Mapping[str, Any]], None]]:
    """Replace a CSV file by a new one, and yield a function that writes a further row.

    The mapping `columns` has heads, such as ``"height (Å)"``, by name. The first rows
    may be read from the old file. Missing values are empty; values without a column are
    left out. A table without rows is removed at the end. A symbolic link is refused.
    """
    refuse_link(file)
    with replaced(file) as new, open(new, "w", newline="", encoding="utf-8") as first:
        table = csv.DictWriter(first, list(columns), extrasaction="ignore")
        table.writerow(columns)
        empty = first.tell()
        table.writerows(rows)
    # not before it has its name: Windows replaces no open file
    opened = open(file, "a", newline="", encoding="utf-8")  # noqa: SIM115
    table = csv.DictWriter(opened, list(columns), extrasaction="ignore")

    def write(row: Mapping[str, Any]) -> None:
        check_is_there(file, opened)
        with named_in_errors(file):
            table.writerow(row)
            opened.flush()

    try:
        yield write
    finally:
        with named_in_errors(file), opened:
            without_rows = opened.tell() == empty
        if without_rows:
            Path(file).unlink(missing_ok=True)


def write_table(
    file: PathName, heads: Iterable[str], rows: Iterable[Iterable[Any]]
) -> None:
    """Write a CSV file, which replaces an older one when it is complete."""
    with (
        replaced(file) as name,
        open(name, "w", newline="", encoding="utf-8") as stream,
    ):
        writer = csv.writer(stream)
        writer.writerow(heads)
        writer.writerows(rows)


def check_replaced(file: Path, mark: bytes) -> None:
    """Raise `ValueError` if a file has no folder, or another file would be lost.

    A file may be replaced if it is empty, contains the mark of the package's files, or
    is a link, which is replaced itself.
    """
    if not file.parent.is_dir():
        raise ValueError(f"there is no folder {file.parent} for {file.name}")
    kept = file.is_symlink() or not file.is_file() or file.stat().st_size == 0
    if not kept and mark not in file.read_bytes():
        raise ValueError(
            f"{file} was not written by this version of ase-roughcontact and would be "
            "overwritten: give another name, or delete it"
        )


def check_different(**files: PathName) -> None:
    """Raise `ValueError` if two files, named for their purpose, are the same."""
    found: dict[Path, str] = {}
    for name, file in files.items():
        other = found.setdefault(Path(file).resolve(), name)
        if other != name:
            raise ValueError(
                f"{other} and {name} are one file, {os.fspath(file)}: give two names"
            )


def refuse_link(file: PathName) -> None:
    """Raise `OSError` if a file is a symbolic link."""
    if Path(file).is_symlink():
        raise OSError(
            f"{os.fspath(file)} is a symbolic link, and its target would be changed: "
            "remove the link, or name the file itself"
        )
