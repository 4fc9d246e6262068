"""Tables of text that leave out, and name, columns that do not fit the screen."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:  # rich is imported when something is printed
    from rich.console import Console, ConsoleOptions

# Number of spaces between two columns.
_COLUMN_SPACES = 2


@dataclass(frozen=True)
class Columns:
    """Headings and widths of columns.

    Attributes
    ----------
    heads : tuple of str
        Headings, with the unit on a second line. The first column, and columns without
        a heading, such as marks, are never left out.
    widths : tuple of int
        Smallest width of each column (characters).
    left : int
        Number of the first columns that are aligned at the left. The last one of them
        is wrapped.
    """

    heads: tuple[str, ...]
    widths: tuple[int, ...]
    left: int = 0

    def fitting(self, width: int) -> tuple[int, ...]:
        """Return the columns that fit a width; the last ones are left out."""
        kept = list(range(len(self.heads)))
        for column in reversed(kept[1:]):
            if self._total(kept) <= width:
                break
            if self.heads[column]:
                kept.remove(column)
        return tuple(kept)

    def left_out(self, kept: Sequence[int], width: int) -> str:
        """Return a line with the names of the columns that are left out, or ""."""
        names = [
            head.splitlines()[0]
            for column, head in enumerate(self.heads)
            if column not in kept
        ]
        if not names:
            return ""
        needed = self._total(range(len(self.heads)))
        return (
            f"Left out on a screen of {width} characters: {', '.join(names)} "
            f"({needed} show all)."
        )

    def drawn(
        self, kept: Sequence[int], rows: Sequence[Sequence[str]], header: bool
    ) -> Any:
        """Return a table of rich with the columns that are kept."""
        from rich.table import Table

        padding = (0, _COLUMN_SPACES, 0, 0)
        drawn = Table(box=None, show_header=header, padding=padding, pad_edge=False)
        for i in kept:
            wrapped = i == self.left - 1
            drawn.add_column(
                self.heads[i],
                justify="left" if i < self.left else "right",
                min_width=None if wrapped else self.widths[i],
                no_wrap=not wrapped,
                overflow="fold",
            )
        for row in rows:
            drawn.add_row(*(row[i] for i in kept))
        return drawn

    def _total(self, kept: Sequence[int]) -> int:
        """Return the width of some columns."""
        return sum(self.widths[i] for i in kept) + _COLUMN_SPACES * (len(kept) - 1)


class Table:
    """Table that is printed as a whole, in the width of its entries.

    Parameters
    ----------
    heads : sequence of str
        Headings, such as ``"load (nN)"``; the unit is printed below the name. If all
        are empty, there is no line of headings.
    rows : sequence of sequences of str
        Entries of each row.
    left : int
        Number of the first columns that are aligned at the left. The last one of them
        is wrapped.
    """

    def __init__(
        self, heads: Sequence[str], rows: Sequence[Sequence[str]], left: int = 0
    ) -> None:
        lines = _with_units_below(heads)
        widths = []
        for i, line in enumerate(lines):
            entries = (_longest(row[i], words=i == left - 1) for row in rows)
            widths.append(max([_longest(line), *entries]))
        self.heads, self.rows = heads, rows
        self._columns = Columns(lines, tuple(widths), left)

    def __rich_console__(
        self, console: Console, options: ConsoleOptions
    ) -> Iterator[Any]:
        """Yield the table, below a line that names the columns that do not fit."""
        kept = self._columns.fitting(options.max_width)
        missing = self._columns.left_out(kept, options.max_width)
        if missing:
            yield missing
        yield self._columns.drawn(kept, self.rows, any(self._columns.heads))


class TableRows:
    """Rows that are printed one by one, in line with each other.

    Parameters
    ----------
    heads : sequence of str
        Headings, see `Table`.
    widths : sequence of int
        Length of the longest usual entry of each column (characters).
    """

    def __init__(self, heads: Sequence[str], widths: Sequence[int]) -> None:
        lines = _with_units_below(heads)
        sizes = zip(map(_longest, lines), widths, strict=True)
        self._columns = Columns(lines, tuple(map(max, sizes)))
        self._printed: tuple[int, ...] = ()

    def row(self, cells: Sequence[str]) -> _Row:
        """Return a row, which is printed below the headings if it is the first one."""
        return _Row(self, cells)

    def drawn(self, cells: Sequence[str], width: int) -> Iterator[Any]:
        """Yield a row, below headings if other columns fit than in the row before."""
        kept = self._columns.fitting(width)
        new, self._printed = kept != self._printed, kept
        if new and (missing := self._columns.left_out(kept, width)):
            yield missing
        longest = [max(self._columns.widths[i], len(cells[i])) for i in kept]
        if sum(longest) + _COLUMN_SPACES * (len(kept) - 1) <= width:
            yield self._columns.drawn(kept, [cells], header=new)
            return
        if new:
            yield self._columns.drawn(kept, [], header=True)
        # numbers of extreme size
        yield (" " * _COLUMN_SPACES).join(cells[i] for i in kept)


@dataclass(frozen=True)
class _Row:
    """A row of `TableRows`."""

    rows: TableRows
    cells: Sequence[str]

    def __rich_console__(
        self, console: Console, options: ConsoleOptions
    ) -> Iterator[Any]:
        yield from self.rows.drawn(self.cells, options.max_width)


def _with_units_below(heads: Sequence[str]) -> tuple[str, ...]:
    return tuple(head.replace(" (", "\n(") for head in heads)


def _longest(text: str, words: bool = False) -> int:
    """Return the length of the longest line of a text, or of its longest word."""
    return max(map(len, text.split() if words else text.splitlines()), default=0)
