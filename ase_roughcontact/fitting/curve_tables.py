"""Columns of force curves: tables, text exports of Bruker and JPK, binary formats."""

from __future__ import annotations

import csv
import re
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path
from typing import TypeAlias

import numpy as np

from ase_roughcontact._util.extras import imported, silenced
from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, finite, shown

# Number of bytes at the beginning of a file that tell text from other formats.
_FIRST = 4096
# Name and unit: "Height (nm)", "Force [nN]", "z / nm"; and several of them between
# blanks.
_HEAD = re.compile(r"\s*([^([/]*?)\s*(?:[([/]\s*(.*?)\s*[])]?)?\s*")
_HEADS = re.compile(r"[^\s([/]+(?:\s*[([][^])]*[])]|\s*/\s*\S+)?")
# Branches in the names of columns of NanoScope (Height_Sensor_nm_Ex, Calc_Ramp_Rt_nm),
# of segments of JPK, and by numbers in afmformats.
_WAYS = {"Ex": "approach", "Rt": "retraction"}
_SEGMENTS = {"extend": "approach", "retract": "retraction"}
_NUMBERS = {0: "approach", 1: "retraction"}
# Stiffness of the cantilever and length per V in headers of NanoScope and JPK.
_NUMBER = r"([-+\d.eE]+)"
_CALIBRATION = (
    ("N/m", re.compile(rf"(?:\\Spring Constant|# springConstant): {_NUMBER}")),
    ("nm", re.compile(rf"\\@Sens\. DeflSens: V {_NUMBER} nm/V")),
    ("m", re.compile(rf"# sensitivity: {_NUMBER}")),
)


@dataclass(frozen=True)
class Column:
    """Column of a table.

    Attributes
    ----------
    head : str
        As it is in the file.
    name : str
        In lower case, without the unit.
    unit : str or None
        None if the file gives none.
    cells : sequence of (int, str, float or None)
        Lines of the file, and what they contain.
    """

    head: str
    name: str
    unit: str | None
    cells: Sequence[tuple[int, str | float | None]]

    def numbers(self, file: PathName) -> FloatArray:
        """Return the values, or raise `ValueError` with the line of a wrong one."""
        numbers = []
        for line, cell in self.cells:
            try:
                value = float(str(cell).replace(",", "."))
                finite(**{self.head: value})
            except ValueError as error:
                raise ValueError(
                    f"{file}, line {line}: {self.head} must be a finite number, got "
                    f"{shown(cell)}: correct the line, or delete it"
                ) from error
            numbers.append(value)
        return np.array(numbers)


# Columns of each part of a curve, with its branch if that is known.
Segments: TypeAlias = list[tuple[str | None, list[Column]]]


@dataclass(frozen=True)
class CurveTable:
    """Columns of a file with a force curve.

    Attributes
    ----------
    segments : list of (str or None, list of Column)
        Approach and retraction, or None for rows in the order of the measurement.
    stiffness, sensitivity : float or None
        Of the cantilever (eV/Å^2), and its deflection per V (Å), if the file has them.
    """

    segments: Segments
    stiffness: float | None = None
    sensitivity: float | None = None


def read_table(
    file: PathName, branch: str | None = None, heads: Sequence[str] = ()
) -> CurveTable:
    """Read the columns of a file.

    Parameters
    ----------
    file : path
    branch : str, optional
        "approach" or "retraction": a value of the column ``branch``, or a segment.
    heads : sequence of str
        Names and units of the columns in place of those in the file, which may have
        none.

    Returns
    -------
    CurveTable

    Raises
    ------
    ValueError
        If there are no rows, or no names of columns.
    ImportError
        If the file is not text, and afmformats is missing.
    """
    data = Path(file).read_bytes()
    wide = data[:2] in (BOM_UTF16_LE, BOM_UTF16_BE)
    if b"\0" in data[:_FIRST] and not wide:
        table = _of_instrument(file)
    else:
        try:
            text = data.decode("utf-16" if wide else "utf-8-sig")
        except UnicodeDecodeError:  # of older programs
            text = data.decode("latin-1")
        lines = {i: x for i, x in enumerate(text.splitlines(), start=1) if x.strip()}
        is_jpk = re.search(r"^# segment: ", text, re.M)
        found = _jpk(lines) if is_jpk else _columns(file, lines, branch, heads)
        table = CurveTable(found, *_calibration(text))
    segments = [each for each in table.segments if branch in (None, each[0])]
    if not any(column.cells for _, columns in segments for column in columns):
        of_branch = f" of the branch {branch!r}" if branch else ""
        raise ValueError(f"{file} contains no rows{of_branch}")
    return replace(table, segments=segments)


def _rows(lines: dict[int, str]) -> tuple[list[str], dict[int, list[str]]]:
    """Return the names of the columns of a table, and its rows by their lines.

    Names are in the first row, or in the comment above it, as by `numpy.savetxt`.
    """
    kept = {i: x for i, x in lines.items() if x[0] not in "#\\" and x[:2] != '"\\'}
    kept = {i: x.strip(" ") for i, x in kept.items() if x[:4] != "sep="}  # of Excel
    at, line = next(iter(kept.items()), (0, ""))
    delimiter = next((each for each in "\t;," if each in line), " ")

    def cells(texts: Iterable[str]) -> Iterator[list[str]]:
        return csv.reader(texts, delimiter=delimiter, skipinitialspace=True)

    rows = dict(zip(kept, cells(kept.values()), strict=True))
    if _are_numbers(rows.get(at, [])):
        line = next((x for i, x in reversed(lines.items()) if i < at), "").lstrip("# ")
    else:
        rows.pop(at, None)
    if delimiter == " ":
        names = _HEADS.findall(line)
    else:
        names = next(cells([line]), [])
    return [name.strip() for name in names], rows


