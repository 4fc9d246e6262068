"""The cases of an ensemble: variants of a scene, and their names."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping
from typing import Any

from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.section import plain_values


def product(scene: Scene, choices: Mapping[str, Iterable]) -> list[Scene]:
    """Return variants of a scene, one for each combination of values of some keys.

    Parameters
    ----------
    scene : Scene
        Scene with the values of all other keys.
    choices : mapping
        Values by key, in the units of the scene file: ``"sphere.radius"``,
        ``"roughness.seed"``; or whole sections by title, where keys belong together:
        ``"interaction": [InteractionConfig("hard"), InteractionConfig("adhesive",
        {"work_of_adhesion": 0.05})]``.

    Returns
    -------
    list of Scene
        Variants; the last key varies fastest.

    Raises
    ------
    ValueError
        If a section or key is unknown, or has no values.
    """
    scenes = [scene]
    for key, choice in choices.items():
        values = [plain_values(value) for value in choice]
        if not values:
            raise ValueError(f"{key} must have at least one value, got none")
        scenes = [
            scene.with_values({key: value})
            for scene, value in itertools.product(scenes, values)
        ]
    return scenes


def case_of(scene: Scene) -> str:
    """Return the name of a scene's case: "c" and digits of its `identity`.

    ASE's databases refuse text that reads as a number, hence the letter.

    Parameters
    ----------
    scene : Scene
        The scene.

    Returns
    -------
    str
        Name of 16 characters.

    Raises
    ------
    ValueError
        If a value is not text, a number, a truth value or a sequence of these.
    """
    return f"c{scene.identity[:15]}"


def case_names(cases: Mapping[str, Scene]) -> dict[str, str]:
    """Return the values by which each case differs from others, as text.

    Parameters
    ----------
    cases : mapping of str to Scene
        Scenes by the names of `case_of`.

    Returns
    -------
    dict of str
        Texts such as "sphere.radius = 60.0, roughness.seed = 3"; the seed of a single
        rough scene.
    """
    entries = {case: _flat(scene) for case, scene in cases.items()}
    keys: dict[str, None] = {}
    for values in entries.values():
        keys |= dict.fromkeys(values)
    first = next(iter(entries.values()), {})
    named = []
    for key in keys:
        if any(values.get(key) != first.get(key) for values in entries.values()):
            named.append(key)
    if not named and "roughness.seed" in keys:
        named = ["roughness.seed"]
    names = {}
    for case, values in entries.items():
        texts = [f"{key} = {_text(values.get(key))}" for key in named]
        names[case] = ", ".join(texts) or "the scene"
    return names


def _text(value: Any) -> str:
    return str(list(value) if isinstance(value, tuple) else value)


def _flat(scene: Scene) -> dict[str, Any]:
    """Return the values of a scene by section and key."""
    flat = {}
    for title, entries in scene.entries().items():
        for key, value in entries.items():
            flat[f"{title}.{key}"] = value
    return flat
