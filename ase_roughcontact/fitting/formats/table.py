"""Segments and columns of a force curve as they are in a file, with units."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.validation import FloatArray, finite, shown

#: Segments of a curve, and their names in files.
SEGMENTS = {
    "approach": ("approach", "extend", "ex"),
    "hold": ("hold", "pause", "dwell"),
    "retraction": ("retraction", "retract", "rt"),
}


class Column(Protocol):
    """Column of a segment."""

    @property
    def head(self) -> str:
        """Name and unit as they are in the file."""

    @property
    def name(self) -> str:
        """Name in lower case, without the unit."""

    @property
    def unit(self) -> str | None:
        """Unit; None if it is not given in the file."""

    @property
    def away(self) -> bool | None:
        """Whether a height increases away from the surface, if the format says so."""

    def numbers(self, file: PathName) -> FloatArray:
        """Return the values, or raise `ValueError` for one that is not finite."""


@dataclass(frozen=True)
class TextColumn:
    """Column of a text, see `Column`.

    Attributes
    ----------
    head, name, unit, away
        See `Column`.
    cells : sequence of (int, str or None)
        Number of the line in the file, and text of the cell.
    """

    head: str
    name: str
    unit: str | None
    away: bool | None
    cells: Sequence[tuple[int, str | None]]

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


@dataclass(frozen=True)
class ArrayColumn:
    """Column of a binary file, see `Column`.

    Attributes
    ----------
    name, unit, away
        See `Column`.
    values : ndarray, shape (k,)
        Values in `unit`.
    """

    name: str
    unit: str
    away: bool | None
    values: FloatArray

    @property
    def head(self) -> str:
        """Name and unit."""
        return f"{self.name} ({self.unit})"

    def numbers(self, file: PathName) -> FloatArray:
        """Return the values, or raise `ValueError` with the number of a wrong one."""
        wrong = np.flatnonzero(~np.isfinite(self.values))
        if wrong.size:
            raise ValueError(
                f"{file}: {wrong.size} of {len(self.values)} values of {self.head} are "
                f"not finite, the first at point {wrong[0] + 1}: export the curve "
                "again, or delete the points"
            )
        return np.asarray(self.values, float)


@dataclass(frozen=True)
class Segment:
    """Part of a curve.

    Attributes
    ----------
    kind : str or None
        A key of `SEGMENTS`; None for points in the order of the measurement without
        further information in the file.
    columns : sequence of Column
        Columns of the segment.
    """

    kind: str | None
    columns: Sequence[Column]


@dataclass(frozen=True)
class Position:
    """Place on the sample where a curve was measured.

    Attributes
    ----------
    x, y : float
        Coordinates of the scanner (Å).
    column, row : int or None
        Numbers in the grid of a map along its sides, from 0, if the file has them.
    """

    x: float
    y: float
    column: int | None = None
    row: int | None = None


@dataclass(frozen=True)
class CurveTable:
    """Segments of a force curve in a file, and its calibration.

    Attributes
    ----------
    segments : sequence of Segment
        Segments in the order of the measurement.
    stiffness : float or None
        Spring constant of the cantilever (eV/Å^2), if the file has it.
    sensitivity : float or None
        Deflection of the cantilever per V (Å), if the file has it.
    position : Position or None
        Place on the sample, if the file has it.
    count : int
        Number of curves in the file.
    """

    segments: Sequence[Segment]
    stiffness: float | None = None
    sensitivity: float | None = None
    position: Position | None = None
    count: int = 1


@dataclass(frozen=True)
class Calibration:
    """Calibration given by a user, which replaces the calibration of the file.

    Attributes
    ----------
    stiffness : float or None
        Spring constant of the cantilever (eV/Å^2).
    sensitivity : float or None
        Deflection of the cantilever per V (Å), or per nA if `per` is ``"nA"``.
    per : str
        Unit of the signal of the photodiode.
    """

    stiffness: float | None = None
    sensitivity: float | None = None
    per: str = "V"


def segment_kind(name: str) -> str | None:
    """Return the kind of a segment by its name in a file; None if it is unknown."""
    found = (kind for kind, names in SEGMENTS.items() if name.lower() in names)
    return next(found, None)


def chosen_curve(file: PathName, curve: int | None, count: int) -> int:
    """Return the index of a curve among several.

    Parameters
    ----------
    file : path
        Name of the file, for messages.
    curve : int or None
        Number of the curve, from 1; needed if there are several.
    count : int
        Number of curves in the file.

    Raises
    ------
    ValueError
        If there are several curves and none is chosen, or the number is too large.
    """
    if curve is None and count == 1:
        return 0
    if curve is None or not 1 <= curve <= count:
        given = "" if curve is None else f", got {curve}"
        raise ValueError(
            f"{file} contains {count} force curves: choose one by --curve, a number "
            f"from 1 to {count}{given}, or fit all by ase-roughcontact curves"
        )
    return curve - 1
