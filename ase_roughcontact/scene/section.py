"""Base class of the sections of a scene file: keys, types, units and files.

Quantities are numbers, or strings with a unit: ``"30 nm"``, ``"2.5 Å"``, ``"50 nN"``.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from copy import copy
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from types import UnionType
from typing import (
    Any,
    ClassVar,
    TypeVar,
    get_args,
    get_origin,
    get_type_hints,
)

from ase_roughcontact._util.identity import canonical
from ase_roughcontact._util.registry import Registry, types_of_parameters
from ase_roughcontact._util.summary import Summarized, short_text
from ase_roughcontact._util.units import (
    LENGTHS,
    QUANTITY,
    UNITS,
    quantity,
    units_like,
)
from ase_roughcontact._util.validation import LARGEST, lookup, shown, unknown

AnySection = TypeVar("AnySection", bound="Section")

#: Number that is added to the seeds of a substrate, so that equal seeds of both bodies
#: give independent surfaces.
SUBSTRATE_SEED = 2**32
# Type of a key that has a list of names; other lists are of quantities.
_LIST_OF_NAMES = tuple[str, ...]


@dataclass(frozen=True)
class Section(Summarized):
    """Base class of the sections of a scene file; the fields are its keys.

    Attributes
    ----------
    title : str
        Name of the section in a file.
    units : mapping of str to str
        Units of the keys that may be given as a string with another unit, which is
        converted, and do not depend on the spacing of atoms.
    file_keys : tuple of str
        Keys with names of files as values.
    word_keys : tuple of str
        Keys of numbers or lists that may also be words, which are not converted.
    infinite_keys : tuple of str
        Keys of numbers that may be infinite.
    hints : mapping of str to str
        What to give for names that are not keys, in lower case.
    aliases : mapping of str to str
        Keys by further names that files may have for them.
    changes_results : bool
        Whether a scene with another value has other results.
    """

    title: ClassVar[str]
    units: ClassVar[Mapping[str, str]] = {}
    file_keys: ClassVar[tuple[str, ...]] = ()
    word_keys: ClassVar[tuple[str, ...]] = ()
    infinite_keys: ClassVar[tuple[str, ...]] = ()
    hints: ClassVar[Mapping[str, str]] = {}
    aliases: ClassVar[Mapping[str, str]] = {}
    changes_results: ClassVar[bool] = True

    def __post_init__(self) -> None:
        """Convert quantities with a unit to numbers."""
        problems = Problems()
        for key, unit in self.units.items():
            with problems.of(self.title):
                value = _converted(key, getattr(self, key), units_like(unit), unit)
                object.__setattr__(self, key, value)
        self._check_values(problems)
        problems.check()

    def _check_values(self, problems: Problems) -> None:
        """Collect errors of values that do not depend on other sections; no default."""

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
            If keys are unknown, or values are of the wrong type: with all of them.
        """
        return cls(**cls.checked(entries))

    @classmethod
    def checked(cls, entries: Mapping[str, Any]) -> dict[str, Any]:
        """Return the entries with tuples in place of lists; see `of` for errors."""
        types, problems, entries = cls.types(), Problems(), cls.renamed(entries)
        for name, value in entries.items():
            with problems.of(cls.title):
                if name not in types:
                    raise ValueError(unknown(name, list(types), "key", cls.hints))
                if not any(_is_of_type(value, each) for each in types[name]):
                    accepted = [
                        _NAME_OF_TYPE[each]
                        for each in types[name]
                        if each in _NAME_OF_TYPE
                    ]
                    raise ValueError(
                        f"{name} must be {' or '.join(accepted)}, got {shown(value)}"
                    )
                for each in value if isinstance(value, (list, tuple)) else [value]:
                    cls._check_value(name, each, types[name])
        problems.check()
        return {k: tuple(v) if isinstance(v, list) else v for k, v in entries.items()}

    @classmethod
    def renamed(cls, entries: Mapping[str, Any]) -> dict[str, Any]:
        """Return the entries with keys in place of their aliases.

        Raises
        ------
        ValueError
            If a key is given by two names.
        """
        found, names, problems = dict[str, Any](), dict[str, str](), Problems()
        for name, value in entries.items():
            key = cls.aliases.get(name, name)
            with problems.of(cls.title):
                if key in names:
                    raise ValueError(f"{names[key]} and {name} are one key: give {key}")
            found[key], names[key] = value, name
        problems.check()
        return found

    @classmethod
    def _check_value(cls, name: str, value: Any, types: tuple[Any, ...]) -> None:
        """Raise `ValueError` for a value that no key of these types can have."""
        number = value
        if isinstance(value, str):
            if "\0" in value:
                raise ValueError(f"{name} must be text, got {shown(value)}")
            if not value and getattr(cls, name, None) != "":
                raise ValueError(f"{name} must not be empty: give a value, or omit it")
            found = QUANTITY.fullmatch(value)
            is_quantity = {float, tuple} & set(types) and name not in cls.word_keys
            if is_quantity and not found:
                unit = cls.units.get(name, "nm")
                raise ValueError(
                    f"{name} must be a number, or a string of a number and a unit such "
                    f'as "3 {unit}", got {shown(value)}'
                )
            number = float(found[1]) if is_quantity and found else 0.0
        if isinstance(number, bool) or not isinstance(number, (int, float)):
            return
        if name in cls.infinite_keys and value == math.inf:
            return
        if not (number == 0 or 1.0 / LARGEST <= abs(number) <= LARGEST):
            raise ValueError(
                f"{name} must be a finite number, zero or of a magnitude from "
                f"{1.0 / LARGEST:g} to {LARGEST:g}, got {shown(value)}"
            )

    @classmethod
    def types(cls) -> dict[str, tuple[type, ...]]:
        """Return the types that each key accepts."""
        hints = get_type_hints(cls)
        types = {each.name: members(hints[each.name]) for each in fields(cls)}
        for key in cls.units:
            if tuple not in types[key]:  # a number may be a string with a unit
                types[key] = (*types[key], str)
        return types

    def entries(self) -> dict[str, Any]:
        """Return the values by key, None for keys that are not given."""
        return plain_values(asdict(self))

    def contents(self) -> dict[str, Any]:
        """Return the values by key as `canonical` compares them, files as paths."""
        entries = self.entries()
        for key in self.file_keys:
            if entries[key]:
                entries[key] = Path(entries[key])
        return entries

    def _summary(self) -> dict[str, str]:
        """Return the values that are not the default."""
        entries = self.entries()
        return {key: short_text(entries[key]) for key in self.given}

    @property
    def given(self) -> dict[str, Any]:
        """The `contents` that are not the default, as `canonical` compares them."""
        defaults = canonical(type(self)().contents())
        contents = canonical(self.contents())
        return {k: value for k, value in contents.items() if value != defaults.get(k)}

    def changed(self: AnySection, name: str, value: Any) -> AnySection:
        """Return the section with another value of a key; see `of` for errors."""
        return self.of({**self.entries(), self.aliases.get(name, name): value})

    def plain(
        self,
        keys: Iterable[str],
        units: Mapping[str, float],
        target: str,
        default: str | None = None,
    ) -> Any:
        """Return the section with quantities that are numbers in one unit.

        Parameters
        ----------
        keys : iterable of str
            Keys of the quantities: numbers, strings of a number and a unit, or lists.
        units : mapping
            Values of the units, such as `lengths` or `FORCES`.
        target : str
            Unit of the result.
        default : str, optional
            Unit of numbers; by default the unit of the result.

        Returns
        -------
        Section

        Raises
        ------
        ValueError
            If a string is not a number and a unit, or a unit is unknown.
        """
        section = copy(self)
        for key in keys:
            value = _converted(key, getattr(self, key), units, target, default)
            object.__setattr__(section, key, value)  # a number needs no unit here
        return section

    @property
    def files(self) -> list[str]:
        """Files that the section names."""
        return [file for key in self.file_keys if (file := getattr(self, key))]

    def located(self: AnySection, folder: Path, copied: bool = False) -> AnySection:
        """Return the section with the whole paths of its files.

        Parameters
        ----------
        folder : Path
            Folder of the scene file. A file is sought at its path relative to this
            folder, and then in the folder itself, where a run has copied it.
        copied : bool
            Whether it is sought in the reverse order: the folder has results, and the
            file at the path may have changed since.

        Returns
        -------
        Section
        """
        files = {}
        for key in self.file_keys:
            if name := getattr(self, key):
                places = [folder / name, folder / Path(name).name]
                if copied:
                    places.reverse()
                found = next((place for place in places if place.is_file()), places[0])
                files[key] = str(found.resolve())
        return replace(self, **files)


