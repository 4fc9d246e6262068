"""The tables of a scene file: keys, kinds of values, defaults, and reading them."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import (
    FloatArray,
    finite,
    finite_array,
    integer,
    unknown,
)
from ase_roughcontact.interactions import wall_parameters

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

# Steps of a path, at most: a path is held in memory as a whole.
_MOST_STEPS = 1_000_000


@dataclass(frozen=True)
class SubstrateConfig:
    """``[substrate]``: moduli in GPa, spacing in Å."""

    symbol: str = "Cu"
    spacing: float | None = None
    contact_modulus: float | None = None
    elastic_constants: tuple | None = None
    shape: tuple[int, int] | str = "auto"
    periodic: bool = False


@dataclass(frozen=True)
class SphereConfig:
    """``[sphere]``: radius in units of the spacing."""

    radius: float = 1000.0
    profile: Any = "paraboloid"


@dataclass(frozen=True)
class RoughnessConfig:
    """``[roughness]``: wavelengths in units of the spacing."""

    rms_slope: float = 0.1
    hurst: float = 0.8
    short_wavelength: float = 4.0
    long_wavelength: float = 512.0
    longest_wavelength: float | None = None
    seed: int = 0
    random_amplitudes: bool = False
    normalise: Any = "realisation"
    domain: float | None = None


@dataclass(frozen=True)
class InteractionConfig:
    """``[interaction]``: kind of wall, and the parameters of this kind.

    In a file the parameters are keys beside `kind`; the class of the wall defines their
    names and units, see `Interaction`.
    """

    kind: str = "repulsive"
    parameters: Mapping[str, float] = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class PathConfig:
    """``[path]``: loads in nN, penetrations and heights in Å."""

    control: str = "load"
    first: float | None = None
    last: float | None = None
    steps: int | None = None
    scale: str = "geometric"
    values: tuple[float, ...] | None = None

    @property
    def targets(self) -> FloatArray:
        """Loads, penetrations or heights, in the units of the file."""
        ends = {"first": self.first, "last": self.last, "steps": self.steps}
        if self.values is not None:
            listed = finite_array("values", self.values)
            if listed.ndim != 1 or not listed.size:
                raise ValueError(
                    f"values must hold at least one step, got {list(self.values)}"
                )
            both = [key for key, value in ends.items() if value is not None]
            if both:
                raise ValueError(
                    "give values, or first, last and steps, not both: got values and "
                    f"{', '.join(both)}"
                )
            return listed
        missing = [key for key, value in ends.items() if value is None]
        if missing:
            raise ValueError(
                "give first, last and steps, or values instead; not given: "
                f"{', '.join(missing)}"
            )
        first, last, steps = self.first, self.last, integer("steps", self.steps, 1)
        if steps > _MOST_STEPS:
            raise ValueError(f"steps must be at most {_MOST_STEPS}, got {steps}")
        finite(first=first, last=last)
        scales = {"geometric": np.geomspace, "linear": np.linspace}
        scale = choice(self.scale, scales, "scale")
        if self.scale == "geometric" and not (first and last and first * last > 0):
            raise ValueError(
                "a geometric path needs first and last of one sign and not zero, got "
                f"{first} and {last}"
            )
        with np.errstate(over="ignore", invalid="ignore"):
            targets = scale(*np.array([first, last], dtype=float), steps)
        if not np.isfinite(targets).all():
            raise ValueError(f"first = {first} and last = {last} lie too far apart")
        return targets


@dataclass(frozen=True)
class SolverConfig:
    """``[solver]``: fmax in units of E* a0^2."""

    optimizer: str | None = None
    accuracy: float | str = "normal"
    fmax: float | None = None
    max_steps: int = 10_000


SECTIONS: dict[str, type] = {
    "substrate": SubstrateConfig,
    "sphere": SphereConfig,
    "roughness": RoughnessConfig,
    "interaction": InteractionConfig,
    "path": PathConfig,
    "solver": SolverConfig,
}


def read_config(text: str, name: str) -> dict[str, Any]:
    """Read the tables of a scene file.

    Parameters
    ----------
    text : str
        TOML.
    name : str
        Of the file, for errors.

    Returns
    -------
    dict
        Tables by title, those of the file only.

    Raises
    ------
    ValueError
        If the text is not TOML, there is a table or a key that is not known, or a value
        of the wrong kind.
    """
    try:
        given = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{name} is not a TOML file: {error}") from error
    tables = {}
    for title, table in given.items():
        if title not in SECTIONS:
            raise ValueError(f"{name}: {unknown(title, list(SECTIONS), 'table')}")
        if not isinstance(table, dict):
            raise ValueError(f"{name}: [{title}] must be a table, got {table!r}")
        tables[title] = table_of(SECTIONS[title], table, f"{name}: [{title}]")
    return tables


def differences(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    """Tell in what the tables of a scene differ from those of another.

    Parameters
    ----------
    old, new : mapping
        Tables by title; None where there is none.

    Returns
    -------
    list of str
        Table, key, old value and new value.
    """
    told = []
    for title in SECTIONS:
        was, now = old.get(title), new.get(title)
        if was is None or now is None:
            if was is not now:
                kept = "was there and is not" if now is None else "is there and was not"
                told.append(f"[{title}] {kept}")
            continue
        before, after = entries(was), entries(now)
        told += [
            f"[{title}] {key} was {_toml(before.get(key))}, is {_toml(after.get(key))}"
            for key in {**before, **after}
            if before.get(key) != after.get(key)
        ]
    return told


def entries(table: Any) -> dict[str, Any]:
    """Return keys and values of a table as they stand in a file.

    Parameters
    ----------
    table : SubstrateConfig, SphereConfig, ...
        One of the tables.

    Returns
    -------
    dict
        None where a key is not given; the parameters of a wall only if they are.
    """
    values = asdict(table)
    parameters = values.pop("parameters", {})
    return {**values, **parameters}


def changed(table: Any, key: str, value: Any) -> Any:
    """Return a table with another value of a key.

    Parameters
    ----------
    table : SubstrateConfig, SphereConfig, ...
        One of the tables.
    key : str
        Key of the file.
    value : object
        New value.

    Returns
    -------
    type of `table`

    Raises
    ------
    ValueError
        If there is no such key.
    """
    known = list(_types_of(type(table)))
    if key not in known:
        raise ValueError(unknown(key, known, "key"))
    return _made_of(type(table), {**entries(table), key: value})


def table_of(cls: type, given: dict, where: str) -> Any:
    """Make a table of what TOML has read.

    Parameters
    ----------
    cls : type
        One of the tables.
    given : dict
        Keys and values.
    where : str
        Name of file and table, for errors.

    Returns
    -------
    cls

    Raises
    ------
    ValueError
        If there is a key that is not known, or a value of the wrong kind.
    """
    known = _types_of(cls)
    for key, value in given.items():
        if key not in known:
            raise ValueError(f"{where}: {unknown(key, list(known), 'key')}")
        wanted, fits = _kind(known[key])
        if not fits(value):
            raise ValueError(f"{where} {key} must be {wanted}, got {value!r}")
    frozen = {k: tuple(v) if isinstance(v, list) else v for k, v in given.items()}
    return _made_of(cls, frozen)


def _types_of(cls: type) -> dict[str, str]:
    """Return the types of a table's keys."""
    types = {f.name: str(f.type) for f in fields(cls)}
    if types.pop("parameters", None):
        types |= dict.fromkeys(wall_parameters(), "float")
    return types


