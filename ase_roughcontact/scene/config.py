"""Sections of a scene file: keys and defaults."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from ase.optimize import FIRE, FIRE2, LBFGS, BFGSLineSearch

from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact._util.registry import Registry
from ase_roughcontact._util.validation import grid_shape, lookup, one_of
from ase_roughcontact.elasticity import SOLIDS
from ase_roughcontact.elasticity.named_materials import Material, find_material
from ase_roughcontact.interactions import WALLS
from ase_roughcontact.interactions.friction import (
    COUPLINGS,
    LAWS,
    FrictionLaw,
    law_of,
    make_law,
)
from ase_roughcontact.optimize import ActiveSet, NewtonKrylov
from ase_roughcontact.optimize.settings import on_modes
from ase_roughcontact.scene.section import KindSection, LengthSection, Problems, Section
from ase_roughcontact.theory.indenters import INDENTERS, Indenter
from ase_roughcontact.windows.regrid import GridChange

# Advice on other names of moduli, in lower case.
_MODULUS = "youngs_modulus and poisson, or contact_modulus, E/(1 - nu^2)"
_MODULI = dict.fromkeys(("e", "modulus", "young", "youngs_modulus"), _MODULUS)
_MODULI |= {
    "e*": "contact_modulus",
    **dict.fromkeys(("nu", "poisson_ratio"), "poisson"),
}
# Advice on other names of a material, in lower case.
_MATERIALS = dict.fromkeys(("element", "metal", "crystal_name", "name"), "material")
# Advice on keys of a sphere or of another shape in [tip], in lower case.
_SHAPES = {
    **dict.fromkeys(("radius", "profile", "unit"), "it in [sphere]"),
    **dict.fromkeys(("kind", "shape", "half_angle"), "it in [indenter]"),
    **dict.fromkeys(("tip_radius", "end_radius", "punch_radius"), "it in [indenter]"),
}
# Advice on names of dimensions, in lower case.
_DIMENSIONS = {
    "radius": "tip_radius, end_radius or punch_radius of the kind; a sphere is the "
    "section [sphere]",
    **dict.fromkeys(("angle", "semi_angle", "opening_angle"), "half_angle (degrees)"),
}
_SHAPE_NAMES = {
    **dict.fromkeys(("berkovich", "vickers"), '"pyramid"'),
    **dict.fromkeys(("flat", "flat punch", "cylinder"), '"punch"'),
}
# Advice on names of theories and potentials, in lower case.
_LIMIT = (
    '"adhesive" with work_of_adhesion; JKR and DMT are its limits for a short and a '
    "long range"
)
_WALL_NAMES = {
    **dict.fromkeys(("jkr", "dmt", "johnson-kendall-roberts"), _LIMIT),
    **dict.fromkeys(("hertz", "rigid", "non-adhesive"), '"hard"'),
    **dict.fromkeys(("maugis", "maugis-dugdale"), '"dugdale"'),
    **dict.fromkeys(("lennard-jones", "lj", "vdw", "van der waals"), '"full"'),
}
# Kinds of indenters that have a section of their own.
_SPHERES = "sphere", "paraboloid"
# Default radius of the sphere, in units of the spacing.
DEFAULT_RADIUS = 1000.0


@dataclass(frozen=True)
class SubstrateConfig(KindSection):
    """``[substrate]``: moduli and hardness in GPa, lengths in Å, times in s.

    Without a kind the solid is one of the package, selected by the keys. A user-defined
    solid has a kind, and may have further keys, see `ElasticSolid`.
    """

    title = "substrate"
    kinds = SOLIDS
    units = {
        "relaxation_times": "s",
        "contact_modulus": "GPa",
        "youngs_modulus": "GPa",
        "elastic_constants": "GPa",
        "hardness": "GPa",
        "yield_strength": "GPa",
        "layer_contact_modulus": "GPa",
    }
    file_keys = ("potential", "crystal")
    word_keys = ("shape", "spacing", "grid")
    infinite_keys = ("hardness",)
    hints = {**_MODULI, **_MATERIALS}
    aliases = {
        "symbol": "material",
        "layer_modulus": "layer_contact_modulus",
        "sliding": "frictionless_interface",
    }

    material: str = ""
    spacing: float | str | None = None
    contact_modulus: float | None = None
    youngs_modulus: float | None = None
    elastic_constants: tuple | None = None
    hardness: float | None = None
    yield_strength: float | None = None
    anisotropic: bool = False
    calculator: str = ""
    potential: str = ""
    crystal: str = ""
    surface: str = ""
    layer_thickness: float | str | None = None
    layer_contact_modulus: float | None = None
    layer_poisson: float | None = None
    poisson: float | None = None
    rigid_base: bool = False
    frictionless_interface: bool = False
    relaxation_moduli: tuple | None = None
    relaxation_times: tuple | None = None
    model: str = ""
    grid: str = ""
    refine: int | None = None
    coarsen: int | None = None
    shape: tuple[int, int] | str = "auto"
    periodic: bool = False
    kind: str | None = None
    parameters: Mapping[str, float | str] = field(default_factory=dict, hash=False)

    @property
    def gives_moduli(self) -> bool:
        """Whether the moduli are given, and do not follow from a material."""
        moduli = self.contact_modulus, self.youngs_modulus, self.elastic_constants
        return any(each is not None for each in (*moduli, self.kind))

    @classmethod
    def renamed(cls, entries: Mapping[str, Any]) -> dict[str, Any]:
        """Return the entries; a spacing relative to the atoms is a grid."""
        found = super().renamed(entries)
        if GridChange.of(text=found.get("spacing")) is not None:
            found["grid"] = found.pop("spacing")
        return found

    @property
    def known_material(self) -> Material | None:
        """Properties of the material; None for moduli alone and for other elements."""
        return find_material(self.material) if self.material else None

    def _check_values(self, problems: Problems) -> None:
        """Collect an unknown material; see `Section._check_values`."""
        with problems.of(self.title):
            _ = self.known_material

    @property
    def of_atoms(self) -> bool:
        """Whether the solid follows from the forces between atoms."""
        return bool(self.calculator or self.files)

    @property
    def grid_change(self) -> GridChange | None:
        """The given grid relative to the grid of the atoms; None if not given."""
        change = GridChange.of(self.refine, self.coarsen, self.grid)
        if change is None and self.grid:
            raise ValueError(
                'grid must be relative to the spacing of the atoms, such as "a0/2" or '
                f'"2 a0", got {self.grid!r}; spacing is the distance of the atoms'
            )
        return change

    @property
    def window_shape(self) -> tuple[int, int] | None:
        """Shape of the window of atoms; None if it is chosen for each step."""
        if not isinstance(self.shape, str):
            return grid_shape(self.shape)
        if self.periodic:
            raise ValueError(
                'shape = "auto" needs a free half space: give the shape of the cell, '
                "[n, m]"
            )
        return lookup(self.shape, {"auto": None}, "shape")


@dataclass(frozen=True)
class SphereConfig(LengthSection):
    """``[sphere]``: radius with a unit, by default 1000 spacings of the atoms.

    The radius infinity means that a scan is the whole indenter.
    """

    title = "sphere"
    infinite_keys = ("radius",)
    length_keys = ("radius",)

    radius: float | str | None = None
    unit: str = ""
    material: str = ""
    profile: str = "paraboloid"

    def contents(self) -> dict[str, Any]:
        """Return the values by key for comparison; see `Section.contents`."""
        usual = {"radius": f"{DEFAULT_RADIUS:g} a0"} if self.radius is None else {}
        return super().contents() | usual


@dataclass(frozen=True)
class TipConfig(Section):
    """``[tip]``: the elastic solid of the indenter; moduli and hardness in GPa."""

    title = "tip"
    units = {"contact_modulus": "GPa", "youngs_modulus": "GPa", "hardness": "GPa"}
    infinite_keys = ("hardness",)
    hints = {**_MODULI, **_MATERIALS, **_SHAPES}
    aliases = {"symbol": "material"}

    material: str = ""
    contact_modulus: float | None = None
    youngs_modulus: float | None = None
    poisson: float | None = None
    hardness: float | None = None


@dataclass(frozen=True)
class IndenterConfig(KindSection):
    """``[indenter]``: an indenter of another shape, in place of ``[sphere]``.

    In a file its dimensions are further keys of the section: lengths in units of the
    spacing, angles in degrees if no unit is given. A shape of one's own has a kind, see
    `Indenter`.
    """

    title = "indenter"
    kinds = INDENTERS
    kind_hints = _SHAPE_NAMES
    hints = _DIMENSIONS

    kind: str | None = None
    material: str = ""
    parameters: Mapping[str, float | str] = field(default_factory=dict, hash=False)

    @property
    def kind_parameters(self) -> Mapping[str, Parameter]:
        """Dimensions of the kind; none without a kind."""
        return INDENTERS.find(self.kind).parameters if self.kind else {}

    def shape(self, spacing: float) -> Indenter:
        """Return the shape with lengths in Å.

        Parameters
        ----------
        spacing : float
            Atomic spacing a0 (Å).

        Raises
        ------
        ValueError
            If the kind, or one of its dimensions, is missing or out of range.
        """
        if self.kind is None:
            others = (name for name in INDENTERS if name not in _SPHERES)
            raise ValueError(f"give kind, one of {', '.join(others)}")
        kind = INDENTERS.find(self.kind)
        if self.kind in _SPHERES:
            raise ValueError(
                f"a {self.kind} is the section [sphere], with radius and profile"
            )
        values = kind.converted_parameters(self.parameters, spacing)
        shape: Indenter = kind.of_parameters(**values)
        return shape


@dataclass(frozen=True)
class InteractionConfig(KindSection):
    """``[interaction]``: kind of wall, and its parameters.

    In a file the parameters are further keys of the section; the class of the wall
    defines their names and units, see `Interaction`.
    """

    title = "interaction"

    kinds = WALLS
    kind_hints = _WALL_NAMES

    kind: str = "repulsive"
    parameters: Mapping[str, float | str] = field(default_factory=dict, hash=False)


@dataclass(frozen=True)
class FrictionConfig(KindSection):
    """``[friction]``: friction law, and its parameters.

    Without a kind the law is the first one with the given keys: Coulomb's with a
    friction coefficient, limited by a shear strength if both are given, else Tresca's
    with a shear strength (GPa). Other laws have further keys, see `FrictionLaw`.
    `coupling` says how normal and lateral motion are coupled, see `SlidingSteps`.
    """

    title = "friction"
    units = {"shear_strength": "GPa"}
    kinds = LAWS

    coefficient: float | None = None
    shear_strength: float | None = None
    coupling: str = COUPLINGS[0]
    kind: str | None = None
    parameters: Mapping[str, float | str] = field(default_factory=dict, hash=False)

    @property
    def coupled(self) -> bool:
        """Whether the coupling of normal and lateral motion is solved for."""
        return self.coupling != COUPLINGS[0]

    @property
    def given_to_law(self) -> dict[str, float | str]:
        """Parameters of the law that are given, in the units of the file."""
        own = {"coefficient": self.coefficient, "shear_strength": self.shear_strength}
        values = {key: value for key, value in own.items() if value is not None}
        return values | dict(self.parameters)

    def law_on(self, spacing: float) -> FrictionLaw:
        """Return the law.

        Parameters
        ----------
        spacing : float
            Atomic spacing a0 (Å).

        Raises
        ------
        ValueError
            If the law can't be made from the keys; see `make_law`.
        """
        one_of(COUPLINGS, coupling=self.coupling)
        return make_law(self.kind, self.given_to_law, spacing)

    @property
    def label(self) -> str:
        """The law in words."""
        given = self.given_to_law
        parameters = law_of(self.kind, given).parameters
        words = [parameters[key].words(key, value) for key, value in given.items()]
        kind = [self.kind] if self.kind else []
        coupled = "; coupled to the pressure" if self.coupled else ""
        return ", ".join(kind + words) + coupled


#: Optimizers by the names used in scene files. One more is an entry:
#: ``OPTIMIZERS["BFGS"] = on_modes(BFGS)``.
OPTIMIZERS: Registry[Callable[..., Any]] = Registry(
    "optimizer",
    {
        "NewtonKrylov": NewtonKrylov,
        "ActiveSet": ActiveSet,
        "LBFGS": on_modes(LBFGS),
        "FIRE": on_modes(FIRE),
        "FIRE2": on_modes(FIRE2),
        "BFGSLineSearch": on_modes(BFGSLineSearch),
    },
)


@dataclass(frozen=True)
class SolverConfig(Section):
    """``[solver]``: the tolerance fmax of the forces is in eV/Å, as in ASE."""

    title = "solver"
    units = {"fmax": "eV/Å"}

    optimizer: str | None = None
    accuracy: str = "normal"
    relative_error: float | None = None
    fmax: float | None = None
    max_steps: int = 10_000
    engine: str | None = None

    @property
    def asked_accuracy(self) -> float | str:
        """Relative error that is given, or the name of an accuracy."""
        return self.accuracy if self.relative_error is None else self.relative_error

    @classmethod
    def renamed(cls, entries: Mapping[str, Any]) -> dict[str, Any]:
        """Return the entries; an accuracy that is a number is a relative error."""
        found = super().renamed(entries)
        if isinstance(found.get("accuracy"), float):
            found["relative_error"] = found.pop("accuracy")
        return found

    def changed(self, name: str, value: Any) -> SolverConfig:
        """Return the section with another value; an accuracy replaces an error."""
        section = self
        if name == "accuracy":
            section = replace(self, relative_error=None)
        return super(SolverConfig, section).changed(name, value)


@dataclass(frozen=True)
class OutputConfig(Section):
    """``[output]``: further columns of the results, and the stored frames.

    By default a rough flat has the column of the conductance, and other scenes have no
    further column. `keep` selects the frames of ``sweep.traj``, see `Output`.
    """

    title = "output"
    changes_results = False

    columns: tuple[str, ...] | None = None
    keep: str = "thinned"
