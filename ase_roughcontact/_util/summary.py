"""Short representations of objects: a line of text, and a table in notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from html import escape
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import shown

# Length of the longest text of a value.
_MAX_LENGTH = 100
# Largest number of items of a sequence that are shown.
_MAX_ITEMS = 3


class Summarized:
    """Base class of objects that are shown by a few values, never by whole arrays.

    A dataclass is shown by its fields that differ from their defaults. A subclass with
    other values overrides `_summary`; values that it names have their units there.
    """

    def __init_subclass__(cls, **keywords: Any) -> None:
        """Set `__repr__`, which the decorator of a dataclass would replace."""
        super().__init_subclass__(**keywords)
        if "__repr__" not in vars(cls):
            cls.__repr__ = Summarized.__repr__  # type: ignore[method-assign]

    def _summary(self) -> dict[str, str]:
        """Return the most important values as texts with their units, by name."""
        if not is_dataclass(self):
            return {}
        return {
            each.name: short_text(getattr(self, each.name))
            for each in fields(self)
            if each.repr and not _is_default(each.default, getattr(self, each.name))
        }

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={text}" for name, text in self._summary().items())
        return f"{type(self).__name__}({values})"

    def _repr_html_(self) -> str:
        """Return a table for notebooks."""
        return html_table(type(self).__name__, (), self._summary().items())


def html_table(
    title: str, heads: Sequence[str], rows: Iterable[Sequence[object]]
) -> str:
    """Return a table of texts in HTML.

    Parameters
    ----------
    title : str
        Title of the table.
    heads : sequence of str
        Headings of the columns; empty without a line of headings.
    rows : iterable of sequences
        Entries of each row; the first one is its heading.
    """
    lines = [f"<table><caption>{escape(title)}</caption>"]
    if heads:
        cells = "".join(f"<th>{escape(head)}</th>" for head in heads)
        lines.append(f"<tr>{cells}</tr>")
    for first, *others in rows:
        cells = "".join(f"<td>{escape(str(each))}</td>" for each in others)
        lines.append(f"<tr><th>{escape(str(first))}</th>{cells}</tr>")
    return "\n".join([*lines, "</table>"])


def short_text(value: Any, unit: str = "") -> str:
    """Return a value as a short text: an array by its shape, a long list by its length.

    Parameters
    ----------
    value : object
    unit : str
        Unit that is appended to a number.
    """
    if isinstance(value, np.ndarray):
        return f"<array {' x '.join(map(str, value.shape))}>"
    if isinstance(value, (float, np.floating)):
        return f"{value:.5g} {unit}".rstrip()
    if isinstance(value, Mapping):
        return _listed(value, "{}")
    if isinstance(value, (tuple, list)):
        brackets = "()" if isinstance(value, tuple) else "[]"
        if len(value) > _MAX_ITEMS:
            return f"<{len(value)} items>"
        return _listed(map(short_text, value), brackets)
    if isinstance(value, type):
        return value.__name__
    text = shown(value) if isinstance(value, str) else repr(value)
    if len(text) > _MAX_LENGTH and not isinstance(value, str):
        return f"<{type(value).__name__}>"
    return text


def _listed(items: Iterable[Any], brackets: str) -> str:
    return f"{brackets[0]}{', '.join(map(str, items))}{brackets[1]}"


def _is_default(default: Any, value: Any) -> bool:
    """Return whether a value is the default of its field."""
    if isinstance(value, np.ndarray) or isinstance(default, np.ndarray):
        return default is value
    return bool(default is value or default == value)
