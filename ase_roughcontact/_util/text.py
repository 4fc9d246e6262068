"""Entries of printed tables: numbers of limited width, and times."""

from datetime import timedelta

_YEAR = 365.25 * 86400.0
# Time above which years are printed (s).
_LONG = 100.0 * _YEAR


def cell(value: str | float, width: int, form: str = "") -> str:
    """Return an entry of a table, right-aligned, with a blank before it at least.

    Entries longer than the width extend beyond it. The form is the format of a number,
    ``".2f"``; in its place ``".2g"`` if that is too wide.
    """
    text = format(value, form)
    if len(text) >= width and form.endswith("f"):
        text = format(value, f"{form[:-1]}g")
    return f" {text:>{width - 1}}"


def duration(seconds: float) -> str:
    """Return a time (s) as hours, minutes and seconds, or as years if very long."""
    if seconds > _LONG:
        return f"{seconds / _YEAR:.2g} years"
    return str(timedelta(seconds=round(seconds)))
