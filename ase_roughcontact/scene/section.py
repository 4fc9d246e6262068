"""Base class of the sections of a scene file: keys and types of their values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from types import UnionType
from typing import Any, ClassVar, TypeVar, get_args, get_origin, get_type_hints

from ase_roughcontact._util.units import QUANTITY, UNITS, quantity, units_like
from ase_roughcontact._util.validation import shown, unknown

AnySection = TypeVar("AnySection", bound="Section")


class Quantities(tuple):
    """Type of a key whose value is a list of quantities: numbers, or with a unit."""


# Largest number of characters of a string in a scene file: names, also of files.
_LONGEST_WORD = 1000


@dataclass(frozen=True)
class Section:
    """Base class of the sections of a scene file; the fields are its keys.

    Attributes
    ----------
    title : str
        Name of the section in a file.
    units : mapping of str to str
        Units of the keys that may be given as a string with another unit, which is
        converted, and do not depend on the spacing of atoms.
    """

    title: ClassVar[str]
    units: ClassVar[Mapping[str, str]] = {}

    def __post_init__(self) -> None:
        """Convert quantities with a unit to numbers."""
        for key, unit in self.units.items():
            value = _in_unit(key, getattr(self, key), unit)
            object.__setattr__(self, key, value)

    @classmethod
    def of(cls: type[AnySection], entries: Mapping[str, Any]) -> AnySection:
        """Return the section with the given entries, and defaults for other keys.

        Parameters
        ----------
        entries : mapping
            Values by key, as read from TOML.

        Returns
        -------
        Section

        Raises
        ------
        ValueError
            If a key is unknown, or a value is of the wrong type.
        """
        types = cls.types()
        for name, value in entries.items():
            if name not in types:
                problem = unknown(name, list(types), "key")
                raise ValueError(f"[{cls.title}] {problem}")
            if not any(_is_of_type(value, each) for each in types[name]):
                expected = " or ".join(filter(None, map(_TYPES.get, types[name])))
                raise ValueError(
                    f"[{cls.title}] {name} must be {expected}, got {shown(value)}"
                )
            if isinstance(value, str) and len(value) > _LONGEST_WORD:
                raise ValueError(
                    f"[{cls.title}] {name} must be a word of at most {_LONGEST_WORD} "
                    f"characters, got {len(value)}: {shown(value)}"
                )
        return cls._of(
            {k: tuple(v) if isinstance(v, list) else v for k, v in entries.items()}
        )

    @classmethod
    def types(cls) -> dict[str, tuple[type, ...]]:
        """Return the types that each key accepts."""
        hints = get_type_hints(cls)
        types = {each.name: _members(hints[each.name]) for each in fields(cls)}
        with_units = {
            key: (*(Quantities if each is tuple else each for each in types[key]), str)
            for key in cls.units
        }
        return types | with_units

    def entries(self) -> dict[str, Any]:
        """Return the values by key, None for keys that are not given."""
        return asdict(self)

    def changed(self: AnySection, name: str, value: Any) -> AnySection:
        """Return the section with another value of a key; errors are those of `of`."""
        return self.of({**self.entries(), name: value})

    @classmethod
    def _of(cls: type[AnySection], entries: Mapping[str, Any]) -> AnySection:
        return cls(**entries)


def _in_unit(key: str, value: Any, unit: str) -> Any:
    """Return a number or a tuple in a unit, of strings with one."""
    if isinstance(value, str):
        return quantity(key, value, units_like(unit)) / UNITS[unit]
    if isinstance(value, tuple):
        return tuple(_in_unit(key, each, unit) for each in value)
    return value


def find_file(name: str, folder: Path) -> str:
    """Return the whole path of a file that a scene names.

    Parameters
    ----------
    name : str
        May be empty, for none.
    folder : Path
        Folder of the scene file. The file is sought at its path relative to this
        folder, and then in the folder itself, where a run has copied it.

    Returns
    -------
    str
    """
    if not name:
        return name
    places = folder / name, folder / Path(name).name
    found = next((place for place in places if place.is_file()), places[0])
    return str(found.resolve())


def _members(hint: Any) -> tuple[type, ...]:
    """Return the types of a union; generic types without their parameters."""
    members = get_args(hint) if get_origin(hint) is UnionType else (hint,)
    return tuple(get_origin(member) or member for member in members)


def _is_of_type(value: Any, kind: type) -> bool:
    if kind is tuple:
        is_list = isinstance(value, (list, tuple))
        return is_list and all(_is_of_type(each, float) for each in value)
    if kind is Quantities:
        is_list = isinstance(value, (list, tuple))
        return is_list and all(
            _is_of_type(each, float)
            or (isinstance(each, str) and QUANTITY.fullmatch(each))
            for each in value
        )
    if kind in (int, float):
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    return isinstance(value, kind)


# Descriptions of the types of values.
_TYPES: dict[type, str] = {
    Quantities: "a list of numbers",
    tuple: "a list of numbers",
    bool: "true or false",
    float: "a number",
    int: "a number",
    str: "a string",
}
