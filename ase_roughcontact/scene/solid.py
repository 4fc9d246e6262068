"""The elastic solid of a scene, from the keys of its section ``[substrate]``."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Any

from ase.calculators.emt import EMT

from ase_roughcontact._util.identity import digest_of_file
from ase_roughcontact._util.units import LENGTHS, UNITS
from ase_roughcontact._util.validation import lookup, positive, shown
from ase_roughcontact.elasticity import (
    SOLIDS,
    Creep,
    Crystal,
    Cubic,
    ElasticSolid,
    Isotropic,
    Layer,
)
from ase_roughcontact.elasticity.material import (
    contact_modulus,
    crystal_constants,
    fcc_spacing,
    plane_strain_modulus,
    poisson_ratio,
    surface_spacing,
)
from ase_roughcontact.scene.config import SubstrateConfig

# Relative difference within which a spacing equals the spacing of a crystal.
_SPACING_TOLERANCE = 0.02
#: Hardness (GPa) that no solid exceeds: a larger value is in another unit.
MAX_HARDNESS = 1e3
# Modulus (GPa) that no solid exceeds: a larger value is in another unit.
_MAX_MODULUS = 1e4
# Slabs for potentials of embedded atoms, which reach far and have a Hessian.
_EAM_SLAB_OPTIONS: dict[str, Any] = {"layers": 19, "size": 11, "displacement": 0.0}
# Metals with parameters, by the name of the calculator.
_METALS_OF_CALCULATOR = {"emt": ("Al", "Cu", "Ag", "Au", "Ni", "Pd", "Pt")}
# Surface of a crystal if no surface is named.
_DEFAULT_SURFACE = "fcc100"
# Crystal direction of the rows of atoms along x, by the surface.
_DIRECTION_OF_X = {"fcc100": "110", "bcc100": "100", "diamond100": "110"}
# Formats of potentials by the ends of the names of their files.
_POTENTIAL_FORMATS = {".alloy": "eam/alloy", ".fs": "eam/fs", ".eam": "eam"}
# Element of the atoms of a solid without a material.
_DEFAULT_SYMBOL = "Cu"
# Keys of crystals of atoms.
_CRYSTAL_KEYS = "calculator", "potential", "crystal"
# Keys of solids without the modulus of a material.
_KEYS_WITHOUT_MODULUS = "anisotropic", "rigid_base", *_CRYSTAL_KEYS
# Keys that give the moduli of a solid.
_MODULUS_KEYS = "contact_modulus", "youngs_modulus", "elastic_constants", "poisson"
# Keys that contradict each other: one of the first, one of the second, and why.
_CONTRADICTIONS: list[tuple[tuple[str, ...], tuple[str, ...], str]] = [
    (
        _CRYSTAL_KEYS,
        _MODULUS_KEYS,
        "{other} follows from the forces between the atoms: omit it",
    ),
    (
        ("anisotropic",),
        ("contact_modulus", "youngs_modulus", "poisson"),
        "an anisotropic solid has elastic_constants instead of {other}: omit it",
    ),
    (
        ("rigid_base",),
        _MODULUS_KEYS,
        "a rigid base has no {other}: omit it or rigid_base",
    ),
    (
        ("contact_modulus", "youngs_modulus"),
        ("elastic_constants",),
        "give {key} or {other}, not both",
    ),
    (("contact_modulus",), ("youngs_modulus",), "give {key} or {other}, not both"),
    (
        ("kind",),
        (*_MODULUS_KEYS, *_CRYSTAL_KEYS, "anisotropic", "layer_thickness"),
        "{other} is of another solid: omit it or kind",
    ),
]


def solid_of(substrate: SubstrateConfig, spacing: float | None) -> ElasticSolid:
    """Return the elastic solid that a section describes.

    Parameters
    ----------
    substrate : SubstrateConfig
    spacing : float or None
        Atomic spacing a0 (Å), the unit of some keys of a user-defined solid.

    Returns
    -------
    ElasticSolid
        Solid with moduli in eV/Å^3.

    Raises
    ------
    ValueError
        If a value is out of range, keys of several solids are given, or a calculator
        is not suitable.
    """
    defaults = SubstrateConfig()
    given = {k for k, v in vars(substrate).items() if v != getattr(defaults, k)}
    solids = [key for key in _SOLID_OF_KEY if key in given]
    if len(solids) > 1:
        raise ValueError(f"give one of {' and '.join(solids)}: each is another solid")
    contradictions = _contradictions(given)
    if contradictions:
        raise ValueError("; ".join(contradictions))
    if substrate.kind is not None or substrate.parameters:
        return _solid_of_kind(substrate, spacing)
    if solids:
        return _SOLID_OF_KEY[solids[0]](substrate)
    return Isotropic(UNITS["GPa"] * _modulus(substrate), substrate.poisson)


def _contradictions(given: set[str]) -> list[str]:
    """Return errors of keys without a key that they need, or beside another one.

    Parameters
    ----------
    given : set of str
        Keys with another value than their default.
    """
    found = []
    for key, needed in _NEEDED_KEYS.items():
        if key in given and given.isdisjoint(needed):
            choice = "one of " if len(needed) > 1 else ""
            found.append(f"{key} needs {choice}{', '.join(needed)}")
    for keys, others, reason in _CONTRADICTIONS:
        for key, other in product(keys, others):
            if {key, other} <= given:
                found.append(reason.format(key=key, other=other))
    return found


def named(substrate: SubstrateConfig) -> SubstrateConfig:
    """Return the section with the values of its material that are not given.

    Parameters
    ----------
    substrate : SubstrateConfig

    Returns
    -------
    SubstrateConfig

    Raises
    ------
    ValueError
        If the solid can't be of this material.
    """
    given, entry = substrate, substrate.known_material
    if entry is None:
        return given
    if given.spacing is None:
        given = replace(given, spacing=entry.spacing)
    if given.gives_moduli:
        return given
    other = next((key for key in _KEYS_WITHOUT_MODULUS if getattr(given, key)), "")
    if other and not entry.crystalline:
        raise ValueError(
            f"material = {given.material!r} gives the modulus of an isotropic half "
            f'space, which {other} does not have: give a crystal, such as "Si"'
        )
    if other:
        return given
    return replace(given, contact_modulus=entry.contact_modulus)


def is_crystal(substrate: SubstrateConfig) -> bool:
    """Return whether the points of a grid are the atoms of a crystal's surface.

    They are if the crystal is named, the spacing is its own, and neither a layer nor a
    relaxation in time is given.
    """
    if substrate.layer_thickness is not None or substrate.relaxation_times is not None:
        return False
    try:
        own, change = _own_spacing(substrate), substrate.grid_change
        if own is None or change is not None:
            return own is not None and not change
        spacing = substrate.plain(["spacing"], LENGTHS, "Å").spacing
    except ValueError:  # an unknown name or unit, which `build` reports
        return False
    return spacing is None or math.isclose(spacing, own, rel_tol=_SPACING_TOLERANCE)


def has_own_spacing(substrate: SubstrateConfig) -> bool:
    """Return whether a spacing or a grid is given, or the spacing is of a crystal."""
    ratios = substrate.grid or None, substrate.refine, substrate.coarsen
    given = substrate.spacing, *ratios
    if substrate.of_atoms or any(each is not None for each in given):
        return True
    return _own_spacing(substrate) is not None


def _own_spacing(substrate: SubstrateConfig) -> float | None:
    """Return the spacing of the atoms of a named crystal (Å); None for other solids."""
    entry = substrate.known_material
    if not substrate.material or (entry is not None and not entry.crystalline):
        return None
    return surface_spacing(symbol_of(substrate))


def symbol_of(substrate: SubstrateConfig) -> str:
    """Return the chemical symbol of the atoms of a solid."""
    if not substrate.material:
        return _DEFAULT_SYMBOL
    entry = substrate.known_material
    return substrate.material if entry is None else entry.symbol


def spacing_of(substrate: SubstrateConfig) -> float | None:
    """Return the atomic spacing a0 (Å); None for a crystal, which has its own.

    Parameters
    ----------
    substrate : SubstrateConfig
        See `named`.

    Returns
    -------
    float or None

    Raises
    ------
    ValueError
        If the spacing is not positive, or neither given nor known.
    """
    spacing = substrate.plain(["spacing"], LENGTHS, "Å").spacing
    if spacing is not None:
        positive(spacing=spacing)
        return spacing
    return None if substrate.of_atoms else fcc_spacing(symbol_of(substrate))


def poisson_of(substrate: SubstrateConfig) -> float | None:
    """Return Poisson's ratio of an isotropic solid; None if it is not known.

    Parameters
    ----------
    substrate : SubstrateConfig
        See `named`, with the material as given.
    """
    if substrate.poisson is not None:
        return substrate.poisson
    if substrate.elastic_constants is not None:
        return poisson_ratio(substrate.elastic_constants)
    entry = substrate.known_material
    return None if entry is None else entry.poisson


def creep_of(substrate: SubstrateConfig) -> Creep | None:
    """Return the creep of a viscoelastic solid; None for an elastic one.

    Raises
    ------
    ValueError
        If one of ``relaxation_moduli`` (relative to the instantaneous modulus) and
        ``relaxation_times`` (s) is missing, or they are no valid series.
    """
    moduli, times = substrate.relaxation_moduli, substrate.relaxation_times
    if moduli is None and times is None:
        return None
    if moduli is None or times is None:
        raise ValueError("give both relaxation_moduli and relaxation_times")
    if any(isinstance(each, str) for each in moduli):
        raise ValueError(
            "relaxation_moduli are relative to the instantaneous modulus: give numbers "
            f"without a unit, such as [0.5, 0.3], got {shown(list(moduli))}"
        )
    given = substrate.gives_moduli or substrate.layer_contact_modulus is not None
    entry = substrate.known_material
    if entry is not None and not (entry.crystalline or given):
        raise ValueError(
            f"the modulus of material = {substrate.material!r} is not instantaneous: "
            "give contact_modulus, from which relaxation_moduli relax"
        )
    return Creep.of_relaxation(moduli, times)


def label_of(substrate: SubstrateConfig, solid: ElasticSolid) -> str:
    """Return the name and the contact modulus of a solid.

    Parameters
    ----------
    substrate : SubstrateConfig
        Section that describes the solid, as given.
    solid : ElasticSolid
        Solid with moduli in eV/Å^3.

    Returns
    -------
    str
    """
    name = substrate.kind or substrate.material or "half space of given moduli"
    if substrate.anisotropic:
        name += ", anisotropic continuum"
    if substrate.of_atoms:
        forces = substrate.calculator.upper() or Path(*substrate.files).name
        element = f"{substrate.material}, " if substrate.material else ""
        name = f"{element}crystal of atoms ({forces})"
    label = solid.label(name)
    if substrate.periodic and solid.uniform_compliance:
        label += ", heights from the mean plane of its surface"
    return label


def _modulus(substrate: SubstrateConfig) -> float:
    """Return the contact modulus of an isotropic half space (GPa)."""
    if substrate.contact_modulus is not None:
        return in_gpa("contact_modulus", substrate.contact_modulus)
    young, poisson = substrate.youngs_modulus, substrate.poisson
    if young is not None and poisson is not None:
        return plane_strain_modulus(in_gpa("youngs_modulus", young), poisson)
    return contact_modulus(_constants(substrate))


def _constants(substrate: SubstrateConfig) -> tuple[float, ...]:
    """Return the elastic constants C11, C12 and C44 of a crystal (GPa)."""
    constants = substrate.elastic_constants
    if constants is None:
        if not substrate.material:
            raise ValueError(
                'the elastic solid is not given: give material, such as "Si", or '
                "contact_modulus, or youngs_modulus with poisson"
            )
        return crystal_constants(symbol_of(substrate))
    in_gpa("the contact modulus of elastic_constants", contact_modulus(constants))
    return constants


def in_gpa(name: str, modulus: float, largest: float = _MAX_MODULUS) -> float:
    """Return a modulus or a hardness after a check of its size (GPa)."""
    positive(**{name: modulus})
    if modulus > largest:
        raise ValueError(f"{name} is in GPa, at most {largest:g}, got {modulus:g}")
    return modulus


def _solid_of_kind(substrate: SubstrateConfig, spacing: float | None) -> ElasticSolid:
    """Return a solid that is defined outside of the package."""
    if substrate.kind is None:
        raise ValueError(f"{', '.join(substrate.parameters)} needs kind")
    kind = SOLIDS.find(substrate.kind)
    given = kind.converted_parameters(substrate.parameters, spacing or math.nan)
    return kind.of_parameters(**given)


def _cubic(substrate: SubstrateConfig) -> Cubic:
    c11, c12, c44 = (float(c) * UNITS["GPa"] for c in _constants(substrate))
    surface = substrate.surface or _DEFAULT_SURFACE
    return Cubic(c11, c12, c44, lookup(surface, _DIRECTION_OF_X, "surface"))


def _layer(substrate: SubstrateConfig) -> Layer:
    if substrate.layer_contact_modulus is None:
        raise ValueError("give layer_contact_modulus, E/(1 - nu^2) of the layer")
    modulus = in_gpa("layer_contact_modulus", substrate.layer_contact_modulus)
    thickness = substrate.plain(["layer_thickness"], LENGTHS, "Å").layer_thickness
    base = None if substrate.rigid_base else UNITS["GPa"] * _modulus(substrate)
    ratios = {"poisson": substrate.layer_poisson, "base_poisson": substrate.poisson}
    return Layer(
        UNITS["GPa"] * modulus,
        thickness,
        base,
        bonded=not substrate.frictionless_interface,
        **{name: ratio for name, ratio in ratios.items() if ratio is not None},
    )


def _crystal(substrate: SubstrateConfig) -> Crystal:
    if substrate.model == "continuum":
        raise ValueError('model = "continuum" needs moduli: a crystal is a lattice')
    file, contents = substrate.potential or substrate.crystal, ""
    if file:
        try:
            contents = digest_of_file(Path(file))
        except OSError as error:
            raise ValueError(f"can't read {file}: {error.strerror}") from error
    else:
        metals = lookup(substrate.calculator, _METALS_OF_CALCULATOR, "calculator")
        if substrate.material not in metals:
            raise ValueError(
                f"EMT has the metals {', '.join(metals)}, got material = "
                f"{substrate.material!r}: give one of them, or potential or crystal"
            )
    if not (substrate.material or substrate.crystal):
        raise ValueError("potential needs material, the element of the crystal")
    surface, symbol = substrate.surface or _DEFAULT_SURFACE, symbol_of(substrate)
    solid = _crystal_of(bool(substrate.crystal), file, contents, symbol, surface)
    for key, found in (("material", solid.symbol), ("surface", solid.surface)):
        given = getattr(substrate, key)
        if given not in ("", found):
            raise ValueError(f"{file} is of {found}, got {key} = {given!r}")
    return solid


@lru_cache(maxsize=8)
def _crystal_of(
    stored: bool, file: str, contents: str, symbol: str, surface: str
) -> Crystal:
    """Return a crystal: stored, of a potential of embedded atoms, or of EMT."""
    if stored:
        return Crystal.read(file)
    if not file:
        return Crystal.from_calculator(EMT(), symbol, surface)
    # imports scipy.stats, which takes a fifth of the start of every command
    from matscipy.calculators.eam import EAM

    kind = _POTENTIAL_FORMATS.get(Path(file).suffix, "eam/alloy")
    try:
        calculator = EAM(file, kind=kind)
    except Exception as error:
        formats = ", ".join(_POTENTIAL_FORMATS)
        raise ValueError(
            f"{file} is not a potential in the format {kind}: {error}. Give one of "
            f"{formats}; for other formats write a crystal with Python"
        ) from error
    return Crystal.from_calculator(calculator, symbol, surface, **_EAM_SLAB_OPTIONS)


# Solids other than the isotropic half space, by the key of [substrate] that asks for
# them.
_SOLID_OF_KEY: dict[str, Callable[[SubstrateConfig], ElasticSolid]] = {
    "calculator": _crystal,
    "potential": _crystal,
    "crystal": _crystal,
    "anisotropic": _cubic,
    "layer_thickness": _layer,
}
# Keys that only some solids have, each with the keys that it needs one of.
_NEEDED_KEYS: dict[str, tuple[str, ...]] = {
    "surface": (*_CRYSTAL_KEYS, "anisotropic"),
    "youngs_modulus": ("poisson",),
    "layer_contact_modulus": ("layer_thickness",),
    "layer_poisson": ("layer_thickness",),
    "rigid_base": ("layer_thickness",),
    "frictionless_interface": ("layer_thickness",),
}
