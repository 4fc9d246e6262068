"""Printed and written values have the units given beside them.

Printed values are compared with ``curve.csv``, which is in ASE's units. The units of
JSON lines are compared with the factor by which a value changes when lengths are
doubled and moduli are quadrupled.
"""

import json
import re

import numpy as np
import pytest
from command_cases import (
    CASES,
    MODULUS,
    RADIUS,
    ROUGH,
    WORK,
    hertz_area,
    printed,
    text_of,
)
from scipy.special import erf

from ase_roughcontact._util.printing import number
from ase_roughcontact._util.units import UNITS

pytestmark = pytest.mark.usefixtures("no_pictures")
# Columns of curve.csv by the words of printed headings.
COLUMNS = {
    "load": "normal_force",
    "force": "normal_force",
    "area": "contact_area",
    "depth": "penetration",
    "penetration": "penetration",
    "height": "height",
    "time": "seconds",
    "p max": "largest_pressure",
}
# Dimensions of the main columns, as powers of energy and length.
DIMENSIONS = {
    "height": (0, 1),
    "penetration": (0, 1),
    "normal_force": (1, -1),
    "contact_area": (0, 2),
    "energy": (1, 0),
    "max_force": (1, -1),
}
# Quantities that estimated errors belong to.
ERRORS = {
    "area_error": "contact_area",
    "force_error": "normal_force",
    "height_error": "height",
    "penetration_error": "penetration",
}
COSTS = {"memory": "bytes", "seconds": "s", "elapsed": "s", "left": "s"}


def lines_of_json(*arguments):
    return [json.loads(line) for line in printed(*arguments, "--json").splitlines()]


def stated(text, word, unit):
    """Return the value between a word and a unit, in ASE's units."""
    text = re.sub(r"\n {3,}", " ", text)  # lines that were wrapped
    found = re.search(rf"{word}[^0-9\n]*?(-?[0-9.]+(?:e[+-]?\d+)?) ?{unit}\b", text)
    assert found, f"no {word} in {unit}"
    return float(found[1]) * UNITS[unit]


def table_of(text):
    """Return the columns of a printed table, by heading: name, and unit below it.

    Headings are aligned at the right with the numbers, and rows begin with a number.
    """
    lines = text.splitlines()
    units = next(i for i, line in enumerate(lines) if line.endswith("(s)"))
    count = len(lines[units + 1].split())
    body = [line.rstrip(" *") for line in lines[units + 1 :]]
    body = [line for line in body if re.match(r" *-?\d", line)]
    body = [line for line in body if len(line.split()) == count]
    rows = [line.split() for line in body]
    ends = [found.end() for found in re.finditer(r"\S+", body[0])]
    columns = {}
    for i, (start, end) in enumerate(zip([0, *ends], ends, strict=False)):
        parts = (line[start:end].strip() for line in lines[units - 1 : units + 1])
        columns[" ".join(filter(None, parts))] = [row[i] for row in rows]
    return columns


def numbers_of(texts):
    return np.array([float(text) for text in texts])


def unit_of(name):
    """Return the word and the unit of a heading."""
    found = re.fullmatch(r"([\w ]+) \(([^\d%]+)\)", name)
    return found.groups() if found else (name, None)


# Printed


def test_columns_of_the_printed_table_agree_with_curve_csv(case):
    seen = set()
    for name, texts in table_of(case.text).items():
        word, unit = unit_of(name)
        if unit is None:
            continue
        expected = case.column(COLUMNS[word]) / UNITS[unit]
        np.testing.assert_allclose(
            numbers_of(texts), expected, rtol=6e-4, atol=0.006, err_msg=name
        )
        seen.add(COLUMNS[word])
    expected = "largest_pressure" if case.control == "load" else case.control
    assert {"normal_force", "contact_area", "seconds", expected} <= seen


def test_printed_ratios_agree_with_the_formulas(case):
    wall, table = case.wall, table_of(case.text)
    if wall == "sticky":  # the law of Maugis and Dugdale is no formula
        assert "A/A_Hertz" not in table and "theory" not in table
        return
    force, area = case.column("normal_force"), case.column("contact_area")
    hertz = hertz_area(force)
    assert table["A/A_Hertz"] == list(map(number, area / hertz))
    if wall == "repulsive":
        ratio = erf(np.sqrt(np.pi) / 2.0 * force / hertz * 2.9 / (0.1 * MODULUS))
        assert table["theory"] == list(map(number, ratio))


