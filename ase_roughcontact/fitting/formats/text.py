"""Tables with names of columns; exports of NanoScope, Chiaro and spreadsheets.

Above the names there may be other lines: a header of lines that begin with a backslash
(NanoScope) or with ``#``, or lines that have another number of cells (Chiaro).
"""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.units import LENGTHS, UNITS
from ase_roughcontact.fitting.formats.table import (
    SEGMENTS,
    CurveTable,
    Position,
    Segment,
    TextColumn,
    segment_kind,
)

# Name and unit: "Height (nm)", "Force [nN]", "z / nm".
_HEAD = re.compile(r"\s*([^([/]*?)\s*(?:[([/]\s*(.*?)\s*[])]?)?\s*")
# One of several names with units between blanks.
_HEADS = re.compile(r"[^\s([/]+(?:\s*[([][^])]*[])]|\s*/\s*\S+)?")
# Branches in the names of columns of NanoScope: Height_Sensor_nm_Ex, Calc_Ramp_Rt_nm.
_BRANCHES = {"Ex": "approach", "Rt": "retraction"}
# Whether heights increase away from the surface, by their names: NanoScope's ramp
# increases towards it.
_AWAY = {"distance": True, "calc ramp": False, "ramp": False}
# A number in a header.
_NUMBER = r"([-+\d.eE]+)"
# Stiffness of the cantilever in headers of NanoScope and Chiaro.
_STIFFNESS = re.compile(rf"^\W*(?:\\Spring Constant:|k \(N/m\)) *\t?{_NUMBER}", re.M)
# Place on the sample in a comment: "# x (um): 2.5".
_PLACE = re.compile(
    r"^# *([xy]) *\((\w+)\) *[:=] *([-+]?\d+\.?\d*(?:[eE][-+]?\d+)?)", re.M
)
# Sensitivity in headers of NanoScope.
_SENSITIVITY = re.compile(rf"\\@Sens\. DeflSens: V {_NUMBER} nm/V")


def read_text(
    file: PathName, lines: Mapping[int, str], heads: Sequence[str] = ()
) -> CurveTable:
    """Return the segments of a table.

    Parameters
    ----------
    file : path
        Name of the file, for messages.
    lines : mapping of int to str
        Lines that are not blank by their numbers.
    heads : sequence of str
        Names and units of the columns in place of those in the file.

    Returns
    -------
    CurveTable
        Segments by the names of the columns, or by a column ``branch``; else the rows
        are one segment.

    Raises
    ------
    ValueError
        If there are no names, no rows, two columns of one name, or rows of more cells.
    """
    names, rows = _rows(lines)
    names = [name.strip() for name in heads or names]
    _check(file, names, rows)
    text = "\n".join(lines.values())
    return CurveTable(
        _segments(file, names, rows),
        _found(_STIFFNESS, text, UNITS["N/m"]),
        _found(_SENSITIVITY, text, UNITS["nm"]),
        _position(text),
    )


def _rows(lines: Mapping[int, str]) -> tuple[list[str], dict[int, list[str]]]:
    """Return the names of the columns, and the rows by their lines.

    Names are in the first row without numbers that is as long as most and has a row
    with numbers below it, or in the comment above the rows, as by `numpy.savetxt`.
    """
    kept = {i: x for i, x in lines.items() if x[0] not in "#\\" and x[:2] != '"\\'}
    kept = {i: x.strip(" ") for i, x in kept.items() if x[:4] != "sep="}  # for Excel
    if not kept:
        return [], {}
    delimiter = _delimiter(kept.values())
    numbers, ended = list(kept), [f"{line}\n" for line in kept.values()]
    reader = csv.reader(ended, delimiter=delimiter, skipinitialspace=True)
    # a cell in quotes may have line breaks: the row is at its last line
    rows: dict[int, list[str]] = {}
    for row in reader:
        rows[numbers[reader.line_num - 1]] = row
    usual = max(Counter(map(len, rows.values())).items(), key=lambda each: each[1])[0]
    following = [*list(rows.values())[1:], ["0"]]
    best, head = 0, 0
    for (line, row), below in zip(rows.items(), following, strict=True):
        is_head = len(row) >= usual and not any(map(_is_number, row))
        if is_head and any(map(_is_number, below)):
            quality = 1 + (len(row) == usual) + (len(below) == usual)
            if quality > best:
                best, head = quality, line
    if best:
        cells = _HEADS.findall(kept[head]) if delimiter == " " else rows[head]
        names = [" ".join(cell.split()) for cell in cells]
        return names, {line: row for line, row in rows.items() if line > head}
    first = next(iter(rows))
    above = [x for i, x in lines.items() if i < first]
    return _names(above[-1].lstrip("# "), delimiter) if above else [], rows