def _made_of(cls: type, values: dict[str, Any]) -> Any:
    """Return a table of keys and values; `entries` is the inverse."""
    if cls is not InteractionConfig:
        return cls(**values)
    own = {"kind": values["kind"]} if "kind" in values else {}
    given = {key: value for key, value in values.items() if key not in own}
    return cls(**own, parameters=given)


def choice(name: str, choices: Mapping[str, Any], what: str) -> Any:
    """Return what a word stands for.

    Parameters
    ----------
    name : str
        The word.
    choices : mapping
        What the known words stand for.
    what : str
        What the word names, for errors.

    Returns
    -------
    object

    Raises
    ------
    ValueError
        If the word is not known; the error tells the nearest one.
    """
    if name not in choices:
        raise ValueError(unknown(str(name), list(choices), what))
    return choices[name]


def _kind(annotation: str) -> tuple[str, Callable[[Any], bool]]:
    """Name a key's kinds of value, and tell whether a value is of one of them."""
    names = [name.partition("[")[0] for name in annotation.split(" | ")]
    kinds = [_KINDS[name] for name in names if name != "None"]
    return (
        " or ".join(told for told, _ in kinds),
        lambda value: any(fits(value) for _, fits in kinds),
    )


def _toml(value: Any) -> str:
    """Return a value as it stands in a file, or that it does not."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return str(list(value))
    return "not given" if value is None else repr(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


# What TOML may hold for a field of a type; Any stands for one of a few words.
_KINDS: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "tuple": (
        "a list of numbers",
        lambda value: isinstance(value, list) and all(map(_is_number, value)),
    ),
    "bool": ("true or false", lambda value: isinstance(value, bool)),
    "float": ("a number", _is_number),
    "int": ("a number", _is_number),
    "str": ("a word in quotes", lambda value: isinstance(value, str)),
    "Any": ("a word in quotes", lambda value: isinstance(value, str)),
}
