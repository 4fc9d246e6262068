"""Printed numbers and tables."""

import io
import math

import pytest
from rich.console import Console

from ase_roughcontact._util.printing import entries, note, number, plain, table
from ase_roughcontact._util.tables import TableRows


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


HEADS = "step", "load (nN)", "p max (GPa)", ""


def printed_in(columns, *parts):
    """Lines on a screen of some columns."""
    text = io.StringIO()
    Console(file=text, width=columns).print(*parts)
    return [line.rstrip() for line in text.getvalue().splitlines()]


def test_rows_that_are_printed_one_by_one_are_in_line():
    rows = TableRows(HEADS, [4, 9, 9, 1])
    cells = ["0/1", "2.000", "0.1", ""], ["1/1", "1.000e-09", "-1.2", "*"]
    text = [plain(rows.row(each)) for each in cells]
    assert "\n".join(text).splitlines() == [
        "           load      p max",
        "step       (nN)      (GPa)",
        " 0/1      2.000        0.1",
        " 1/1  1.000e-09       -1.2  *",
    ]


def test_columns_that_do_not_fit_are_named_and_marks_are_kept():
    rows = TableRows(HEADS, [4, 9, 9, 1])
    cells = ["0/1", "2.000", "0.1", "*"]
    assert printed_in(28, rows.row(cells)) == [
        "Left out on a screen of 28",
        "characters: p max (29 show",
        "all).",
        "           load",
        "step       (nN)",
        " 0/1      2.000  *",
    ]
    assert printed_in(28, rows.row(cells)) == [" 0/1      2.000  *"]
    # the window was enlarged
    assert printed_in(29, rows.row(cells))[2:] == [" 0/1      2.000        0.1  *"]


def test_a_row_with_a_number_that_is_too_long_is_wrapped():
    rows = TableRows(HEADS, [4, 9, 9, 1])
    cells = ["1/1", "-1.000e+100", "-1.000e+100", "*"]
    first, second = (printed_in(29, rows.row(cells)) for _ in range(2))
    assert first == [
        "           load      p max",
        "step       (nN)      (GPa)",
        *second,
    ]
    assert " ".join(second).split() == cells
    assert max(map(len, second)) <= 29


def test_a_whole_table_is_as_wide_as_its_entries_and_texts_are_wrapped():
    found = table(["", "choice", "cost"], [["grid", "half the spacing", 1.0]], left=2)
    assert printed_in(29, found)[-1] == "grid  half the spacing  1.000"
    narrow = printed_in(24, found)
    assert "Left" not in narrow[0] and narrow[-1] == "      spacing"


def test_texts_for_files_have_no_escape_codes(monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    parts = note("not converged", 4, "bold red"), table(["load"], [[1.0]])
    assert plain(*parts).splitlines() == ["    not converged", " load", "1.000"]


def test_long_texts_are_wrapped_at_80_columns_and_brackets_are_kept():
    text = plain("[sphere] radius " * 20, entries([("wall", "repulsive " * 30)]))
    assert max(map(len, text.splitlines())) <= 80
    assert text.count("[sphere]") == 20
