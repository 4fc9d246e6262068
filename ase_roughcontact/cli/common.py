"""What several commands share: scenes, errors, and lines of JSON."""

from __future__ import annotations

import argparse
import json
import math
import warnings
from collections.abc import Mapping
from typing import Any

from ase_roughcontact.scene import Scene, default_text

#: Errors that are printed as a line.
ERRORS = ValueError, RuntimeError, OSError, MemoryError, ImportError


def scene_text(options: argparse.Namespace) -> tuple[str, str]:
    """Return text and name of the scene file, by default of the built-in one."""
    if not options.scene:
        return default_text(), "default.toml"
    return Scene.text_of(options.scene), options.scene


def checked_scene(options: argparse.Namespace) -> Scene:
    """Return the scene; raise `ValueError` if it is invalid."""
    text, name = scene_text(options)
    scene = Scene.parse(text, name)
    scene.check(name)
    for warning in scene.warnings:
        warnings.warn(warning, stacklevel=2)
    return scene


def prints_text(options: argparse.Namespace) -> bool:
    """Return whether text is printed, rather than JSON or nothing."""
    return not (options.quiet or options.json)


def json_line(values: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """Return a line of JSON, with null in place of NaN and infinity.

    Parameters
    ----------
    values : mapping
        Numbers, strings, lists and dicts.
    units : mapping
        Units of the values that have one, written under the key ``units``; those of
        other keys are ignored.

    Returns
    -------
    str
    """
    used = {key: unit for key, unit in units.items() if key in values}
    return json.dumps(_finite({**values, "units": used}))


def _finite(value: Any) -> Any:
    """Return a value with None in place of numbers that are not finite."""
    if isinstance(value, dict):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
