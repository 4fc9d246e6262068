"""The cases of an ensemble: variants of a scene, and their names."""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.config import SECTIONS
from ase_roughcontact.scene.model import DEFAULT_RADIUS


def product(scene: Scene, choices: Mapping[str, Iterable]) -> list[Scene]:
    """Return variants of a scene, one for each combination of values of some keys.

    Parameters
    ----------
    scene : Scene
        Provides all other values.
    choices : mapping
        Values by key, in the units of the scene file: ``"sphere.radius"``,
        ``"roughness.seed"``; or whole sections by title, where keys belong together:
        ``"interaction": [InteractionConfig("hard"), InteractionConfig("adhesive",
        {"work_of_adhesion": 0.05})]``.

    Returns
    -------
    list of Scene
        The last key varies fastest.

    Raises
    ------
    ValueError
        If a section or key is unknown, or has no values.
    """
    scenes = [scene]
    for key, choice in choices.items():
        values = [_plain_number(value) for value in choice]
        if not values:
            raise ValueError(f"{key} must have at least one value, got none")
        scenes = [
            scene.with_values({key: value})
            for scene, value in itertools.product(scenes, values)
        ]
    return scenes


def case_of(scene: Scene) -> str:
    """Return the name of a scene's case, "c" and a hash of all values of the scene.

    Values that equal their default are left out of the hash, so that keys added to the
    scene file later do not change it. Numbers are rounded to twelve digits, so that
    rounding errors of different machines do not. The name starts with a letter because
    ASE's databases refuse text that reads as a number.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    str
        16 characters.
    """
    defaults = {
        title: _json_value(kind().entries()) for title, kind in SECTIONS.items()
    }
    defaults["sphere"]["radius"] = DEFAULT_RADIUS  # that of no radius
    values = {
        title: {
            key: _rounded(value)
            for key, value in section.items()
            if value is not None and value != defaults[title].get(key)
        }
        for title, section in scene_as_dict(scene).items()
        if section is not None
    }
    text = json.dumps(values, sort_keys=True)
    return "c" + hashlib.sha256(text.encode()).hexdigest()[:15]


def scene_as_dict(scene: Scene) -> dict[str, Any]:
    """Return the values of a scene as JSON types, the same for equal values.

    Raises
    ------
    ValueError
        If a value is not text, a number, a truth value or a sequence of these.
    """
    return _json_value(scene.entries())


def _plain_number(value: Any) -> Any:
    """Return a NumPy scalar as the Python number, all else unchanged."""
    return value.item() if isinstance(value, np.generic) else value


def _json_value(value: Any) -> Any:
    value = value.tolist() if isinstance(value, np.ndarray) else _plain_number(value)
    if isinstance(value, dict):
        return {key: _json_value(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_json_value(item) for item in value]
    if isinstance(value, float) and value.is_integer():
        return int(value)
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise ValueError(f"values of a scene must be text or numbers, got {value!r}")


def _rounded(value: Any) -> Any:
    """Return a value with all its numbers rounded to twelve digits."""
    if isinstance(value, list):
        return [_rounded(item) for item in value]
    if not isinstance(value, float):
        return value
    text = f"{value:.12g}"
    return int(float(text)) if float(text).is_integer() else text
