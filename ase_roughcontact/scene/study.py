"""Section [study] of a scene: parameters and their values, seeds, columns to show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np

from ase_roughcontact._util.units import QUANTITY
from ase_roughcontact._util.validation import finite, integer, lookup, positive, shown
from ase_roughcontact.scene.section import Problems, Section

#: Keys of a range of values.
RANGE_KEYS = "first", "last", "steps", "scale"
#: Functions that return evenly spaced values, by the scale.
SCALES = {"linear": np.linspace, "geometric": np.geomspace}
#: What to give for other names of a scale.
SCALE_HINTS = dict.fromkeys(("log", "logarithmic"), '"geometric"')
# Significant digits of the values in a range, so that equal ranges are equal scenes.
_DIGITS = 10


@dataclass(frozen=True)
class StudyConfig(Section):
    """``[study]``: values of keys of other sections, for the command ``ensemble``.

    A key such as ``roughness.rms_height`` has a list of values, or a range: ``{first =
    "0.1 nm", last = "1 nm", steps = 4, scale = "geometric"}``, by default linear.
    `seeds` is the number of realisations of the roughness for each combination, or
    `error` the wanted relative standard error of the means. Keys in `together` vary
    together; of the others there are all combinations. `columns` are averaged, and
    drawn over the parameter `over`, by default the first one with several numbers.
    """

    title = "study"
    changes_results = False

    seeds: int | None = None
    error: float | None = None
    columns: tuple[str, ...] | None = None
    over: str = ""
    together: tuple[str, ...] = ()
    parameters: Mapping[str, tuple] = field(default_factory=dict, hash=False)

    @classmethod
    def of(cls, entries: Mapping[str, Any]) -> Any:
        """Return the section with the given entries; see `Section.of`."""
        own = {each.name for each in fields(cls)} - {"parameters"}
        given = {key: value for key, value in entries.items() if key in own}
        parameters, problems = dict[str, tuple](), Problems()
        for title, value in entries.items():
            if title in own:
                continue
            keys = {title: value}
            if isinstance(value, Mapping) and "." not in title:
                keys = {f"{title}.{name}": each for name, each in value.items()}
            for key, values in keys.items():
                with problems.of(cls.title):
                    parameters[key] = values_of(key, values)
        with problems.of(cls.title):
            _check_numbers(given)
        problems.check()
        return cls(**cls.checked(given), parameters=parameters)

    @classmethod
    def types(cls) -> dict[str, tuple[type, ...]]:
        """Return the types that each key accepts, apart from keys of parameters."""
        types = super().types()
        del types["parameters"]
        return types

    def entries(self) -> dict[str, Any]:
        """Return the values by key, and the values of parameters by their keys."""
        entries = super().entries()
        return entries | entries.pop("parameters")


def _check_numbers(given: Mapping[str, Any]) -> None:
    """Raise `ValueError` for a number of seeds or an error that no study can have."""
    if given.get("seeds") is not None:
        integer("seeds", given["seeds"], 1)
    if given.get("error") is not None:
        positive(error=given["error"])


def values_of(key: str, given: Any) -> tuple[Any, ...]:
    """Return the values that a parameter of a study takes.

    Parameters
    ----------
    key : str
        Section and key, ``"sphere.radius"``.
    given : list or mapping
        List of values, or keys of `range_values`.

    Raises
    ------
    ValueError
        If there is no value, no section is named, or a range is invalid.
    """
    if "." not in key:
        raise ValueError(
            f'{key} must name a section, too, as in sphere.radius = ["10 nm", "30 nm"]'
        )
    if isinstance(given, Mapping):
        for name in given:
            lookup(name, dict.fromkeys(RANGE_KEYS), f"key of the range of {key}")
        missing = [name for name in RANGE_KEYS[:3] if name not in given]
        if missing:
            raise ValueError(f"{key} must have {', '.join(missing)}, too, for a range")
        return range_values(key, **given)
    values = tuple(given) if isinstance(given, (list, tuple)) else (given,)
    if not values:
        raise ValueError(f"{key} must have at least one value, got none")
    return values


def range_values(
    key: str, first: Any, last: Any, steps: int, scale: str = "linear"
) -> tuple[Any, ...]:
    """Return evenly spaced values.

    Parameters
    ----------
    key : str
        Name for errors.
    first, last : float or str
        Ends of the range: numbers, or strings of a number and the same unit.
    steps : int
        Number of values.
    scale : {"linear", "geometric"}
        Whether differences or ratios of neighbours are equal.

    Returns
    -------
    tuple
        Whole numbers if ends and differences are, else numbers or strings with the
        unit.

    Raises
    ------
    ValueError
        If a value is out of range, or the units differ.
    """
    ends = [_number_and_unit(key, each) for each in (first, last)]
    (low, unit), (high, other) = ends
    if unit != other:
        raise ValueError(f"the range of {key} needs one unit, got {first} to {last}")
    integer("steps", steps, 1 if first == last else 2)
    spaced = lookup(str(scale), SCALES, "scale", SCALE_HINTS)
    if scale == "geometric" and not low * high > 0.0:
        raise ValueError(
            f"a geometric range of {key} needs ends of one sign and not zero, got "
            f"{first} and {last}"
        )
    values = [float(f"{each:.{_DIGITS}g}") for each in spaced(low, high, steps)]
    whole = isinstance(first, int) and isinstance(last, int)
    if whole and all(value.is_integer() for value in values):
        return tuple(map(int, values))
    return tuple(f"{value:.{_DIGITS}g} {unit}" if unit else value for value in values)


def _number_and_unit(key: str, given: Any) -> tuple[float, str]:
    """Return the number and the unit of a value, "" without one."""
    found = QUANTITY.fullmatch(given) if isinstance(given, str) else None
    if found:
        return float(found[1]), found[2]
    if isinstance(given, str):
        raise ValueError(
            f"the range of {key} needs numbers, or strings of a number and a unit, got "
            f"{shown(given)}"
        )
    finite(**{key.rpartition(".")[2]: given})
    return float(given), ""
