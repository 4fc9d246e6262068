"""Printed tables and text: 80 columns wide, in colour only on terminals."""

from __future__ import annotations

import io
import math
import sys
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from datetime import timedelta
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # rich is imported when something is printed
    from rich.console import Console
    from rich.padding import Padding
    from rich.table import Table

# Width of text that is not printed on a terminal.
_WIDTH = 80
# Range of numbers that are printed without an exponent.
_SMALL, _LARGE = 1e-3, 1e7
_YEAR = 365.25 * 86400.0
# Time above which years are printed (s).
_LONG = 100.0 * _YEAR


def number(value: float, digits: int = 4) -> str:
    """Return a number with a number of significant digits; "-" if it is unknown."""
    if math.isnan(value):
        return "-"
    if isinstance(value, int) or value == 0.0 or math.isinf(value):
        return f"{value:g}" if isinstance(value, float) else str(value)
    if not _SMALL <= abs(value) < _LARGE:
        return f"{value:.{digits - 1}e}"
    decimals = digits - 1 - math.floor(math.log10(abs(value)))
    return f"{value:.{max(decimals, 0)}f}"


def duration(seconds: float) -> str:
    """Return a time (s) as hours, minutes and seconds, or as years if very long."""
    if seconds > _LONG:
        return f"{seconds / _YEAR:.2g} years"
    return str(timedelta(seconds=round(seconds)))


def table(
    heads: Sequence[str],
    rows: Iterable[Sequence[Any]],
    left: int = 0,
    width: int | None = None,
    header: bool = True,
) -> Table:
    """Return a table of right-aligned columns.

    Parameters
    ----------
    heads : sequence of str
        Headings, such as ``"load (nN)"``, whose unit is printed below the name.
    rows : iterable of sequences
        Text, and numbers, which are printed by `number`.
    left : int
        Number of the first columns that are aligned at the left.
    width : int, optional
        Least width of the columns but the first, by which tables with one row each are
        in line; by default that of their longest entry.
    header : bool
        Whether the headings are printed.
    """
    from rich.table import Table

    found = Table(box=None, show_header=header, padding=(0, 2, 0, 0), pad_edge=False)
    for i, head in enumerate(heads):
        lines = head.replace(" (", "\n(")
        longest = max(map(len, lines.splitlines()), default=0)
        found.add_column(
            lines,
            justify="left" if i < left else "right",
            min_width=max(width, longest) if width and i and head else None,
            no_wrap=i >= left,
        )
    for row in rows:
        cells = (each if isinstance(each, str) else number(each) for each in row)
        found.add_row(*cells)
    return found


def entries(values: Iterable[tuple[str, str]]) -> Table:
    """Return names and values, one on each line, as a table."""
    return table(("", ""), values, left=2, header=False)


def note(text: str, indent: int = 0, style: str = "") -> Padding:
    """Return an indented text, in a style of rich on terminals."""
    from rich.padding import Padding
    from rich.text import Text

    return Padding(Text(text, style=style), (0, 0, 0, indent))


def show(*parts: Any) -> None:
    """Print texts and tables on the standard output."""
    if sys.stdout.isatty():
        _console().print(*parts, sep="\n")
    else:
        print(plain(*parts))
    sys.stdout.flush()


def plain(*parts: Any) -> str:
    """Return texts and tables as text of at most 80 columns."""
    text = io.StringIO()
    _console(file=text, width=_WIDTH).print(*parts, sep="\n")
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines())


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
