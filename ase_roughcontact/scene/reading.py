"""Reading of scene files."""

from __future__ import annotations

import sys
from typing import Any

from ase_roughcontact._util.validation import lookup
from ase_roughcontact.scene.config import SECTIONS

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
