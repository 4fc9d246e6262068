"""Registry of the formats of force curves, and a file of an unknown format."""

from __future__ import annotations

from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from ase_roughcontact._util.registry import Registry
from ase_roughcontact.fitting.formats.table import Calibration, CurveTable


@dataclass(frozen=True)
class CurveFile:
    """File with a force curve, and the options for reading it.

    Attributes
    ----------
    path : Path
        Name of the file.
    curve : int or None
        Number of the curve, from 1; None if none was chosen.
    heads : sequence of str
        Names and units of the columns of a text, in place of those in the file.
    calibration : Calibration
        Calibration that the user gave.
    """

    path: Path
    curve: int | None
    heads: Sequence[str]
    calibration: Calibration

    @cached_property
    def data(self) -> bytes:
        """Contents of the file."""
        return self.path.read_bytes()

    @property
    def is_text(self) -> bool:
        """Whether the file is a text, in one or two bytes a letter."""
        return self._is_wide or b"\0" not in self.data

    @property
    def _is_wide(self) -> bool:
        return self.data[:2] in (BOM_UTF16_LE, BOM_UTF16_BE)

    @cached_property
    def text(self) -> str:
        """Text of the file; empty if it is not a text."""
        if not self.is_text:
            return ""
        try:
            return self.data.decode("utf-16" if self._is_wide else "utf-8-sig")
        except UnicodeDecodeError:  # texts of older programs
            return self.data.decode("latin-1")

    @property
    def lines(self) -> dict[int, str]:
        """Lines that are not blank by their numbers, from 1."""
        numbered = enumerate(self.text.splitlines(), start=1)
        return {number: line for number, line in numbered if line.strip()}


@dataclass(frozen=True)
class CurveFormat:
    """Format of files with force curves.

    Attributes
    ----------
    recognises : callable
        Function that returns whether a `CurveFile` has this format.
    read : callable
        Function that returns its `CurveTable`: segments of columns with units, and the
        calibration. It raises `ValueError` for what it can't read.
    """

    recognises: Callable[[CurveFile], bool]
    read: Callable[[CurveFile], CurveTable]


#: Formats of one's own by their names, which are tried before the package's formats.
#: One more is an entry: ``FORMATS["mine"] = CurveFormat(recognises, read)``.
FORMATS: Registry[CurveFormat] = Registry("format of force curves")
