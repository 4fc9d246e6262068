"""Zip archives of files with force curves."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

from ase_roughcontact._util.files import PathName

# Digits in a name, which are kept as parts.
_DIGITS = re.compile(r"(\d+)")
# Largest number of files that a message names.
_MAX_NAMED = 4


def is_archive(file: PathName) -> bool:
    """Return whether a file is a zip archive; JPK's files are, by another suffix."""
    return Path(file).suffix.lower() == ".zip" and zipfile.is_zipfile(file)


@contextmanager
def unpacked(file: PathName, curve: int | str | None) -> Iterator[Path]:
    """Unpack a file of an archive into a temporary folder.

    Parameters
    ----------
    file : path
        Archive.
    curve : int or str, optional
        Name of the file in it, or its number in the order of the names, from 1.

    Yields
    ------
    Path

    Raises
    ------
    ValueError
        If there are several files and none is chosen, or the chosen file is missing.
        Errors in reading the file name the archive.
    """
    archive = _opened(str(file), changed_at(file))
    name = _chosen(file, _names(archive), curve)
    with TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        path = Path(archive.extract(name, folder))
        with renamed_in_errors(path, f"{file}/{name}"):
            yield path


def archived_names(file: PathName) -> list[str]:
    """Return the names of the files in an archive, in their order."""
    return _names(_opened(str(file), changed_at(file)))


def changed_at(file: PathName) -> int:
    """Return the time when a file was changed (ns)."""
    return Path(file).stat().st_mtime_ns


@contextmanager
def renamed_in_errors(path: Path, name: str) -> Iterator[None]:
    """Replace the path of a temporary file by another name in a `ValueError`."""
    try:
        yield
    except ValueError as error:
        raise ValueError(str(error).replace(str(path), name)) from error


@lru_cache(maxsize=2)
def _opened(file: str, changed: int) -> zipfile.ZipFile:
    """Open an archive; it stays open for its other files, until it has changed."""
    return zipfile.ZipFile(file)


def _names(archive: zipfile.ZipFile) -> list[str]:
    """Return the sorted names of files, without folders and what macOS adds."""
    names = (name for name in archive.namelist() if name[-1] != "/")
    kept = (name for name in names if not name.startswith("__MACOSX/"))
    return sorted(kept, key=name_order)


def name_order(name: str) -> list[tuple[bool, int, str]]:
    """Return the key by which names are sorted: 2 before 10, as numbers in them."""
    parts = _DIGITS.split(name)
    return [
        (part.isdecimal(), int(part) if part.isdecimal() else 0, part) for part in parts
    ]


def _chosen(file: PathName, names: list[str], curve: int | str | None) -> str:
    """Return the name of a file among several."""
    if curve is None and len(names) == 1:
        return names[0]
    if isinstance(curve, int) and 1 <= curve <= len(names):
        return names[curve - 1]
    if isinstance(curve, str) and curve in names:
        return curve
    listed = ", ".join(names[:_MAX_NAMED]) + (
        ", ..." if len(names) > _MAX_NAMED else ""
    )
    given = "" if curve is None else f", got {curve}"
    raise ValueError(
        f"{file} contains {len(names)} files ({listed}): choose one by --curve, its "
        f"name or a number from 1 to {len(names)}{given}"
    )
