"""Reader of a force curve in any format."""

from __future__ import annotations

from codecs import BOM_UTF16_BE, BOM_UTF16_LE
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
from ase_roughcontact.fitting.formats.instrument import read_instrument
from ase_roughcontact.fitting.formats.jpk_map import (
    count_jpk_curves,
    is_jpk_map,
    jpk_positions,
    single_curve,
)
from ase_roughcontact.fitting.formats.jpk_text import is_jpk_text, read_jpk_text
from ase_roughcontact.fitting.formats.table import Calibration, CurveTable, Position
from ase_roughcontact.fitting.formats.text import read_text

# First lines of texts that afmformats reads, of itself and of AFM workshop.
_TEXTS_OF_AFMFORMATS = ("# afmformats ", "Force-Distance Curve")
# First line of files of NanoScope, also of the binary ones.
_NANOSCOPE = (b"\\*Force file list", b"\\*EC File list", b"?*Force file list")


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
    if is_archive(file):
        with unpacked(file, curve) as path:
            return read_table(path, heads, None, calibration)
    number = _number(file, curve)
    if is_jpk_map(file):
        with single_curve(file, number) as path:
            table = read_instrument(path, 1, calibration)
        return replace(table, count=count_jpk_curves(file))
    data = Path(file).read_bytes()
    if Path(file).suffix.lower() == ".ibw":
        return read_asylum(file)
    is_wide = data[:2] in (BOM_UTF16_LE, BOM_UTF16_BE)
    if b"\0" in data and not is_wide:
        if data.startswith(_NANOSCOPE):
            raise ValueError(
                f"{file} is a binary file of NanoScope, which is not read: export it "
                "as text in NanoScope Analysis, with header, ramp and deflection"
            )
        return read_instrument(file, number, calibration)
    text = _text(data, is_wide)
    if text.startswith(_TEXTS_OF_AFMFORMATS) or calibration.per != "V":
        return read_instrument(file, number, calibration)
    lines = {i: x for i, x in enumerate(text.splitlines(), start=1) if x.strip()}
    return read_jpk_text(lines) if is_jpk_text(text) else read_text(file, lines, heads)


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


def _text(data: bytes, is_wide: bool) -> str:
    """Return the text of a file."""
    try:
        return data.decode("utf-16" if is_wide else "utf-8-sig")
    except UnicodeDecodeError:  # texts of older programs
        return data.decode("latin-1")