def _columns(
    file: PathName, lines: dict[int, str], branch: str | None, heads: Sequence[str]
) -> Segments:
    """Return the columns of a table, and of an export of NanoScope."""
    names, rows = _rows(lines)
    first = [each.strip() for each in heads or names]
    if not any(first):
        raise ValueError(
            f"{file} begins with numbers, not with names of columns: give them, "
            'such as --columns "distance (nm), force (nN)"'
        )
    if twice := next((x for i, x in enumerate(first) if x and x in first[:i]), ""):
        raise ValueError(
            f"{file}: the column {twice} is there twice: name those of approach and "
            'retraction by --columns "Height_nm_Ex, Force_nN_Ex, Height_nm_Rt, '
            'Force_nN_Rt", or write one below the other'
        )
    for line, row in rows.items():
        if any(row[len(first) :]):
            raise ValueError(
                f"{file}, line {line}: {len(row)} values for the {len(first)} columns "
                f"{', '.join(first)}. If commas are decimal points, columns must be "
                "separated by semicolons or tabs; else give names and units of all "
                "columns: --columns"
            )
    if "branch" in first and branch is not None:
        at = first.index("branch")
        rows = {i: row for i, row in rows.items() if row[at : at + 1] == [branch]}
    found: dict[str | None, list[Column]] = {}
    for number, head in enumerate(first):
        name, unit, way = _parsed(head)
        cells = _cells(rows, number)
        if way:  # the shorter branch ends with empty cells
            cells = [(i, cell) for i, cell in cells if cell]
        elif "branch" in first:
            way = branch
        found.setdefault(way, []).append(Column(head, name, unit, cells))
    return list(found.items())


def _parsed(head: str) -> tuple[str, str | None, str | None]:
    """Return name, unit and branch of a head."""
    words = head.split("_")
    at = next((i for i, word in enumerate(words) if word in _WAYS), None)
    if at is None:
        found = _HEAD.fullmatch(head)
        return (found[1].lower(), found[2], None) if found else ("", None, None)
    # the unit is the word after or before the branch: Calc_Ramp_Ex_nm, Defl_nm_Ex
    unit = at + 1 if at + 1 < len(words) else at - 1
    name = " ".join(word for i, word in enumerate(words) if i not in (at, unit))
    return name.lower(), words[unit], _WAYS[words[at]]


def _jpk(lines: dict[int, str]) -> Segments:
    """Return approach and retraction of a text export of JPK, without pauses."""
    found: Segments = []
    header: dict[str, str] = {}
    for is_header, group in groupby(lines.items(), lambda each: each[1][0] == "#"):
        if is_header:
            header = dict(line[1:].strip().partition(": ")[::2] for _, line in group)
        elif way := _SEGMENTS.get(header.get("segment", "")):
            cells = {number: line.split() for number, line in group}
            names, units = (header.get(key, "").split() for key in ("columns", "units"))
            units += len(names) * [""]
            columns = [
                Column(name, name.lower(), units[i] or None, _cells(cells, i))
                for i, name in enumerate(names)
            ]
            found.append((way, columns))
    return found


def _cells(rows: dict[int, list[str]], number: int) -> list[tuple[int, str | None]]:
    """Return lines and cells of a column, None where a row is shorter."""
    return [(i, row[number] if number < len(row) else None) for i, row in rows.items()]


def _calibration(text: str) -> tuple[float | None, float | None]:
    """Return stiffness (eV/Å^2) and sensitivity (Å/V) that a header contains."""
    found = ((unit, pattern.search(text)) for unit, pattern in _CALIBRATION)
    stiffness, nanometres, metres = (
        float(value[1]) * UNITS[unit] if value else None for unit, value in found
    )
    return stiffness, nanometres or metres


def _of_instrument(file: PathName) -> CurveTable:
    """Return the curve of a file in a format of an instrument."""
    need = f"{file} needs the package afmformats"
    afmformats = imported("afmformats", "curves", need, "; or export the curve as text")
    try:
        with silenced():
            curves = afmformats.load_data(file)
    except (Exception, afmformats.errors.AFMFileFormatError) as error:
        raise ValueError(f"cannot read a force curve from {file}: {error}") from error
    if len(curves) != 1:
        raise ValueError(
            f"{file} contains {len(curves)} force curves, not one: export one of them"
        )
    (curve,) = curves
    with silenced():  # columns are read when they are needed
        number, stiffness = curve["segment"], curve.metadata.get("spring constant")
        found = {name: curve[name] for name in _AFMFORMATS if name in curve}
    segments: Segments = []
    for segment, way in _NUMBERS.items():
        columns = [
            Column(name, name, unit, list(enumerate(found[name][number == segment])))
            for name, unit in _AFMFORMATS.items()
            if name in found
        ]
        segments.append((way, columns))
    return CurveTable(segments, stiffness and stiffness * UNITS["N/m"])


# Columns of afmformats, in SI units.
_AFMFORMATS = {"force": "N", "height (measured)": "m", "height (piezo)": "m"}


def _are_numbers(cells: Iterable[str]) -> bool:
    try:
        return bool([float(cell.replace(",", ".")) for cell in cells if cell])
    except ValueError:
        return False
