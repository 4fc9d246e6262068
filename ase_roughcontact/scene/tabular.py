"""Results as columns with units: tables of pandas, figures, tables of notebooks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ase_roughcontact._util.extras import imported
from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.summary import Summarized, html_table, short_text
from ase_roughcontact._util.units import UNITS, printed_unit
from ase_roughcontact._util.validation import FloatArray

# Largest number of rows in a table of a notebook.
_MAX_ROWS = 20


class Tabular(Summarized, ABC):
    """Base class of results with columns of one length, each with a name and a unit.

    A subclass defines `columns`, `units`, `column` and `usual_columns`.
    """

    #: Column that is the index of a table; by default the number of the row.
    index_column: ClassVar[str] = ""
    #: Whether neighbouring rows belong together, and figures join them by lines.
    ordered: ClassVar[bool] = False

    @property
    @abstractmethod
    def columns(self) -> list[str]:
        """Names of the columns."""

    @property
    @abstractmethod
    def units(self) -> dict[str, str]:
        """Units of the columns that have one, by name."""

    @abstractmethod
    def column(self, name: str) -> np.ndarray:
        """Return a column, or raise `ValueError` with the most similar name."""

    @property
    def shown(self) -> list[str]:
        """Names of the columns of a table in a notebook."""
        return self.columns

    def printed(self, name: str) -> str:
        """Return the unit in which a column is printed; empty without a unit."""
        return printed_unit(self.units.get(name, ""))

    def label(self, name: str) -> str:
        """Return name and printed unit of a column."""
        label, unit = name.replace("_", " "), self.printed(name)
        return f"{label} ({unit})" if unit else label

    def factor(self, name: str) -> float:
        """Return the printed unit of a column in the unit of the column."""
        unit, printed = self.units.get(name, ""), self.printed(name)
        return 1.0 if unit == printed else UNITS[printed] / UNITS[unit]

    def numbers(self, name: str) -> np.ndarray:
        """Return a column in its printed unit.

        Raises
        ------
        ValueError
            If there is no such column, or it has texts.
        """
        values = self.column(name)
        if values.dtype.kind not in "fiub":
            example = repr(str(values[0])) if values.size else "none"
            raise ValueError(
                f"the column {name} has texts, such as {example}: give a column of "
                "numbers"
            )
        return values / self.factor(name)

    def to_pandas(self) -> Any:
        """Return all columns as a table of pandas.

        Returns
        -------
        pandas.DataFrame
            One row for each row of the results; ``attrs["units"]`` has the units of the
            columns.

        Raises
        ------
        ImportError
            If pandas is not installed.
        """
        pandas = imported("pandas", "tables", "a table needs pandas")
        table = pandas.DataFrame({name: self.column(name) for name in self.columns})
        table.attrs["units"] = self.units
        return table.set_index(self.index_column) if self.index_column else table

    def figure(
        self, column: str = "", along: str = "", file: PathName | None = None
    ) -> Any:
        """Draw a column against another one, in printed units.

        Parameters
        ----------
        column, along : str
            Columns on the vertical and the horizontal axis; see `usual_columns`. Bars
            show twice the estimated error.
        file : path, optional
            Picture to write; its ending is the format, such as ``.svg``.

        Returns
        -------
        matplotlib.figure.Figure

        Raises
        ------
        ValueError
            If there is no such column, it has texts, or the format is unknown.
        """
        from ase_roughcontact.plot.figures import column_figure
        from ase_roughcontact.plot.files import check_picture, save

        if file is not None:
            check_picture(Path(file))
        usual_column, usual_along = self.usual_columns
        column, along = column or usual_column, along or usual_along
        x, y = self.numbers(along), self.numbers(column)
        error = self.error_column(column)
        points, theory = self.theory(column, along)
        drawn = column_figure(
            (x, y),
            (self.label(along), self.label(column)),
            self.numbers(error) if error in self.columns else None,
            points,
            theory,
            joined=self.ordered,
        )
        if file is not None:
            save(drawn, Path(file))
        return drawn

    @property
    @abstractmethod
    def usual_columns(self) -> tuple[str, str]:
        """Columns on the vertical and the horizontal axis of a figure by default."""

    def error_column(self, column: str) -> str:
        """Return the name of the column with the errors of a column, if it exists."""
        return f"{column}_error"

    def theory(
        self, column: str, along: str
    ) -> tuple[FloatArray, dict[str, FloatArray]]:
        """Return theories for a figure of two columns, in printed units.

        Parameters
        ----------
        column, along : str
            Columns on the vertical and the horizontal axis.

        Returns
        -------
        points : ndarray, shape (n,)
            Values on the horizontal axis.
        values : dict of ndarray, shape (n,)
            Values on the vertical axis by name of the theory; none by default.
        """
        return np.zeros(0), {}

    def _repr_html_(self) -> str:
        """Return a table for notebooks, in printed units."""
        names, half = self.shown, _MAX_ROWS // 2
        columns = [self.column(name) for name in names]
        count = len(self.column(self.columns[0]))
        heads = np.arange(count)
        if self.index_column:
            heads = self.column(self.index_column)
        numbers = list(range(count))
        if count > _MAX_ROWS:
            numbers = [*numbers[:half], *numbers[-half:]]
        rows = []
        for number in numbers:
            values = [column[number] for column in columns]
            rows.append([str(heads[number]), *map(self._text, names, values)])
        if len(rows) < count:
            rows.insert(half, ["...", *("" for _ in names)])
        titles = [self.index_column, *map(self.label, names)]
        return html_table(repr(self), titles, rows)

    def _text(self, name: str, value: Any) -> str:
        """Return a value of a column in its printed unit."""
        if not isinstance(value, (float, np.floating)):
            return str(value)
        return "not known" if value != value else short_text(value / self.factor(name))
