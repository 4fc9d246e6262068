"""Identity of a calculation: equal values and file contents, for any file names.

Databases of ensembles, folders of results and resumed paths compare calculations by
these functions. Numbers are the same if twelve digits agree, so that rounding errors of
another machine do not matter. Arrays and files are the same if all bytes agree.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache, partial
from numbers import Number
from pathlib import Path
from typing import Any

import numpy as np

# Longest time between two changes of a file that may have the same time stamp (ns).
_CLOCK_RESOLUTION = 2_000_000_000


def identity(values: Mapping[str, Any]) -> str:
    """Return a hash, 64 hexadecimal digits, of all that a calculation depends on."""
    text = json.dumps(canonical(values), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def canonical(value: Any) -> Any:
    """Return JSON types that are equal if, and only if, two values are the same.

    Values are text, numbers, truth values, None, arrays, paths of files, and dicts or
    sequences of these. A file that exists is represented by its contents.

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


def name_of(value: Any) -> str:
    """Return a name that is the same in all processes.

    Numbers and strings are their own name. What is called has the name of its
    definition, with the arguments that are bound to it. Any other object has the name
    of its class, with the fields of a dataclass or what `todict` returns.
    """
    if value is None or isinstance(value, (Number, np.generic, str, os.PathLike)):
        return str(value)
    if isinstance(value, partial):
        bound = [name_of(each) for each in value.args]
        bound += _named(value.keywords)
        return " ".join([name_of(value.func), *bound])
    if hasattr(value, "__qualname__"):
        return str(value.__qualname__)
    if isinstance(value, np.ndarray):
        return digest(value.tobytes())
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(name_of, value))}]"
    if isinstance(value, Mapping):
        return f"{{{', '.join(_named(value))}}}"
    parameters = {}
    if hasattr(value, "todict"):
        parameters = value.todict()
    elif is_dataclass(value):
        parameters = {each.name: getattr(value, each.name) for each in fields(value)}
    return " ".join([type(value).__qualname__, *_named(parameters)])


def _named(values: Mapping[str, Any]) -> list[str]:
    return [f"{name}={name_of(value)}" for name, value in values.items()]


def digest(contents: bytes) -> str:
    """Return a hash of bytes, 16 hexadecimal digits."""
    return hashlib.sha256(contents).hexdigest()[:16]


def differences(old: Any, new: Any, name: str = "") -> list[str]:
    """Return one line for each value that differs between two nested dicts.

    Values have dotted names, which begin with the given one.
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

    A change is found by the time of change, since any program can set the time of
    modification. Two changes within the resolution of the clock have the same time: a
    file that changed recently is read again.
    """
    status = file.stat()
    if abs(time.time_ns() - status.st_ctime_ns) < _CLOCK_RESOLUTION:
        return digest(file.read_bytes())
    return _digest_of(file, status.st_ino, status.st_size, status.st_ctime_ns)


@lru_cache(maxsize=64)
def _digest_of(file: Path, *changed: int) -> str:
    return digest(file.read_bytes())
