"""Results of many force curves as columns with units."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import fields
from typing import Any, overload

import numpy as np

from ase_roughcontact._util.summary import short_text
from ase_roughcontact._util.units import pressure_unit
from ase_roughcontact._util.validation import lookup
from ase_roughcontact.fitting.series.row import CURVE_UNITS, LIST_UNITS, FittedCurve
from ase_roughcontact.scene.tabular import Tabular

# Units of ASE by the units in tables, and seconds.
_UNITS_OF_ASE = {
    "um": "Å",
    "nm": "Å",
    "Pa": "eV/Å^3",
    "J/m²": "eV/Å^2",
    "nN": "eV/Å",
    "s": "s",
}
# Units in tables by the names of columns.
_PRINTED_UNITS = CURVE_UNITS | LIST_UNITS


class FittedCurves(Tabular, list[FittedCurve]):
    """Results of many force curves: a list of them, with columns by name.

    Parameters
    ----------
    curves : iterable of FittedCurve
        See `read_fitted_curves`.

    Examples
    --------
    >>> from ase_roughcontact import FittedCurve, FittedCurves, GPa
    >>> curves = FittedCurves([FittedCurve("a.csv", contact_modulus=1e-6 * GPa)])
    >>> curves["contact_modulus"].shape, curves.units["contact_modulus"]
    ((1,), 'eV/Å^3')
    """

    def __init__(self, curves: Iterable[FittedCurve] = ()) -> None:
        super().__init__(curves)

    @overload  # type: ignore[override]
    def __getitem__(self, number: int) -> FittedCurve: ...
    @overload
    def __getitem__(self, number: slice) -> FittedCurves: ...
    @overload
    def __getitem__(self, number: str) -> np.ndarray: ...
    def __getitem__(self, number: Any) -> Any:
        """Return a curve by its number, some curves, or the column of a name."""
        if isinstance(number, str):
            return self.column(number)
        found = super().__getitem__(number)
        return FittedCurves(found) if isinstance(number, slice) else found

    @property
    def columns(self) -> list[str]:
        """Names of the columns: attributes of `FittedCurve`."""
        return [each.name for each in fields(FittedCurve)]

    @property
    def units(self) -> dict[str, str]:
        """Units of the columns that have one, by name; units of ASE, and seconds."""
        known = {name: unit for name, unit in _PRINTED_UNITS.items() if unit}
        return {name: _UNITS_OF_ASE[unit] for name, unit in known.items()}

    def column(self, name: str) -> np.ndarray:
        """Return a column, or raise `ValueError` with the most similar name."""
        lookup(name, dict.fromkeys(self.columns), "column")
        values = [getattr(curve, name) for curve in self]
        if name not in LIST_UNITS:
            return np.array(values)
        lists = np.empty(len(values), dtype=object)
        lists[:] = values
        return lists

    def printed(self, name: str) -> str:
        """Return the unit in which a column is printed."""
        if self.units.get(name) == "eV/Å^3":
            return pressure_unit(self._median_modulus)
        return _PRINTED_UNITS.get(name, "")

    @property
    def _median_modulus(self) -> float:
        known = [c.contact_modulus for c in self if not np.isnan(c.contact_modulus)]
        return float(np.median(known)) if known else np.nan

    @property
    def usual_columns(self) -> tuple[str, str]:
        """Columns of a figure by default: the contact modulus along x."""
        return "contact_modulus", "x"

    @property
    def shown(self) -> list[str]:
        """Names of the columns that are known for a curve."""
        unknown = FittedCurve("")
        return [
            name
            for name in self.columns
            if any(str(getattr(c, name)) != str(getattr(unknown, name)) for c in self)
        ]

    def _summary(self) -> dict[str, str]:
        unit = self.printed("contact_modulus")
        factor = self.factor("contact_modulus")
        return {
            "curves": str(len(self)),
            "not_fitted": str(sum(bool(curve.message) for curve in self)),
            "median_modulus": short_text(self._median_modulus / factor, unit),
        }
