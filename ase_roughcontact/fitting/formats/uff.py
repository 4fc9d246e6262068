"""Text files in the unified format (.uff) of PyFMReader.

Lines that begin with ``HE`` are ``key: value``; other lines are points, with the code
of their segment, its number, and the columns. Heights are in m, deflections in V, and
times in s, whatever the keys for units are, in which the library writes titles.
"""

from __future__ import annotations

from collections.abc import Mapping

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.formats.table import (
    CurveTable,
    Segment,
    TextColumn,
    segment_kind,
)

#: First characters of a file.
UFF_START = "HE UFF_code"
# Largest number of columns: heights, signals of the photodiode, times.
_MAX_COLUMNS = 10
# Names and units of the columns by their titles.
_COLUMNS = {
    "height": ("height", "m"),
    "displacement": ("height", "m"),
    "vdeflection": ("deflection", "V"),
    "deflection": ("deflection", "V"),
    "time": ("time", "s"),
}


def read_uff(file: PathName, lines: Mapping[int, str]) -> CurveTable:
    """Return the segments of a file.

    Parameters
    ----------
    file : path
        Name of the file, for messages.
    lines : mapping of int to str
        Lines that are not blank by their numbers.

    Returns
    -------
    CurveTable

    Raises
    ------
    ValueError
        If the first segment has no title of a column that is known.
    """
    head: dict[str, str] = {}
    rows: dict[int, list[tuple[int, list[str]]]] = {}
    for line, text in lines.items():
        if text.startswith("HE "):
            key, _, value = text[3:].partition(":")
            head[key.strip()] = value.strip(' "')
        else:
            cells = text.split()
            rows.setdefault(int(cells[1]), []).append((line, cells[2:]))
    titles = (
        head.get(f"Recording_segment_0_col_{i}_title", "") for i in range(_MAX_COLUMNS)
    )
    # of later segments titles may be missing
    names = [_COLUMNS.get(title.lower()) for title in titles]
    if not rows or not any(names):
        raise ValueError(
            f"{file} has no points, or none of the columns {', '.join(_COLUMNS)}: "
            "export the curve as text"
        )
    segments = []
    for number, points in rows.items():
        kind = segment_kind(head.get(f"Recording_segment_{number}_type", ""))
        columns = [
            TextColumn(
                f"{name[0]} ({name[1]})",
                *name,
                None,
                [
                    (line, cells[i] if i < len(cells) else None)
                    for line, cells in points
                ],
            )
            for i, name in enumerate(names)
            if name is not None
        ]
        segments.append(Segment(kind, columns))
    return CurveTable(
        segments,
        _positive(head, "Cantilever_springK_used(N/m)", UNITS["N/m"]),
        _positive(head, "Recording_inv_optical_lever_sens_used(m/V)", UNITS["m"]),
    )


def _positive(head: Mapping[str, str], key: str, unit: float) -> float | None:
    """Return a positive number of the head in ASE's units; None without one."""
    try:
        value = float(head[key])
    except (KeyError, ValueError):
        return None
    return value * unit if value > 0.0 else None