class LengthSection(Section):
    """Section with lengths that have a unit of their own, or the unit of the section.

    A length that is a number without a unit is an error, as it may be in atomic
    spacings as well as in nm or Å.

    Attributes
    ----------
    length_keys : tuple of str
        Keys of lengths.
    unit : str
        Unit of lengths that are numbers; empty if there is none.
    """

    length_keys: ClassVar[tuple[str, ...]] = ()
    unit: Any = ""

    def _check_values(self, problems: Problems) -> None:
        """Collect unknown units, and lengths without one."""
        with problems.of(self.title):
            if self.unit:
                lookup(self.unit, lengths(1.0), "unit")
        for key, value in self._lengths().items():
            with problems.of(self.title):
                self._check_unit(key, value, lengths(1.0))

    def _lengths(self) -> dict[str, Any]:
        """Return the values of lengths by key."""
        return {key: getattr(self, key) for key in self.length_keys}

    def _check_unit(
        self, key: str, value: Any, units: Mapping[str, float], per: str = ""
    ) -> None:
        """Raise `ValueError` for a quantity without a unit, or with an unknown one.

        `per` is "/" for quantities with units per length.
        """
        if isinstance(value, str) and QUANTITY.fullmatch(value):
            quantity(key, value, units)
        if self.unit or isinstance(value, str) or value is None or value == math.inf:
            return
        choices = f'"{value:g} {per}nm", or "{value:g} {per}a0" in spacings of atoms'
        if "unit" in self.types():
            choices += ", or unit for the section"
        raise ValueError(f"{key} needs a unit: give {choices}")


