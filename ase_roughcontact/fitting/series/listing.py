"""The curves in files, folders and archives."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.units import LENGTHS, quantity
from ase_roughcontact.fitting.formats.archive import (
    archived_names,
    is_archive,
    name_order,
)
from ase_roughcontact.fitting.formats.reader import count_curves, read_positions
from ase_roughcontact.fitting.formats.table import Calibration, Position


@dataclass(frozen=True)
class CurveName:
    """File of a curve, and which of its curves it is.

    Attributes
    ----------
    file : str
        Path of the file.
    number : int
        Number of the curve in the file, from 1.
    member : str
        Name of the file in an archive; empty without one.
    """

    file: str
    number: int = 1
    member: str = ""


def listed_curves(
    files: Iterable[PathName], calibration: Calibration | None = None
) -> list[CurveName]:
    """Return the curves in files, in the files of folders, and in archives.

    Parameters
    ----------
    files : iterable of path
        Files, and folders of files, which are sorted by name, 2 before 10; hidden ones
        are left out.
    calibration : Calibration, optional
        Calibration for files that can't be read without it.

    Returns
    -------
    list of CurveName
        Curves in the order of the files. A file that can't be read is one curve.

    Raises
    ------
    ValueError
        If there are no files.
    FileNotFoundError
        If a file does not exist.
    """
    found: list[CurveName] = []
    for path in map(Path, files):
        for each in _files_of(path):
            if is_archive(each):
                members = enumerate(archived_names(each), start=1)
                found += [CurveName(str(each), i, member) for i, member in members]
            else:
                count = _count(each, calibration)
                found += [CurveName(str(each), i) for i in range(1, count + 1)]
    if not found:
        raise ValueError("there are no files of force curves: give files, or a folder")
    return found


def curve_at(
    file: PathName, place: str, calibration: Calibration | None = None
) -> tuple[int, Position]:
    """Return the curve that was measured nearest to a place.

    Parameters
    ----------
    file : path
        File of several curves.
    place : str
        Coordinates x and y of the scanner, such as ``"2 um, 3.5 um"``.
    calibration : Calibration, optional
        Calibration for files that can't be read without it.

    Returns
    -------
    number : int
        Number of the curve in the file, from 1.
    position : Position

    Raises
    ------
    ValueError
        If the text is not two lengths, the file has no positions, or the place is
        outside of the map.
    """
    x, y = _coordinates(place)
    positions = read_positions(file, calibration)
    known = [(i, each) for i, each in enumerate(positions, start=1) if each]
    if not known:
        raise ValueError(
            f"{file} does not say where its {len(positions)} curves were measured: "
            f"choose one by --curve, a number from 1 to {len(positions)}"
        )
    xs, ys = [each.x for _, each in known], [each.y for _, each in known]
    for value, values, axis in ((x, xs, "x"), (y, ys, "y")):
        low, high = min(values), max(values)
        # half of the distance of the curves of a square map
        margin = 0.5 * max(max(xs) - min(xs), max(ys) - min(ys)) / len(known) ** 0.5
        if not low - margin <= value <= high + margin:
            low, high = low / LENGTHS["um"], high / LENGTHS["um"]
            raise ValueError(
                f"{file} has {len(known)} curves at {axis} from {low:.6g} to "
                f"{high:.6g} um, got {value / LENGTHS['um']:.6g} um: give a place there"
            )
    return min(known, key=lambda each: (each[1].x - x) ** 2 + (each[1].y - y) ** 2)


def _files_of(path: Path) -> list[Path]:
    """Return a file, or the sorted files in a folder."""
    if not path.is_dir():
        if not path.exists():
            raise FileNotFoundError(f"there is no file {path}")
        return [path]
    inside = (each for each in path.iterdir() if each.is_file())
    shown = (each for each in inside if not each.name.startswith("."))
    return sorted(shown, key=lambda each: name_order(each.name))


def _count(file: Path, calibration: Calibration | None) -> int:
    """Return the number of curves in a file; one if it can't be read."""
    try:
        return count_curves(file, calibration)
    except (ValueError, OSError):
        return 1


def _coordinates(place: str) -> list[float]:
    """Return two lengths (Å)."""
    parts = place.split(",")
    if len(parts) != 2:
        raise ValueError(f'a place is given as "2 um, 3 um", x and y; got {place!r}')
    return [
        quantity(axis, part, LENGTHS, "um")
        for axis, part in zip("xy", parts, strict=True)
    ]
