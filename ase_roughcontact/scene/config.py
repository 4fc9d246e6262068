"""Sections of a scene file: keys and defaults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ase_roughcontact._util.validation import (
    FloatArray,
    finite,
    finite_array,
    integer,
    lookup,
    unknown,
)
from ase_roughcontact.interactions import WALLS, wall_parameters
from ase_roughcontact.scene.fields import HeterogeneityConfig, RoughnessConfig
from ase_roughcontact.scene.scan import TopographyConfig
from ase_roughcontact.scene.section import Quantities, Section, plain_values

# Element of the atoms if none is named.
SYMBOL = "Cu"
# Radius of the sphere if none is given, in units of the spacing.
DEFAULT_RADIUS = 1000.0
# Largest number of steps of a path, all of which are kept in memory.
_MOST_STEPS = 1_000_000
# Keys of [path] that a loop does not use.
_OF_STEPS = "control", "first", "last", "steps", "scale", "values"
# Keys of [path] that only a loop uses.
_OF_LOOPS = "deepest", "step", "tolerance", "cantilever"
# Keys of [substrate] of solids whose moduli are not that of a material.
_WITHOUT_MODULUS = "anisotropic", "rigid_base", "calculator", "potential", "crystal"


@dataclass(frozen=True)
class SubstrateConfig(Section):
    """``[substrate]``: moduli and hardness in GPa, lengths in Å without a unit."""

    title = "substrate"
    units = dict.fromkeys(
        ("contact_modulus", "elastic_constants", "hardness", "layer_modulus"), "GPa"
    )
    file_keys = ("potential", "crystal")

    symbol: str = ""
    material: str = ""
    spacing: float | str | None = None
    contact_modulus: float | None = None
    elastic_constants: tuple | None = None
    hardness: float | None = None
    anisotropic: bool = False
    calculator: str = ""
    potential: str = ""
    crystal: str = ""
    surface: str = ""
    layer_thickness: float | str | None = None
    layer_modulus: float | None = None
    layer_poisson: float | None = None
    poisson: float | None = None
    rigid_base: bool = False
    sliding: bool = False
    model: str = "atoms"
    refine: int | None = None
    coarsen: int | None = None
    shape: tuple[int, int] | str = "auto"
    periodic: bool = False

    @property
    def name(self) -> str:
        """Name of the material or element; empty if only moduli are given."""
        moduli = self.contact_modulus, self.elastic_constants
        default = SYMBOL if moduli == (None, None) else ""
        return self.material or self.symbol or default

    @property
    def other_solid(self) -> str:
        """Key of a solid without a modulus of its own; empty if none is given."""
        return next((key for key in _WITHOUT_MODULUS if getattr(self, key)), "")

    @property
    def of_atoms(self) -> bool:
        """Whether the solid follows from the forces between atoms."""
        return bool(self.calculator or self.files)


@dataclass(frozen=True)
class SphereConfig(Section):
    """``[sphere]``: radius in units of the spacing if no unit is given.

    The radius infinity means that a scan is the whole indenter.
    """

    title = "sphere"

    radius: float | str | None = None
    unit: str = "a0"
    material: str = ""
    profile: str = "paraboloid"

    def contents(self) -> dict[str, Any]:
        """Return the values by key for comparison; see `Section.contents`."""
        values = super().contents()
        if self.radius is None:
            values |= {"radius": DEFAULT_RADIUS, "unit": "a0"}
        return values


@dataclass(frozen=True)
class InteractionConfig(Section):
    """``[interaction]``: kind of wall, and its parameters.

    In a file the parameters are further keys of the section; the class of the wall
    defines their names and units, see `Interaction`.
    """

    title = "interaction"

    kind: str = "repulsive"
    parameters: Mapping[str, float | str] = field(default_factory=dict, hash=False)

    @classmethod
    def of(cls, entries: Mapping[str, Any]) -> InteractionConfig:
        """Return the section with the given entries; see `Section.of`."""
        kind = entries.get("kind", cls.kind)
        if isinstance(kind, str) and kind not in WALLS:
            problem = unknown(kind, list(WALLS), "kind of interaction")
            raise ValueError(
                f"[{cls.title}] {problem}. A wall of your own must be imported before "
                "the scene is read, in a Python script"
            )
        return super().of(entries)

    @classmethod
    def types(cls) -> dict[str, tuple[type, ...]]:
        """Return the types that each key accepts, parameters of all walls included."""
        return {"kind": (str,), **wall_parameters()}

    def entries(self) -> dict[str, Any]:
        """Return the values by key, of parameters only those that are given."""
        return {"kind": self.kind, **plain_values(dict(self.parameters))}

    @classmethod
    def _of(cls, entries: Mapping[str, Any]) -> InteractionConfig:
        parameters = dict(entries)
        return cls(parameters.pop("kind", cls.kind), parameters)


@dataclass(frozen=True)
class PathConfig(Section):
    """``[path]``: loads in nN, penetrations and heights in Å, or with a unit."""

    title = "path"
    units = {"cantilever": "N/m"}

    control: str = "load"
    first: float | str | None = None
    last: float | str | None = None
    steps: int | None = None
    scale: str = "geometric"
    values: Quantities | None = None
    kind: str = "steps"
    deepest: float | str | None = None
    step: float | str | None = None
    tolerance: float = 1e-3
    cantilever: float | None = None

    @property
    def is_loop(self) -> bool:
        """Whether the path is an approach and a retraction, with steps of its own."""
        return lookup(self.kind, {"steps": False, "loop": True}, "kind of path")

    @property
    def unit(self) -> str:
        """Unit of the targets, one of `UNITS`."""
        units = {"load": "nN", "penetration": "Å", "height": "Å"}
        return lookup(self.control, units, "control")

    @property
    def targets(self) -> FloatArray:
        """Loads, penetrations or heights, in the units of the file."""
        keys = "values", "first", "last", "steps"
        given = [key for key in keys if getattr(self, key) is not None]
        if given == ["first", "last", "steps"]:
            return self._interval()
        if given != ["values"]:
            raise ValueError(
                "give either values, or first, last and steps, got "
                f"{', '.join(given) or 'none of them'}"
            )
        targets = finite_array("values", self.values)
        if targets.ndim != 1 or not targets.size:
            raise ValueError(f"values must have at least one step, got {self.values}")
        return targets

    def check_loop(self) -> None:
        """Raise an error if a key is given that a loop does not use."""
        given = self._given(_OF_STEPS)
        if given:
            raise ValueError(
                f'kind = "loop" chooses its own steps: omit {given}, or give kind = '
                '"steps"'
            )

    def check_steps(self) -> None:
        """Raise an error if a key is given that only a loop uses."""
        given = self._given(_OF_LOOPS)
        if given:
            raise ValueError(f'{given} need kind = "loop": give it, or omit them')

    def _given(self, keys: tuple[str, ...]) -> str:
        """Return the names of the keys whose values are not the default."""
        usual = type(self)
        return ", ".join(k for k in keys if getattr(self, k) != getattr(usual, k))

    def _interval(self) -> FloatArray:
        """Return the targets from the first to the last one."""
        ends: Any = self.first, self.last
        first, last = ends
        steps = integer("steps", self.steps, 1)
        if steps > _MOST_STEPS:
            raise ValueError(f"steps must be at most {_MOST_STEPS}, got {steps}")
        finite(first=first, last=last)
        scales = {"geometric": np.geomspace, "linear": np.linspace}
        scale = lookup(self.scale, scales, "scale")
        if self.scale == "geometric" and not (first and last and first * last > 0):
            raise ValueError(
                "a geometric path needs first and last of one sign and not zero, got "
                f"{first} and {last}"
            )
        return scale(*np.array(ends, dtype=float), steps)


@dataclass(frozen=True)
class SolverConfig(Section):
    """``[solver]``: fmax in units of E* a0^2."""

    title = "solver"

    optimizer: str | None = None
    accuracy: float | str = "normal"
    fmax: float | None = None
    max_steps: int = 10_000


SECTIONS: dict[str, type[Section]] = {
    section.title: section
    for section in (
        SubstrateConfig,
        SphereConfig,
        RoughnessConfig,
        TopographyConfig,
        HeterogeneityConfig,
        InteractionConfig,
        PathConfig,
        SolverConfig,
    )
}
