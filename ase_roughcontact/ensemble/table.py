"""Steps or cases of an ensemble as columns with units."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import lookup
from ase_roughcontact.scene.tabular import Tabular


class EnsembleTable(Tabular, dict[str, np.ndarray]):
    """Columns of an ensemble by name; see `read_ensemble`.

    Parameters
    ----------
    columns : mapping of str to ndarray, shape (k,)
        Columns by name.
    units : mapping of str to str
        Units by name; names without a column are left out.
    """

    def __init__(
        self, columns: Mapping[str, np.ndarray], units: Mapping[str, str]
    ) -> None:
        super().__init__(columns)
        self._units = {name: units[name] for name in columns if name in units}

    def __reduce__(self) -> Any:
        """Pickle the columns and the units."""
        return EnsembleTable, (dict(self), self._units)

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return list(self)

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns that have one, by name.

        Lengths of sphere and roughness are in spacings (a0). Targets and rates have no
        unit here, as it depends on the control.
        """
        return dict(self._units)

    def column(self, name: str) -> np.ndarray:
        """Return a column, or raise `ValueError` with the most similar name."""
        return lookup(name, self, "column")

    @property
    def of_cases(self) -> bool:
        """Whether a row is a case, and not a step."""
        return "state" in self

    @property
    def usual_columns(self) -> tuple[str, str]:
        """Columns of a figure: area over force of steps, or pull-off force over radius.

        A figure shows one point for each row.
        """
        if self.of_cases:
            return "pull_off_force", "radius"
        return "contact_area", "normal_force"

    def error_column(self, column: str) -> str:
        """Return the name of the column with the errors of a column, if it exists."""
        errors = {"contact_area": "area_error", "normal_force": "force_error"}
        return errors.get(column, super().error_column(column))

    @property
    def shown(self) -> list[str]:
        """Names of columns that are known, and differ between rows."""
        return [
            name
            for name, values in self.items()
            if len({*values.tolist()} - {"", -1}) > 1 and not _is_unknown(values)
        ]

    def _summary(self) -> dict[str, str]:
        rows = len(self["case"])
        cases = len({*self["case"].tolist()})
        found = {"cases": str(cases)}
        if not self.of_cases:
            found["steps"] = str(rows)
        return found | {"columns": str(len(self))}


def _is_unknown(values: np.ndarray) -> bool:
    """Return whether no value of a column is known."""
    return values.dtype.kind == "f" and bool(np.isnan(values).all())
