"""Crystals and surfaces in files (JSON)."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ase_roughcontact._util.files import replaced

T = TypeVar("T")


def write_json(file: str | Path, kind: str, entries: dict[str, Any]) -> None:
    """Write entries, one on each line; `kind` says what they describe."""
    entries = {"format": _format(kind), **entries}
    lines = (
        f"{json.dumps(key)}: {json.dumps(value, default=np.ndarray.tolist)}"
        for key, value in entries.items()
    )
    with replaced(file) as name:
        Path(name).write_text("{\n" + ",\n".join(lines) + "\n}\n")


def read_json(file: str | Path, kind: str, make: Callable[[dict[str, Any]], T]) -> T:
    """Make an object of the entries in a file; raise `ValueError` if it can't be."""
    try:
        entries = json.loads(Path(file).read_text())
        if entries.pop("format") != _format(kind):
            raise ValueError("its format is another one")
        return make(entries)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"{file} is not a {kind}: {error}") from error


def _format(kind: str) -> str:
    return f"{kind} of ase_roughcontact, version 1"
