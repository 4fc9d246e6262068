"""Printing of tables and text, on terminals in colour and as wide as the screen."""

from __future__ import annotations

import io
import math
import os
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from datetime import timedelta
from functools import cache
from typing import TYPE_CHECKING, Any, TextIO

from ase_roughcontact._util.tables import Table

if TYPE_CHECKING:  # rich is imported when something is printed
    from rich.console import Console
    from rich.padding import Padding

# Width of text that is not printed on a terminal (characters).
_WIDTH = 80
# Smallest number that is printed without an exponent.
_MIN_DECIMAL = 1e-3
# Smallest number above 1 that is printed with an exponent.
_MAX_DECIMAL = 1e7
# Duration of a year (s).
_YEAR = 365.25 * 86400.0
# Longest duration that is printed in hours (s).
_MAX_HOURS = 100.0 * _YEAR


def number(value: float, digits: int = 4) -> str:
    """Return a number as text with significant digits; "-" if it is not known."""
    if math.isnan(value):
        return "-"
    if isinstance(value, int) or value == 0.0 or math.isinf(value):
        return f"{value:g}" if isinstance(value, float) else str(value)
    if not _MIN_DECIMAL <= abs(value) < _MAX_DECIMAL:
        return f"{value:.{digits - 1}e}"
    decimals = digits - 1 - math.floor(math.log10(abs(value)))
    return f"{value:.{max(decimals, 0)}f}"


def duration(seconds: float) -> str:
    """Return a time (s) as hours, minutes and seconds, or as years if very long."""
    if seconds > _MAX_HOURS:
        return f"{seconds / _YEAR:.2g} years"
    return str(timedelta(seconds=round(seconds)))


def table(heads: Sequence[str], rows: Iterable[Sequence[Any]], left: int = 0) -> Table:
    """Return a `Table` of texts, and of numbers, which are printed by `number`."""
    return Table(heads, [cells(row) for row in rows], left)


def cells(row: Iterable[Any]) -> list[str]:
    """Return texts, and numbers as text."""
    return [each if isinstance(each, str) else number(each) for each in row]


def entries(values: Iterable[tuple[str, str]]) -> Table:
    """Return names and values, one on each line, as a table."""
    return table(("", ""), values, left=2)


def note(text: str, indent: int = 0, style: str = "") -> Padding:
    """Return an indented text, in a style of rich on terminals."""
    from rich.padding import Padding
    from rich.text import Text

    return Padding(Text(text, style=style), (0, 0, 0, indent))


def show(*parts: Any) -> None:
    """Print texts and tables on the standard output, in the width of a terminal."""
    if sys.stdout.isatty():
        terminal().print(*parts, sep="\n")
        sys.stdout.flush()
    else:
        write(plain(*parts))


def write(text: str) -> None:
    """Print a text on the standard output without changes.

    If the reader of a pipe has closed it, as ``head`` does, nothing more is printed,
    the error output says so, and the calculation goes on.
    """
    if not _printed(text, sys.stdout):
        write_error(
            "ase-roughcontact: the reader of the standard output has closed it: going "
            "on without printing"
        )


def write_error(text: str) -> None:
    """Print a text on the error output, if it is still read."""
    _printed(text, sys.stderr)


def _printed(text: str, stream: TextIO) -> bool:
    """Print a text, and return whether the stream is still read.

    If the reader of a pipe has closed it, further output of the stream is discarded.
    """
    try:
        print(text, file=stream, flush=True)
    except BrokenPipeError:
        with open(os.devnull, "wb") as nothing:
            os.dup2(nothing.fileno(), stream.fileno())
        return False
    return True


def plain(*parts: Any) -> str:
    """Return texts and tables as text of at most 80 columns, without colours."""
    text = io.StringIO()
    # not changed by FORCE_COLOR or a notebook
    options = {"force_terminal": False, "force_jupyter": False, "color_system": None}
    _console(file=text, width=_WIDTH, **options).print(*parts, sep="\n")
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


@cache
def terminal() -> Console:
    """Return the console of the standard output, a terminal.

    Text that is printed by this console appears above its progress bar.
    """
    return _console()


def _console(**options: Any) -> Console:
    from rich.console import Console

    return Console(markup=False, highlight=False, emoji=False, **options)


class Printed(ABC):
    """Results that are printed as texts and tables."""

    @property
    @abstractmethod
    def parts(self) -> Sequence[Any]:
        """Texts and tables, from top to bottom."""

    def __str__(self) -> str:
        return plain(*self.parts)
