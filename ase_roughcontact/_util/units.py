"""Units of scene files, printed output and figures."""

from __future__ import annotations

from ase.units import GPa, J, m

#: Value of each unit in ASE's units (Å, eV, s).
UNITS: dict[str, float] = {
    "": 1.0,
    "Å": 1.0,
    "nm": 10.0,
    "Å^2": 1.0,
    "nm²": 100.0,
    "eV": 1.0,
    "eV/Å": 1.0,
    "nN": 1e-9 * J / m,
    "GPa": GPa,
    "J/m^2": J / m**2,
    "J/m²": J / m**2,
    "s": 1.0,
    "bytes": 1.0,
    "GB": 1e9,
}

# Units in which columns are printed, by their unit.
_PRINTED = {"eV/Å": "nN", "Å^2": "nm²", "bytes": "GB"}


def cell(value: str | float, width: int, form: str = "") -> str:
    """Return an entry of a table, right-aligned, with a blank before it at least.

    Parameters
    ----------
    value : str or float
    width : int
        Width of the column; longer entries extend beyond it.
    form : str
        Format of a number, ``".2f"``; in its place ``".2g"`` if that is too wide.

    Returns
    -------
    str
    """
    text = format(value, form)
    if len(text) >= width and form.endswith("f"):
        text = format(value, f"{form[:-1]}g")
    return f" {text:>{width - 1}}"


def printed_unit(unit: str) -> str:
    """Return the unit in which values of a column are printed."""
    return _PRINTED.get(unit, unit)
