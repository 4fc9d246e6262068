"""Indenters, solids and walls made from the results of their method `todict`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from ase_roughcontact._util.validation import lookup
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.topography import (
    HeightMap,
    Heterogeneity,
    RoughSphere,
    SelfAffine,
    Surface,
)

# Classes of the parts that a part consists of, by the names of its parameters.
_CLASS_OF_PART: dict[str, Any] = {
    "roughness": Surface,
    "pattern": Surface,
    "solid": ElasticSolid,
    "creep": Creep,
}
#: Classes of parameters of `RoughContact`.
KINDS: dict[str, Any] = {
    "indenter": Surface,
    "solid": ElasticSolid,
    "wall": Interaction,
    "heterogeneity": Heterogeneity,
}


def from_description(name: str, kind: Any, description: Mapping[str, Any]) -> Any:
    """Return the object that a description is of.

    Parameters
    ----------
    name : str
        Name of the parameter, for errors.
    kind : type
        Class from which its class is derived.
    description : mapping
        Result of the object's method `todict`: the ``name`` of the class, or the
        ``kind`` of a wall, and the parameters.

    Returns
    -------
    object

    Raises
    ------
    ValueError
        If the class is unknown, or the description does not have all parameters, as of
        a `HeightMap`, which has a digest in place of the heights.
    """
    parameters = dict(description)
    classes = {_name_of(each): each for each in _subclasses(kind)}
    found = kind
    if "name" in parameters or "kind" in parameters:
        key = parameters.pop("name", None) or parameters.pop("kind")
        found = lookup(key, classes, name)
    for key, value in parameters.items():
        if isinstance(value, Mapping) and key in _CLASS_OF_PART:
            parameters[key] = from_description(key, _CLASS_OF_PART[key], value)
    try:
        return found(**parameters)
    except TypeError as error:
        raise ValueError(
            f"{name} can't be made from its dictionary ({error}): give the "
            f"{found.__name__} itself"
        ) from error


def _name_of(kind: Any) -> str:
    """Return the name of a class in a description: a wall has a kind."""
    if issubclass(kind, Interaction):
        return vars(kind).get("kind", kind.__name__)
    return kind.__name__


def _subclasses(kind: Any) -> Iterator[Any]:
    if kind is Surface:  # a protocol, from which they need not be derived
        yield from (RoughSphere, SelfAffine, HeightMap)
    for each in kind.__subclasses__():
        yield each
        yield from _subclasses(each)
