"""Crystals and surfaces in files (JSON)."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import numpy as np

from ase_roughcontact._util.files import replaced

AnyStored = TypeVar("AnyStored", bound="Stored")


class Stored:
    """Base class of dataclasses that can be written to files."""

    #: Name of the kind of object in the file, as "crystal".
    _kind: ClassVar[str]

    @classmethod
    def read(cls: type[AnyStored], file: str | Path) -> AnyStored:
        """Read a file written by `write`; raise `ValueError` for other files."""
        try:
            entries = json.loads(Path(file).read_text("utf-8"))
            if entries.pop("format") != cls._format():
                raise ValueError(f"its format is not {cls._format()!r}")
            return cls._of(entries)
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"{file} is not a {cls._kind}: {error}") from error

    def write(self, file: str | Path) -> None:
        """Write the object to a file (JSON), one entry on each line."""
        entries = {"format": self._format(), **asdict(self)}  # type: ignore[call-overload]
        lines = (
            f"{json.dumps(key)}: {json.dumps(value, default=np.ndarray.tolist)}"
            for key, value in entries.items()
        )
        with replaced(file) as name:
            Path(name).write_text("{\n" + ",\n".join(lines) + "\n}\n", "utf-8")

    @classmethod
    def _of(cls: type[AnyStored], entries: dict[str, Any]) -> AnyStored:
        return cls(**entries)

    @classmethod
    def _format(cls) -> str:
        return f"{cls._kind} of ase_roughcontact, version 1"