def _delimiter(lines: Iterable[str]) -> str:
    """Return the delimiter of the cells in most lines."""
    lines = list(lines)
    for delimiter in "\t;,":
        if 2 * sum(delimiter in line for line in lines) >= len(lines):
            return delimiter
    return " "


def _names(line: str, delimiter: str) -> list[str]:
    """Return the names in a comment."""
    if delimiter == " ":
        return _HEADS.findall(line)
    return next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])


def _check(
    file: PathName, names: Sequence[str], rows: Mapping[int, Sequence[str]]
) -> None:
    """Raise `ValueError` for names that are missing or not unique, and long rows."""
    if not rows:
        raise ValueError(f"{file} contains no rows of numbers: export the curve again")
    if not any(names):
        raise ValueError(
            f"{file} begins with numbers, not with names of columns: give them, "
            'such as --columns "distance (nm), force (nN)"; an export of NT-MDT Nova '
            'is read with --sensitivity "50 nm/nA"'
        )
    if twice := next((x for i, x in enumerate(names) if x and x in names[:i]), ""):
        raise ValueError(
            f"{file} has the column {twice} twice: name the columns of approach and "
            'retraction by --columns "Height_nm_Ex, Force_nN_Ex, Height_nm_Rt, '
            'Force_nN_Rt", or write one below the other'
        )
    for line, row in rows.items():
        if any(row[len(names) :]):
            raise ValueError(
                f"{file}, line {line}: {len(row)} values for the {len(names)} columns "
                f"{', '.join(names)}. If commas are decimal points, columns must be "
                "separated by semicolons or tabs; else give names and units of all "
                "columns: --columns"
            )


def _segments(
    file: PathName, names: Sequence[str], rows: Mapping[int, Sequence[str]]
) -> list[Segment]:
    """Return the segments of rows."""
    if "branch" in names:
        at = names.index("branch")
        return [
            Segment(kind, _columns(names, part)[None])
            for kind, part in _by_branch(file, rows, at)
        ]
    columns = _columns(names, rows)
    if len(columns) > 1:  # columns without a branch, such as numbers of the points
        columns.pop(None, None)
    return [Segment(kind, part) for kind, part in columns.items()]


def _by_branch(
    file: PathName, rows: Mapping[int, Sequence[str]], at: int
) -> list[tuple[str, dict[int, Sequence[str]]]]:
    """Return kinds and rows of segments from the cells of a column."""
    found: list[tuple[str, dict[int, Sequence[str]]]] = []
    for line, row in rows.items():
        name = row[at] if at < len(row) else ""
        kind = segment_kind(name)
        if kind is None:
            raise ValueError(
                f"{file}, line {line}: branch must be one of {', '.join(SEGMENTS)}, "
                f"got {name!r}"
            )
        if not found or found[-1][0] != kind:
            found.append((kind, {}))
        found[-1][1][line] = row
    return found


def _columns(
    names: Sequence[str], rows: Mapping[int, Sequence[str]]
) -> dict[str | None, list[TextColumn]]:
    """Return the columns of rows by the branches in their names."""
    found: dict[str | None, list[TextColumn]] = {}
    for number, head in enumerate(names):
        name, unit, branch = _parsed(head)
        cells = [
            (line, row[number] if number < len(row) else None)
            for line, row in rows.items()
        ]
        if branch:  # the shorter branch ends with empty cells
            cells = [(line, cell) for line, cell in cells if cell]
        column = TextColumn(head, name, unit, _AWAY.get(name), cells)
        found.setdefault(branch, []).append(column)
    return found


def _parsed(head: str) -> tuple[str, str | None, str | None]:
    """Return name, unit and branch of a head."""
    words = head.split("_")
    at = next((i for i, word in enumerate(words) if word in _BRANCHES), None)
    if at is None:
        found = _HEAD.fullmatch(head)
        return (found[1].lower(), found[2], None) if found else ("", None, None)
    # the unit is the word after or before the branch: Calc_Ramp_Ex_nm, Defl_nm_Ex
    unit = at + 1 if at + 1 < len(words) else at - 1
    name = " ".join(word for i, word in enumerate(words) if i not in (at, unit))
    return name.lower(), words[unit], _BRANCHES[words[at]]


def _found(pattern: re.Pattern[str], text: str, unit: float) -> float | None:
    """Return a number of a header in ASE's units; None if it is missing."""
    found = pattern.search(text)
    return float(found[1]) * unit if found else None


def _position(text: str) -> Position | None:
    """Return the place on the sample by comments; None if it is missing."""
    found = {
        axis: float(value) * LENGTHS[unit]
        for axis, unit, value in _PLACE.findall(text)
        if unit in LENGTHS
    }
    return Position(found["x"], found["y"]) if len(found) == 2 else None


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True
