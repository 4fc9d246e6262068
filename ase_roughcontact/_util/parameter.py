"""Parameters of a part in a scene file: units, defaults and limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ase_roughcontact._util.units import LENGTHS, UNITS, quantity, units_like
from ase_roughcontact._util.validation import boolean, finite


@dataclass(frozen=True)
class Parameter:
    """Parameter with which a scene file specifies a wall, a solid or a friction law.

    Parameters
    ----------
    unit : {"", "a0", "Å", "GPa", "J/m^2", ...}
        Unit of a number in the file: none, or one of `UNITS`. With "a0" it is a length
        that a file gives with a unit, and the default is in atomic spacings.
    default : float or bool, optional
        Value if the file does not give the parameter, in the unit of the file. Without
        a default the file must give the parameter. A parameter with a bool as default
        is true or false.
    above, below : float
        Limits between which the value must lie, in the unit of the file.
    optional : bool
        Whether the file may leave out the parameter although there is no default.

    Raises
    ------
    ValueError
        If the unit is not known.
    """

    unit: str = ""
    default: float | None = None
    above: float = 0.0
    below: float = math.inf
    optional: bool = False

    def __post_init__(self) -> None:
        """Check the unit."""
        if self.unit not in (*UNITS, "a0"):
            raise ValueError(f"unit must be one of {[*UNITS, 'a0']}, got {self.unit!r}")

    @property
    def required(self) -> bool:
        """Whether a file must give the parameter."""
        return self.default is None and not self.optional

    @property
    def types(self) -> tuple[type, ...]:
        """Types of the value in a file."""
        if isinstance(self.default, bool):
            return (bool,)
        return (float, str) if self.unit else (float,)

    def words(self, name: str, value: float | str) -> str:
        """Return name and value as they are printed: "shear strength 0.5 GPa"."""
        if isinstance(value, bool):
            return name.replace("_", " ") if value else f"not {name.replace('_', ' ')}"
        text = value if isinstance(value, str) else f"{value:g} {self.unit}".rstrip()
        return f"{name.replace('_', ' ')} {text}"

    def convert(self, name: str, value: float | str, spacing: float) -> float:
        """Return a value of a scene file in ASE's units.

        Parameters
        ----------
        name : str
            Name of the parameter, for errors.
        value : float, str or bool
            Value in the unit of the file, or with a unit: ``"50 mJ/m^2"``.
        spacing : float
            Atomic spacing a0 (Å).

        Raises
        ------
        ValueError
            If the value is not a finite number within the limits, or true or false.
        """
        if self.types == (bool,):
            boolean(**{name: value})
            return value  # type: ignore[return-value]
        scale = spacing if self.unit == "a0" else UNITS[self.unit]
        given = value
        if isinstance(value, str):
            lengths = {"a0": spacing, **LENGTHS}
            units = lengths if self.unit in lengths else units_like(self.unit)
            value = quantity(name, value, units) / scale
        finite(**{name: value})
        if not self.above < value < self.below:
            limits = f"> {self.above:g}"
            if self.below < math.inf:
                limits += f" and < {self.below:g}"
            unit = f" {self.unit}" if self.unit else ""
            raise ValueError(f"{name} must be {limits}{unit}, got {given!r}")
        return value * scale
