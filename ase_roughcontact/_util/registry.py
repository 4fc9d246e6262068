"""Registries of parts, such as walls and friction laws, by their names.

A user's own part is registered when it is defined or added. Scene files that a Python
script reads can then name it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, TypeVar

from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact._util.validation import lookup

T = TypeVar("T")


class Registry(dict[str, T]):
    """Parts of one sort by their names.

    Parameters
    ----------
    what : str
        Name of the sort in errors, such as "kind of interaction".
    parts : mapping of str to object, optional
        Parts that are registered at the start.
    """

    def __init__(self, what: str, parts: Mapping[str, T] | None = None) -> None:
        super().__init__(parts or {})
        self.what = what

    def find(self, name: Any) -> T:
        """Return the part with a name.

        Raises
        ------
        ValueError
            If there is no such part; the error has the most similar name and all names.
        """
        return lookup(name, self, self.what)

    def add(self, name: str, part: Any) -> None:
        """Register a class; its definition may be repeated, as in a notebook.

        Raises
        ------
        ValueError
            If another class has the name.
        """
        known = self.get(name, part)
        names = [(each.__module__, each.__qualname__) for each in (known, part)]
        if names[0] != names[1]:
            raise ValueError(
                f"{name!r} is the {self.what} of {known.__name__}: choose another name"
            )
        self[name] = part


class Registered:
    """Base class of parts that a scene file can choose by ``kind``.

    The definition of a subclass with a `kind` adds the subclass to its registry.

    Attributes
    ----------
    registry : Registry
        Parts of the same sort by their kind.
    kind : str
        Name in scene files; a class without a kind is not registered.
    parameters : mapping of str to Parameter
        Keys in scene files, with units, defaults and limits; by default none.
    """

    registry: ClassVar[Registry]
    kind: ClassVar[str] = ""
    parameters: ClassVar[Mapping[str, Parameter]] = {}

    def __init_subclass__(cls) -> None:
        """Add a class with a `kind` of its own to the registry."""
        super().__init_subclass__()
        if kind := vars(cls).get("kind"):
            cls.registry.add(kind, cls)

    @classmethod
    def of_parameters(cls, **parameters: Any) -> Any:
        """Make the part from the values of its `parameters` in ASE's units.

        By default the class is called with them.
        """
        return cls(**parameters)

    @classmethod
    def converted_parameters(
        cls, given: Mapping[str, Any], spacing: float
    ) -> dict[str, Any]:
        """Return the values of the parameters in ASE's units.

        Parameters
        ----------
        given : mapping of str to float, str or bool
            Values in the units of a scene file, or with a unit.
        spacing : float
            Spacing of the atoms, the unit a0 (Å).

        Raises
        ------
        ValueError
            If a parameter is unknown, missing or out of range.
        """
        foreign = [
            f"kind = {cls.kind!r} has no {name}, got {value!r}"
            for name, value in given.items()
            if name not in cls.parameters
        ]
        if foreign:
            known = ", ".join(cls.parameters) or "none"
            raise ValueError(f"{'; '.join(foreign)}; its parameters: {known}")
        values = {}
        for name, parameter in cls.parameters.items():
            value = given.get(name, parameter.default)
            if value is not None:
                values[name] = parameter.convert(name, value, spacing)
            elif not parameter.optional:
                unit = f" ({parameter.unit})" if parameter.unit else ""
                raise ValueError(f"kind = {cls.kind!r} needs {name}{unit}")
        return values


def types_of_parameters(
    kinds: Mapping[str, type[Registered]],
) -> dict[str, tuple[type, ...]]:
    """Return the types of the parameters of all kinds, by their names."""
    types = {
        name: parameter.types
        for kind in kinds.values()
        for name, parameter in kind.parameters.items()
    }
    return dict(sorted(types.items()))
