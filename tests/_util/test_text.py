"""Entries of printed tables."""

import pytest

from ase_roughcontact._util.text import cell


@pytest.mark.parametrize(
    "value, form, text",
    [
        (1.5, ".4f", "    1.5000"),
        (-12345.678, ".4f", " -1.235e+04"),
        (1e300, ".2f", "    1e+300"),
        ("1000000x1000000", "", " 1000000x1000000"),
        ("8x8", "", "       8x8"),
    ],
)
def test_entries_are_aligned_and_begin_with_a_blank(value, form, text):
    assert cell(value, 10, form) == text