class KindSection(LengthSection):
    """Section with a key `kind` that names a class with keys of its own.

    A subclass has the fields `kind` and `parameters`.

    Attributes
    ----------
    kinds : Registry
        The classes by their kind.
    kind_hints : mapping of str to str
        What to give for names that are not kinds, in lower case.
    parameters : mapping of str to float or str
        Values of the keys that are not fields.
    """

    kinds: ClassVar[Registry[Any]]
    kind_hints: ClassVar[Mapping[str, str]] = {}
    kind: Any
    parameters: Mapping[str, float | str]

    @classmethod
    def of(cls: type[AnySection], entries: Mapping[str, Any]) -> AnySection:
        """Return the section with the given entries; see `Section.of`."""
        values = cls.checked(entries)
        names = {each.name for each in fields(cls)}
        others = [key for key in values if key not in names]
        values["parameters"] = {key: values.pop(key) for key in others}
        return cls(**values)

    @classmethod
    def types(cls) -> dict[str, tuple[type, ...]]:
        """Return the types that each key accepts, parameters of all kinds included."""
        own = super().types()
        del own["parameters"]
        return types_of_parameters(cls.kinds) | own

    @classmethod
    def checked(cls, entries: Mapping[str, Any]) -> dict[str, Any]:
        """Return the entries; see `Section.checked`, also for an unknown kind."""
        if entries.get("kind", cls.kind):
            kind_of(cls.title, entries, cls.kind, cls.kinds, cls.kind_hints)
        return super().checked(entries)

    def _lengths(self) -> dict[str, Any]:
        """Return the values of lengths by key, of parameters of the kind, too."""
        found = super()._lengths()
        own = self.kinds.get(self.kind)
        for kind in self.kinds.values() if own is None else [own]:
            for key, parameter in kind.parameters.items():
                if parameter.unit == "a0" and key in self.parameters:
                    found[key] = self.parameters[key]
        return found

    def entries(self) -> dict[str, Any]:
        """Return the values by key, of parameters only those that are given."""
        entries = super().entries()
        return entries | entries.pop("parameters")


