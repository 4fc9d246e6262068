"""Units against the definitions of the SI."""

import pytest
from scipy.constants import e as elementary_charge

from ase_roughcontact._util.units import (
    FORCES,
    LENGTHS,
    PRESSURES,
    UNITS,
    WORKS,
    quantity,
    with_unit,
)

# Value of each unit in m, N, Pa or N/m.
EV = elementary_charge  # J
SI = {
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "pm": 1e-12}
    | dict.fromkeys(["\u00b5m", "\u03bcm"], 1e-6)
    | dict.fromkeys(["A", "Angstrom", "\u00c5", "\u212b"], 1e-10),
    "force": {"N": 1.0, "nN": 1e-9, "pN": 1e-12, "eV/Å": EV / 1e-10}
    | dict.fromkeys(["uN", "\u00b5N", "\u03bcN"], 1e-6),
    "pressure": {"Pa": 1.0, "kPa": 1e3, "MPa": 1e6, "GPa": 1e9, "TPa": 1e12}
    | dict.fromkeys(["eV/Å^3", "eV/Å³"], EV / 1e-30),
    "work": dict.fromkeys(["J/m^2", "J/m²", "N/m", "nN/nm"], 1.0)
    | dict.fromkeys(["mJ/m^2", "mJ/m²", "mN/m", "pN/nm"], 1e-3)
    | dict.fromkeys(["eV/Å^2", "eV/Å²"], EV / 1e-20),
    "area": {"nm²": 1e-18, "\u00b5m²": 1e-12, "Å^2": 1e-20},
}
# Units of ASE in units of the SI.
ASE = {
    "length": 1e-10,
    "force": EV / 1e-10,
    "pressure": EV / 1e-30,
    "work": EV / 1e-20,
    "area": 1e-20,
}
TABLES = {"length": LENGTHS, "force": FORCES, "pressure": PRESSURES, "work": WORKS}


@pytest.mark.parametrize("kind", SI)
def test_units_agree_with_the_si(kind):
    expected = {unit: value / ASE[kind] for unit, value in SI[kind].items()}
    assert {unit: UNITS[unit] for unit in expected} == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("kind", TABLES)
def test_a_quantity_has_every_unit_of_its_table(kind):
    assert TABLES[kind].keys() == SI[kind].keys()
    for unit, value in SI[kind].items():
        got = quantity("x", f"-2.5e-1 {unit}", TABLES[kind])
        assert got == pytest.approx(-0.25 * value / ASE[kind], rel=1e-8)


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (1e5, "nm", "10 \u00b5m"),
        (123.4, "nm", "12.34 nm"),
        (0.05, "nm", "5 pm"),
        (1254900 * 100.0, "nm²", "1.255 \u00b5m²"),
        (53.81 * 100.0, "nm²", "53.81 nm²"),
        (1.9324e-5 * UNITS["GPa"], "GPa", "19.32 kPa"),
        (9.15e-5, "s", "91.5 \u00b5s"),
        (2.5e5 * UNITS["nN"], "nN", "250 \u00b5N"),
        (-4e-5 * UNITS["nN"], "nN", "-0.04 pN"),
        (0.0, "nN", "0 nN"),
        (float("nan"), "nN", "nan nN"),
    ],
)
def test_values_are_printed_in_a_unit_of_their_size(value, unit, text):
    assert with_unit(value, unit) == text
