"""Zip archives of files with force curves."""

from __future__ import annotations

import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from ase_roughcontact._util.files import PathName

# Number of files that a message names.
_NAMED = 4


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
    with zipfile.ZipFile(file) as archive, TemporaryDirectory() as folder:
        names = sorted(name for name in archive.namelist() if name[-1] != "/")
        name = _chosen(file, names, curve)
        path = Path(archive.extract(name, folder))
        try:
            yield path
        except ValueError as error:
            message = str(error).replace(str(path), f"{file}/{name}")
            raise ValueError(message) from error


def _chosen(file: PathName, names: list[str], curve: int | str | None) -> str:
    """Return the name of a file among several."""
    if curve is None and len(names) == 1:
        return names[0]
    if isinstance(curve, int) and 1 <= curve <= len(names):
        return names[curve - 1]
    if isinstance(curve, str) and curve in names:
        return curve
    listed = ", ".join(names[:_NAMED]) + (", ..." if len(names) > _NAMED else "")
    given = "" if curve is None else f", got {curve}"
    raise ValueError(
        f"{file} contains {len(names)} files ({listed}): choose one by --curve, its "
        f"name or a number from 1 to {len(names)}{given}"
    )
