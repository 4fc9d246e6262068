"""The cases of an ensemble: variants of a scene, and their names."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ase_roughcontact._util.validation import lookup
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.section import plain_values


def combinations(
    choices: Mapping[str, Iterable], together: Sequence[str] = ()
) -> list[dict[str, Any]]:
    """Return all combinations of values of some keys.

    Parameters
    ----------
    choices : mapping
        Values by key.
    together : sequence of str
        Keys that vary together: the first value of one goes with the first values of
        the others, the second with the second ones, and so on.

    Returns
    -------
    list of dict
        Values by key; the last key varies fastest.

    Raises
    ------
    ValueError
        If a key has no values, or keys that vary together have different numbers of
        values.
    """
    values = {key: list(choice) for key, choice in choices.items()}
    for key, listed in values.items():
        if not listed:
            raise ValueError(f"{key} must have at least one value, got none")
    for key in together:
        lookup(key, values, "parameter of the study")
    counts = {key: len(values[key]) for key in together}
    if len(set(counts.values())) > 1:
        raise ValueError(
            "keys that vary together need equal numbers of values, got "
            + ", ".join(f"{count} of {key}" for key, count in counts.items())
        )
    groups = []  # each group has its settings: values by key
    for key, listed in values.items():
        if key not in together:
            groups.append([{key: value} for value in listed])
        elif key == together[0]:
            joined = zip(*(values[each] for each in together), strict=True)
            groups.append([dict(zip(together, each, strict=True)) for each in joined])
    combined = []
    for chosen in itertools.product(*groups):
        settings = {key: value for group in chosen for key, value in group.items()}
        combined.append({key: settings[key] for key in values})
    return combined


def product(
    scene: Scene, choices: Mapping[str, Iterable], together: Sequence[str] = ()
) -> list[Scene]:
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
    together : sequence of str
        Keys that vary together; see `combinations`.

    Returns
    -------
    list of Scene
        Variants; the last key varies fastest.

    Raises
    ------
    ValueError
        If a section or key is unknown, or has no values, or keys that vary together
        have different numbers of values.
    """
    variants = []
    for settings in combinations(choices, together):
        plain = {key: plain_values(value) for key, value in settings.items()}
        variants.append(scene.with_values(plain))
    return variants


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
    if not named:
        endings = "roughness.seed", "topography.seed"
        named = [key for key in keys if key.endswith(endings)]
    names = {}
    for case, values in entries.items():
        texts = [f"{key} = {_text(values.get(key))}" for key in named]
        names[case] = ", ".join(texts) or "the scene"
    return names


def _text(value: Any) -> str:
    return str(list(value) if isinstance(value, tuple) else value)


def _flat(scene: Scene) -> dict[str, Any]:
    """Return the values of a scene by section and key, of ranges by their keys, too."""
    flat = {}
    for title, entries in scene.entries().items():
        for key, value in entries.items():
            given = {key: value}
            if isinstance(value, Mapping):
                given = {f"{key}.{name}": each for name, each in value.items()}
            for name, each in given.items():
                flat[f"{title}.{name}"] = each
    return flat
