"""Identity of a calculation: the same values and contents, whatever their files' names.

Databases of ensembles, folders of results and resumed paths compare what a calculation
depends on by these functions. Numbers are the same if twelve digits are, so that other
rounding errors on another machine are no difference; arrays and files if all bytes are.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

# Time since a change of a file during which another one may have the same time (ns).
_RECENT = 2_000_000_000


def identity(values: Mapping[str, Any]) -> str:
    """Return a hash, 64 hexadecimal digits, of all that a calculation depends on."""
    text = json.dumps(canonical(values), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def canonical(value: Any) -> Any:
    """Return JSON types that are equal if, and only if, two values are the same.

    Values are text, numbers, truth values, None, arrays, paths of files, and dicts or
    sequences of these. The contents stand for a file, if it exists.

    Raises
    ------
    ValueError
        If the value is of another type.
    """
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, Mapping):
        return {key: canonical(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [canonical(item) for item in value]
    if isinstance(value, float):
        text = f"{value:.12g}"
        return int(float(text)) if float(text).is_integer() else text
    if isinstance(value, np.ndarray):
        return digest(value.tobytes())
    if isinstance(value, Path):
        return digest_of_file(value) if value.is_file() else str(value)
    if value is None or isinstance(value, (bool, int, str)):
        return value
    raise ValueError(f"values must be text, numbers, arrays or files, got {value!r}")


def digest(contents: bytes) -> str:
    """Return a hash of bytes, 16 hexadecimal digits."""
    return hashlib.sha256(contents).hexdigest()[:16]


def differences(old: Any, new: Any, name: str = "") -> list[str]:
    """Return one line for each value that differs between two nested dicts.

    The name of the dicts is part of the dotted names of what is in them.
    """
    if not (isinstance(old, dict) and isinstance(new, dict)):
        same = canonical(old) == canonical(new)
        return [] if same else [f"{name or 'system'} was {old}, is {new}"]
    return [
        line
        for key in {**old, **new}
        for line in differences(old.get(key), new.get(key), f"{name}.{key}".strip("."))
    ]


def digest_of_file(file: Path) -> str:
    """Return a hash of the contents of a file, which is read again if it changed.

    The time of modification can be set by any program. The time of change can't, but
    two changes within the resolution of the clock have the same one: it is not relied
    on while it is recent.
    """
    status = file.stat()
    if abs(time.time_ns() - status.st_ctime_ns) < _RECENT:
        return digest(file.read_bytes())
    return _digest_of(file, status.st_ino, status.st_size, status.st_ctime_ns)


@lru_cache(maxsize=64)
def _digest_of(file: Path, *changed: int) -> str:
    return digest(file.read_bytes())