class Problems:
    """Errors in the sections of a scene, which are raised together.

    Parameters
    ----------
    name : str
        Name of the file.
    """

    def __init__(self, name: str = "") -> None:
        self._name = f"{name}: " if name else ""
        self._found: defaultdict[str, dict[str, None]] = defaultdict(dict)

    @contextmanager
    def of(self, title: str = "") -> Iterator[None]:
        """Keep a `ValueError` in the context as one of a section.

        Without a title the error names the section itself.
        """
        try:
            yield
        except ValueError as error:
            prefix = f"[{title}] "
            self._found[title][str(error).removeprefix(prefix)] = None

    def check(self) -> None:
        """Raise a `ValueError` with all that was found, if there is anything."""
        texts = [
            (f"[{title}] " if title else "") + "; ".join(errors)
            for title, errors in self._found.items()
        ]
        if texts:
            raise ValueError(self._name + "; ".join(texts))


def kind_of(
    title: str,
    entries: Mapping[str, Any],
    default: str,
    kinds: Registry[Any],
    hints: Mapping[str, str] | None = None,
) -> Any:
    """Return the class that the entry ``kind`` of a section names.

    `hints` says what to give for some unknown kinds, in lower case.
    """
    kind = entries.get("kind", default)
    if not isinstance(kind, str):
        raise ValueError(f"[{title}] kind must be a string, got {shown(kind)}")
    if kind not in kinds:
        raise ValueError(
            f"[{title}] {unknown(kind, list(kinds), kinds.what, hints)}. A kind of "
            "your own must be imported before the scene is read, in a Python script"
        )
    return kinds[kind]


def plain_values(values: Any) -> Any:
    """Return values with Python's numbers and lists in place of NumPy's."""
    if isinstance(values, dict):
        return {key: plain_values(value) for key, value in values.items()}
    if isinstance(values, (list, tuple)):
        return type(values)(map(plain_values, values))
    return values.tolist() if hasattr(values, "tolist") else values


def lengths(a0: float) -> dict[str, float]:
    """Return the units of length of scene files, with the spacing a0 (Å)."""
    return {"a0": a0, **LENGTHS}


def inverse_lengths(a0: float) -> dict[str, float]:
    """Return the units of curvatures of scene files, such as "/nm" and "nm^-1"."""
    units = {}
    for name, length in lengths(a0).items():
        units[f"/{name}"] = units[f"{name}^-1"] = 1.0 / length
    return units


def _converted(
    key: str,
    value: Any,
    units: Mapping[str, float],
    target: str,
    default: str | None = None,
) -> Any:
    """Return quantities in a unit; numbers are in the unit `default`.

    Of a range the ends are quantities.
    """
    if isinstance(value, Mapping):
        ends = {name: value[name] for name in ("first", "last") if name in value}
        converted = [
            _converted(key, end, units, target, default) for end in ends.values()
        ]
        return {**value, **dict(zip(ends, converted, strict=True))}
    if isinstance(value, tuple):
        return tuple(_converted(key, each, units, target, default) for each in value)
    if isinstance(value, str):
        example = target if target in UNITS else ""
        return quantity(key, value, units, example) / units[target]
    scale = lookup(default or target, units, "unit") / units[target]
    return value if scale == 1.0 or value is None else value * scale


def members(hint: Any) -> tuple[type, ...]:
    """Return the types of a union; lists of names with their parameters."""
    members = get_args(hint) if get_origin(hint) is UnionType else (hint,)
    return tuple(
        member if member == _LIST_OF_NAMES else get_origin(member) or member
        for member in members
    )


def _is_of_type(value: Any, kind: Any) -> bool:
    if kind == _LIST_OF_NAMES:
        is_list = isinstance(value, (list, tuple))
        return is_list and all(isinstance(each, str) for each in value)
    if kind is tuple:  # a list of quantities
        return isinstance(value, (list, tuple)) and all(
            _is_of_type(each, float)
            or (isinstance(each, str) and QUANTITY.fullmatch(each))
            for each in value
        )
    if kind is int:
        return isinstance(value, int) and not isinstance(value, bool)
    if kind is float:
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    return isinstance(value, kind)


# Descriptions of the types of values.
_NAME_OF_TYPE: dict[Any, str] = {
    _LIST_OF_NAMES: "a list of names",
    tuple: "a list of numbers",
    dict: "a range",
    bool: "true or false",
    float: "a number",
    int: "a whole number",
    str: "a string",
}
