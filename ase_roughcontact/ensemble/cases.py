"""The cases of an ensemble: scenes that differ in some keys, and their names."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import unknown
from ase_roughcontact.scene import RoughnessConfig, Scene
from ase_roughcontact.scene.config import changed, entries


def product(scene: Scene, choices: Mapping[str, Iterable]) -> list[Scene]:
    """Combine all values of some keys of a scene.

    Parameters
    ----------
    scene : Scene
        Gives everything else.
    choices : mapping
        Values by key, in the units of the scene file: ``"sphere.radius"``,
        ``"roughness.seed"``; or whole tables by title, where keys go together:
        ``"interaction": [InteractionConfig("hard"), InteractionConfig("adhesive",
        {"work_of_adhesion": 0.05})]``.

    Returns
    -------
    list of Scene
        The last key varies fastest.

    Raises
    ------
    ValueError
        If there is no such table or key, or no value for it.
    """
    scenes = [scene]
    for key, given in choices.items():
        values = [_scalar(value) for value in given]
        if not values:
            raise ValueError(f"{key} must have at least one value, got none")
        scenes = [
            _changed(scene, key, value)
            for scene, value in itertools.product(scenes, values)
        ]
    return scenes


def case_of(scene: Scene) -> str:
    """Name of a scene's case: "c" and the start of the SHA-256 of all that it says.

    Defaults are left out, so that keys to come do not change it, and numbers count to
    twelve digits, so that another machine's rounding does not. A letter comes first
    since ASE's databases take no text that reads as a number.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    str
    """
    usual = tables(Scene(roughness=RoughnessConfig()))
    told = {
        title: {
            key: _rounded(value)
            for key, value in table.items()
            if value != usual[title].get(key)
        }
        for title, table in tables(scene).items()
        if table is not None
    }
    text = json.dumps(told, sort_keys=True)
    return "c" + hashlib.sha256(text.encode()).hexdigest()[:15]


def tables(scene: Scene) -> dict[str, Any]:
    """Tables of a scene in what JSON knows, the same for equal values.

    Raises
    ------
    ValueError
        If a value is neither a word nor a number, nor made of these.
    """
    named = {f.name: getattr(scene, f.name) for f in fields(scene)}
    return _plain({title: table and entries(table) for title, table in named.items()})


def inputs(scene: Scene) -> dict[str, Any]:
    """Columns of a step that the scene knows from the start; see `COLUMNS`."""
    rough = scene.roughness
    work = scene.interaction.parameters.get("work_of_adhesion")
    return {
        "control": scene.path.control,
        "radius": float(scene.sphere.radius),
        "rms_slope": 0.0 if rough is None else float(rough.rms_slope),
        "hurst": math.nan if rough is None else float(rough.hurst),
        "short_wavelength": math.nan if rough is None else rough.short_wavelength,
        "long_wavelength": math.nan if rough is None else rough.long_wavelength,
        "seed": -1 if rough is None else int(rough.seed),
        "kind": scene.interaction.kind,
        "work_of_adhesion": math.nan if work is None else float(work),
        "spacing": float(scene.spacing),
        "contact_modulus": float(scene.contact_modulus),
    }


def _changed(scene: Scene, key: str, value: Any) -> Scene:
    """Scene with another value of a key, or another table."""
    title, _, name = key.partition(".")
    titles = [f.name for f in fields(Scene)]
    if title not in titles:
        raise ValueError(unknown(title, titles, "table"))
    if not name:
        return replace(scene, **{title: value})
    table = getattr(scene, title)
    if table is None:
        raise ValueError(f"the scene has no [{title}]: {key} can't be changed")
    try:
        return replace(scene, **{title: changed(table, name, value)})
    except ValueError as error:
        raise ValueError(f"[{title}]: {error}") from error


def _scalar(value: Any) -> Any:
    """Return a plain number in place of one of numpy's."""
    return value.item() if isinstance(value, np.generic) else value


def _plain(value: Any) -> Any:
    """Return what JSON knows, the same for equal values."""
    value = value.tolist() if isinstance(value, np.ndarray) else _scalar(value)
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    if isinstance(value, float) and value.is_integer():
        return int(value)
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    raise ValueError(f"a scene must hold words and numbers only, got {value!r}")


def _rounded(value: Any) -> Any:
    """Return a value with all its numbers to twelve digits."""
    if isinstance(value, list):
        return [_rounded(inner) for inner in value]
    if not isinstance(value, float):
        return value
    told = f"{value:.12g}"
    return int(float(told)) if float(told).is_integer() else told