def test_values_of_scene_and_results_are_printed_with_their_units(case):
    wall, control, text = case.wall, case.control, case.text
    expected = {("spacing", "Å"): 2.5, ("radius", "nm"): RADIUS}
    expected["E[*]", "GPa"] = MODULUS
    assert ("first contact" in text) == (control == "height")
    if control == "height":
        touch = case.column("height") + case.column("penetration")
        expected["first contact", "Å"] = touch[0]
    assert ("J/m²" in text) == ("ull-off" in text) == (wall == "sticky")
    if wall == "sticky":
        expected["w =", "J/m²"] = WORK
        expected["tension", "nN"] = -min(case.column("normal_force"))
        scale = np.pi * WORK * RADIUS  # between DMT and JKR
        assert 1.5 * scale < stated(text, "[Pp]ull-off", "nN") < 2.0 * scale
    for (word, unit), value in expected.items():
        assert stated(text, word, unit) == pytest.approx(value, rel=1e-3)


def test_memory_is_printed_in_gigabytes_and_residual_forces_in_ase_s_unit(case):
    file = case.file
    text = printed("run", file, "--out", file.parent / "out", "--verbose")
    digits = r"([0-9.]+(?:e[+-]?\d+)?)"
    for name, pattern in {
        "memory": rf"{digits} GB;",
        "max_force": rf"force {digits} eV/Å",
        "tolerance": rf"tolerance {digits} eV/Å",
    }.items():
        unit = UNITS["GB"] if name == "memory" else 1.0
        found = numbers_of(re.findall(pattern, " ".join(text.split()))) * unit
        np.testing.assert_allclose(found, case.column(name), rtol=0.05)
    planned = [line["memory"] for line in lines_of_json("plan", file)[:-1]]
    shown = next(v for k, v in table_of(printed("plan", file)).items() if "GB" in k)
    np.testing.assert_allclose(numbers_of(shown) * UNITS["GB"], planned, atol=6e6)


def test_targets_of_a_plan_agree_with_the_path(case):
    control, file = case.control, case.file
    _, given, _ = CASES[control]
    unit = "nN" if control == "load" else "Å"
    name, texts = next(iter(table_of(printed("plan", file)).items()))
    assert unit_of(name) == (control, unit)
    np.testing.assert_allclose(numbers_of(texts), given)
    label = {"load": "eV/Å"}.get(control, "Å")
    for line, value in zip(lines_of_json("plan", file)[:-1], given, strict=True):
        assert line["units"]["target"] == label
        assert line["target"] == pytest.approx(value * UNITS[unit])


# JSON lines


def dimension(label):
    """Return the powers of energy and length in a unit such as eV/Å^2."""
    powers = {"eV": 0, "Å": 0}
    for i, part in enumerate(label.replace("²", "^2").replace("³", "^3").split("/")):
        name, _, power = part.partition("^")
        powers[name] += (-1) ** i * int(power or 1)
    return powers["eV"], powers["Å"]


def assert_scales(line, scaled, length, energy):
    """Compare JSON lines of two runs that differ in their scales."""
    assert line.keys() == scaled.keys() and line["units"] == scaled["units"]
    assert line["units"].keys() <= line.keys()
    for name, value in line.items():
        label = line["units"].get(name)
        if name in COSTS or label in COSTS.values():
            assert label == COSTS[name]
        elif label is None:
            assert scaled[name] == value or name == "units"
        elif value is None:
            assert scaled[name] is None
        else:
            power = dimension(label)
            assert DIMENSIONS.get(name, power) == power
            factor = energy ** power[0] * length ** power[1]
            # errors by the tolerance are as small as rounding
            size = abs(line[ERRORS[name]]) if name in ERRORS else 0.0
            expected = pytest.approx(factor * value, rel=1e-3, abs=1e-9 * factor * size)
            assert scaled[name] == expected
    assert DIMENSIONS.keys() & line.keys() <= line["units"].keys()


@pytest.mark.parametrize("wall", ["hard", "repulsive", "sticky"])
@pytest.mark.parametrize("control", ["load", "height"])
def test_values_in_json_scale_as_their_units(wall, control, tmp_path):
    found = []
    for length, modulus in ((1.0, 1.0), (2.0, 4.0)):
        target = 30.0 * modulus * length**2 if control == "load" else length
        file = tmp_path / f"{length}.toml"
        text = text_of(wall, control, [target], ROUGH, 2.5 * length, 100.0 * modulus)
        file.write_text(text.replace("= 0.5", f"= {0.5 * modulus * length}"))
        out = tmp_path / f"out-{length}"
        for command in (["run", file, "--out", out], ["plan", file]):
            found += lines_of_json(*command)[:1]
    run, plan, *scaled = found
    assert_scales(run, scaled[0], length, modulus * length**3)
    assert_scales(plan, scaled[1], length, modulus * length**3)
    assert {*DIMENSIONS, "memory", "seconds"} <= run.keys()


def test_json_lines_have_the_columns_of_curve_csv(case):
    lines = lines_of_json("run", case.file, "--out", case.file.parent / "out")
    for line, record in zip(lines, case.records, strict=True):
        line.pop("units")
        unknown = line.pop("not_known")
        assert unknown.keys() == {name for name in line if line[name] is None}
        shown = {k: "nan" if v is None else str(v) for k, v in line.items()}
        assert shown == record
