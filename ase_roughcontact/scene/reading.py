"""Reading and comparing the sections of scene files."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

from ase_roughcontact._util.validation import lookup
from ase_roughcontact.scene.config import SECTIONS
from ase_roughcontact.scene.section import Section

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib


def read_sections(text: str, name: str) -> dict[str, Any]:
    """Read the sections of a scene file.

    Parameters
    ----------
    text : str
        TOML.
    name : str
        Name of the file for error messages.

    Returns
    -------
    dict of Section
        Sections of the file by title.

    Raises
    ------
    ValueError
        If the text is not TOML, a section or key is unknown, or a value is of the wrong
        type.
    """
    try:
        document = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{name} is not a TOML file: {error}") from error
    sections = {}
    try:
        for title, entries in document.items():
            section = lookup(title, SECTIONS, "section")
            if not isinstance(entries, dict):
                raise ValueError(f"[{title}] must be a section, got {entries!r}")
            sections[title] = section.of(entries)
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error
    return sections


def differences(
    old: Mapping[str, Section | None], new: Mapping[str, Section | None]
) -> list[str]:
    """Return descriptions of the differences between two scenes.

    Parameters
    ----------
    old, new : mapping of str to Section or None
        Sections by title.

    Returns
    -------
    list of str
        Section, key, old value and new value.
    """
    found = []
    for title in SECTIONS:
        before, after = old.get(title), new.get(title)
        if before is None or after is None:
            if before is not after:
                change = "was removed" if after is None else "was added"
                found.append(f"[{title}] {change}")
            continue
        was, now = before.entries(), after.entries()
        found += [
            f"[{title}] {key} was {_toml(was.get(key))}, is {_toml(now.get(key))}"
            for key in {**was, **now}
            if was.get(key) != now.get(key)
        ]
    return found


def _toml(value: Any) -> str:
    """Return a value as written in a scene file."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return str(list(value))
    return "not given" if value is None else repr(value)
