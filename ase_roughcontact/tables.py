"""The tables of a scene file: keys, kinds of values, and defaults."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any

from ase_roughcontact.checks import unknown


@dataclass(frozen=True)
class SubstrateTable:
    """``[substrate]``: moduli in GPa, spacing in Å."""

    symbol: str = "Cu"
    spacing: float | None = None
    contact_modulus: float | None = None
    elastic_constants: tuple | None = None
    shape: tuple[int, int] | str = "auto"
    periodic: bool = False


@dataclass(frozen=True)
class SphereTable:
    """``[sphere]``: radius in units of the spacing."""

    radius: float = 1000.0
    profile: Any = "paraboloid"


@dataclass(frozen=True)
class RoughnessTable:
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
class InteractionTable:
    """``[interaction]``: work of adhesion in J/m^2, cutoff in units of the spacing."""

    kind: str = "repulsive"
    work_of_adhesion: float | None = None
    cutoff: float | None = None


@dataclass(frozen=True)
class PathTable:
    """``[path]``: loads in nN, penetrations and heights in Å."""

    control: str = "load"
    first: float | None = None
    last: float | None = None
    steps: int | None = None
    scale: str = "geometric"
    values: tuple[float, ...] | None = None


@dataclass(frozen=True)
class SolverTable:
    """``[solver]``: fmax in units of E* a0^2."""

    optimizer: str | None = None
    accuracy: float | str = "normal"
    fmax: float | None = None
    max_steps: int = 10_000


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
    known = {f.name: str(f.type) for f in fields(cls)}
    for key, value in given.items():
        if key not in known:
            raise ValueError(f"{where}: {unknown(key, list(known), 'key')}")
        wanted, fits = _kind(known[key])
        if not fits(value):
            raise ValueError(f"{where}: {key} must be {wanted}, got {value!r}")
    frozen = {k: tuple(v) if isinstance(v, list) else v for k, v in given.items()}
    return cls(**frozen)


def _kind(annotation: str) -> tuple[str, Callable[[Any], bool]]:
    """Name a key's kinds of value, and tell whether a value is of one of them."""
    names = [name.partition("[")[0] for name in annotation.split(" | ")]
    kinds = [_KINDS[name] for name in names if name != "None"]
    return (
        " or ".join(told for told, _ in kinds),
        lambda value: any(fits(value) for _, fits in kinds),
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


# What TOML may hold for a field of a type; Any stands for one of a few words.
_KINDS: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "tuple": ("a list", lambda value: isinstance(value, list)),
    "bool": ("true or false", lambda value: isinstance(value, bool)),
    "float": ("a number", _is_number),
    "int": ("a number", _is_number),
    "str": ("a word in quotes", lambda value: isinstance(value, str)),
    "Any": ("a word in quotes", lambda value: isinstance(value, str)),
}
