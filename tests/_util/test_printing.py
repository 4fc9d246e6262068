"""Printed numbers and tables."""

import math

import pytest

from ase_roughcontact._util.printing import entries, number, plain, table


@pytest.mark.parametrize(
    "value, text",
    [
        (2.0, "2.000"),
        (20000.0, "20000"),
        (0.0123456, "0.01235"),
        (-1.5e-9, "-1.500e-09"),
        (1e300, "1.000e+300"),
        (0.0, "0"),
        (7, "7"),
        (math.nan, "-"),
    ],
)
def test_numbers_have_four_digits(value, text):
    assert number(value) == text


def test_tables_have_units_below_names_and_are_aligned_at_the_right():
    text = plain(table(["step", "load (nN)"], [["0/1", 2.0], ["1/1", 20000.0]]))
    assert text.splitlines() == [
        "       load",
        "step   (nN)",
        " 0/1  2.000",
        " 1/1  20000",
    ]


def test_rows_that_are_printed_one_by_one_are_in_line():
    rows = [["0", 2.0], ["1", 1e-9]]
    one_by_one = [
        plain(table(["", "A/A_Hertz"], [row], width=5, header=not i))
        for i, row in enumerate(rows)
    ]
    last = [len(text.splitlines()[-1]) for text in one_by_one]
    assert last[0] == last[1]


def test_long_texts_are_wrapped_at_80_columns_and_brackets_are_kept():
    text = plain("[sphere] radius " * 20, entries([("wall", "repulsive " * 30)]))
    assert max(map(len, text.splitlines())) <= 80
    assert text.count("[sphere]") == 20
