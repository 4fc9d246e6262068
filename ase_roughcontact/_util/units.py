"""Units of scene files, printed output and figures."""

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


def printed_unit(unit: str) -> str:
    """Return the unit in which values of a column are printed."""
    return _PRINTED.get(unit, unit)
