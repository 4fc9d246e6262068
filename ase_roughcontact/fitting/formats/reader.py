"""Reader of a force curve in any format."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from ase_roughcontact._util.files import PathName
from ase_roughcontact.fitting.formats.archive import (
    archived_names,
    is_archive,
    unpacked,
)
from ase_roughcontact.fitting.formats.asylum import read_asylum
from ase_roughcontact.fitting.formats.curve_format import (
    FORMATS,
    CurveFile,
    CurveFormat,
)
from ase_roughcontact.fitting.formats.instrument import read_instrument
from ase_roughcontact.fitting.formats.jpk_map import (
    count_jpk_curves,
    is_jpk_map,
    jpk_positions,
    single_curve,
)
from ase_roughcontact.fitting.formats.jpk_text import is_jpk_text, read_jpk_text
from ase_roughcontact.fitting.formats.nanoscope import is_nanoscope, read_nanoscope
from ase_roughcontact.fitting.formats.table import Calibration, CurveTable, Position
from ase_roughcontact.fitting.formats.text import read_text
from ase_roughcontact.fitting.formats.uff import UFF_START, read_uff

# First words of texts that afmformats reads: its own and the texts of AFM workshop.
_AFMFORMATS_STARTS = ("# afmformats ", "Force-Distance Curve")
# Endings of the names of files with one curve each.
_SINGLE_CURVE_ENDINGS = (".jpk-force", ".ibw", ".csv", ".txt")


def read_table(
    file: PathName,
    heads: Sequence[str] = (),
    curve: int | str | None = None,
    calibration: Calibration | None = None,
) -> CurveTable:
    """Read the segments of a force curve.

    Parameters
    ----------
    file : path
        Text, file of an instrument, or zip archive of such files.
    heads : sequence of str
        Names and units of the columns of a text in place of those in the file.
    curve : int or str, optional
        Number of the curve in the file, from 1; in an archive also the name of a file.
    calibration : Calibration, optional
        Calibration for files that can't be read without it.

    Returns
    -------
    CurveTable

    Raises
    ------
    ValueError
        If the format can't be read, or there are no rows.
    ImportError
        If a package that reads the format is missing.
    """
    calibration = calibration or Calibration()
    if Path(file).is_dir():
        raise ValueError(
            f"{file} is a folder: give one of its files, or use the command curves"
        )
    if is_archive(file):
        with unpacked(file, curve) as path:
            return read_table(path, heads, None, calibration)
    found = CurveFile(Path(file), _number(file, curve), heads, calibration)
    formats = (*FORMATS.values(), *_PACKAGE_FORMATS)
    return next(each for each in formats if each.recognises(found)).read(found)


def count_curves(file: PathName, calibration: Calibration | None = None) -> int:
    """Return the number of curves in a file, or of files in an archive.

    Parameters
    ----------
    file, calibration
        See `read_table`.

    Raises
    ------
    ValueError, ImportError
        See `read_table`.
    """
    if is_archive(file):
        return len(archived_names(file))
    if is_jpk_map(file):
        return count_jpk_curves(file)
    if not FORMATS and Path(file).suffix.lower() in _SINGLE_CURVE_ENDINGS:
        return 1
    return read_table(file, curve=1, calibration=calibration).count


def read_positions(
    file: PathName, calibration: Calibration | None = None
) -> list[Position | None]:
    """Return the places on the sample of all curves in a file.

    Parameters
    ----------
    file, calibration
        See `read_table`.

    Raises
    ------
    ValueError, ImportError
        See `read_table`.
    """
    if is_jpk_map(file):
        return jpk_positions(file)
    numbers = range(1, count_curves(file, calibration) + 1)
    return [
        read_table(file, curve=number, calibration=calibration).position
        for number in numbers
    ]


def _number(file: PathName, curve: int | str | None) -> int | None:
    """Return the number of a curve in a file that is no archive."""
    if isinstance(curve, str):
        raise ValueError(
            f"{file} is no archive, its curves have no names: give a number by "
            f"--curve, got {curve!r}"
        )
    return curve


def _by_afmformats(file: CurveFile) -> bool:
    """Return whether afmformats reads a file; texts of NT-MDT have signals in nA."""
    is_known = file.text.startswith(_AFMFORMATS_STARTS)
    return not file.is_text or is_known or file.calibration.per != "V"


def _read_jpk_map(file: CurveFile) -> CurveTable:
    """Return a curve of a map of JPK."""
    with single_curve(file.path, file.curve) as path:
        table = read_instrument(path, 1, file.calibration)
    return replace(table, count=count_jpk_curves(file.path))


# Formats of the package, in order: the first one that recognises a file reads it.
_PACKAGE_FORMATS = (
    CurveFormat(lambda file: is_jpk_map(file.path), _read_jpk_map),
    CurveFormat(
        lambda file: file.path.suffix.lower() == ".ibw",
        lambda file: read_asylum(file.path),
    ),
    CurveFormat(
        lambda file: not file.is_text and is_nanoscope(file.data),
        lambda file: read_nanoscope(file.path, file.data, file.curve),
    ),
    CurveFormat(
        lambda file: file.text.startswith(UFF_START),
        lambda file: read_uff(file.path, file.lines),
    ),
    CurveFormat(
        _by_afmformats,
        lambda file: read_instrument(file.path, file.curve, file.calibration),
    ),
    CurveFormat(
        lambda file: is_jpk_text(file.text),
        lambda file: read_jpk_text(file.lines),
    ),
    CurveFormat(
        lambda file: True,
        lambda file: read_text(file.path, file.lines, file.heads),
    ),
)
