"""The elastic solid of a scene, from the keys of its section ``[substrate]``."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from ase.calculators.emt import EMT
from matscipy.calculators.eam import EAM

from ase_roughcontact._util.units import LENGTHS, UNITS
from ase_roughcontact._util.validation import lookup, positive
from ase_roughcontact.elasticity import Crystal, Cubic, ElasticSolid, Isotropic, Layer
from ase_roughcontact.elasticity.material import (
    contact_modulus,
    crystal_constants,
    crystal_modulus,
)
from ase_roughcontact.elasticity.named_materials import material
from ase_roughcontact.scene.config import SYMBOL, SubstrateConfig
from ase_roughcontact.windows.regrid import GridChange

# Modulus (GPa) above that of any solid: a larger value is in another unit.
_LARGEST_MODULUS = 1e4
# Slabs for potentials of embedded atoms, which reach far and have a Hessian.
_EAM_SLABS: dict[str, Any] = {"layers": 19, "size": 11, "displacement": 0.0}
# Metals with parameters of EMT, which are for some gases, too.
_EMT_METALS = "Al", "Cu", "Ag", "Au", "Ni", "Pd", "Pt"
# Keys that make a solid other than the isotropic half space, the first of which differ
# by their surface.
_OF_SURFACES = "calculator", "potential", "crystal", "anisotropic"
_SOLIDS = (*_OF_SURFACES, "layer_thickness")
# The surface if none is named, and the crystal direction of the rows of atoms along x.
_SURFACE = "fcc100"
_AXES = {"fcc100": "110", "bcc100": "100", "diamond100": "110"}
# Formats of potentials by the ends of the names of their files.
_FORMATS = {".alloy": "eam/alloy", ".fs": "eam/fs", ".eam": "eam"}
# Keys of a layer and its base, which have no meaning without its thickness, and those
# of an elastic base.
_OF_LAYERS = "layer_modulus", "layer_poisson", "poisson", "rigid_base", "sliding"
_OF_BASES = "poisson", "contact_modulus", "elastic_constants"


def solid_of(substrate: SubstrateConfig) -> ElasticSolid:
    """Return the elastic solid that a section describes.

    Parameters
    ----------
    substrate : SubstrateConfig

    Returns
    -------
    ElasticSolid
        With moduli in eV/Å^3.

    Raises
    ------
    ValueError
        If a value is out of range, keys of several solids are given, or a calculator
        is not suitable.
    """
    given = [key for key in _SOLIDS if getattr(substrate, key)]
    if len(given) > 1:
        raise ValueError(f"give one of {' and '.join(given)}: they are several solids")
    kind = given[0] if given else ""
    if substrate.surface and kind not in _OF_SURFACES:
        raise ValueError(
            f"surface needs one of {', '.join(_OF_SURFACES)}: other solids are "
            "isotropic"
        )
    if kind != "layer_thickness":
        for key in _OF_LAYERS:
            if getattr(substrate, key) != getattr(type(substrate), key):  # the default
                raise ValueError(f"{key} needs layer_thickness: it is that of a layer")
    if substrate.of_atoms:
        return _crystal(substrate)
    if kind == "layer_thickness":
        return _layer(substrate)
    if kind == "anisotropic":
        if substrate.contact_modulus is not None:
            raise ValueError(
                "an anisotropic solid has several moduli: give elastic_constants "
                "instead of contact_modulus"
            )
        constants = substrate.elastic_constants
        if constants is None:
            constants = crystal_constants(substrate.symbol)
        if len(constants) != 3:
            raise ValueError(
                "an anisotropic solid needs the elastic_constants C11, C12 and C44, "
                f"got {len(constants)} numbers"
            )
        _in_gpa("C11", constants[0])
        c11, c12, c44 = (float(c) * UNITS["GPa"] for c in constants)
        axis = lookup(substrate.surface or _SURFACE, _AXES, "surface")
        return Cubic(c11, c12, c44, axis)
    return Isotropic(UNITS["GPa"] * _modulus(substrate))


def named(substrate: SubstrateConfig) -> SubstrateConfig:
    """Return the section with a symbol, and with values of its material.

    Parameters
    ----------
    substrate : SubstrateConfig

    Returns
    -------
    SubstrateConfig
        Without the grid of a continuum in place of the spacing.
    """
    given, name = substrate, substrate.material
    if GridChange.of(spacing=given.spacing) is not None:
        given = replace(given, spacing=None)
    if not name:
        return replace(given, symbol=given.symbol or SYMBOL)
    if given.symbol:
        raise ValueError(
            f"give symbol or material, not both, got {given.symbol!r} and {name!r}"
        )
    known = material(name)
    changes: dict[str, Any] = {"symbol": known.symbol}
    if given.spacing is None:
        changes["spacing"] = known.spacing
    if given.contact_modulus is None and given.elastic_constants is None:
        if given.other_solid:
            raise ValueError(
                f"material = {name!r} gives the modulus of an isotropic half "
                f"space, which {given.other_solid} does not have: give symbol "
                "instead of material"
            )
        changes["contact_modulus"] = known.contact_modulus
    return replace(given, **changes)


def label_of(substrate: SubstrateConfig, solid: ElasticSolid) -> str:
    """Return the name and the contact modulus of a solid.

    Parameters
    ----------
    substrate : SubstrateConfig
        Section that describes it, as given.
    solid : ElasticSolid
        With moduli in eV/Å^3.

    Returns
    -------
    str
    """
    name = substrate.name or "half space of given moduli"
    modulus = _printed_modulus(solid.contact_modulus)
    if isinstance(solid, Layer):
        layer = _printed_modulus(solid.layer_modulus)
        bond = "bonded to" if solid.bonded else "sliding on"
        base = "a rigid base" if solid.base_modulus is None else f"{name}, {modulus}"
        thickness = solid.thickness / UNITS["nm"]
        label = f"layer of {thickness:.4g} nm, {layer}, {bond} {base}"
        if substrate.periodic and solid.uniform_compliance:
            label += ", heights from the mean plane of its surface"
        return label
    if isinstance(solid, Cubic):
        name += ", anisotropic continuum"
    if isinstance(solid, Crystal):
        forces = substrate.calculator.upper() or Path(*substrate.files).name
        name += f", crystal of atoms ({forces})"
    return f"{name}, {modulus}"


def _printed_modulus(modulus: float) -> str:
    return f"E* = {modulus / UNITS['GPa']:.4g} GPa"


def _modulus(substrate: SubstrateConfig) -> float:
    """Return the contact modulus of an isotropic half space (GPa)."""
    modulus, constants = substrate.contact_modulus, substrate.elastic_constants
    if modulus is not None and constants is not None:
        raise ValueError("give contact_modulus or elastic_constants, not both")
    if constants is not None:
        name = "the contact modulus of elastic_constants"
        return _in_gpa(name, contact_modulus(constants))
    if modulus is not None:
        return _in_gpa("contact_modulus", modulus)
    try:
        return crystal_modulus(substrate.symbol)
    except ValueError as error:
        raise ValueError(
            f"symbol = {substrate.symbol!r}: {error}; give contact_modulus or "
            "elastic_constants"
        ) from error


def _in_gpa(name: str, modulus: float) -> float:
    """Return a modulus after a check of its size (GPa)."""
    positive(**{name: modulus})
    if modulus > _LARGEST_MODULUS:
        raise ValueError(
            f"{name} is in GPa, at most {_LARGEST_MODULUS:g}, got {modulus:g}"
        )
    return modulus


def _layer(substrate: SubstrateConfig) -> Layer:
    if substrate.layer_modulus is None:
        raise ValueError("give layer_modulus, the contact modulus of the layer")
    for key in _OF_BASES:
        if substrate.rigid_base and getattr(substrate, key) is not None:
            raise ValueError(f"a rigid base has no {key}: omit it or rigid_base")
    thickness = substrate.plain(["layer_thickness"], LENGTHS, "\u00c5").layer_thickness
    base = None if substrate.rigid_base else UNITS["GPa"] * _modulus(substrate)
    ratios = {"poisson": substrate.layer_poisson, "base_poisson": substrate.poisson}
    return Layer(
        UNITS["GPa"] * _in_gpa("layer_modulus", substrate.layer_modulus),
        thickness,
        base,
        bonded=not substrate.sliding,
        **{name: ratio for name, ratio in ratios.items() if ratio is not None},
    )


def _crystal(substrate: SubstrateConfig) -> Crystal:
    if substrate.model == "continuum":
        raise ValueError(
            'model = "continuum" needs moduli: a solid that follows from the forces '
            "between atoms is a lattice"
        )
    for key in ("contact_modulus", "elastic_constants"):
        if getattr(substrate, key) is not None:
            raise ValueError(
                f"{key} follows from the forces between the atoms: omit it"
            )
    file = substrate.potential or substrate.crystal
    changed = 0
    if file:
        try:
            Path(file).open("rb").close()  # an error of a folder, too
            changed = Path(file).stat().st_mtime_ns
        except OSError as error:
            raise ValueError(f"can't read {file}: {error}") from error
    if substrate.crystal:
        solid = _read_crystal(file, changed)
        if solid.symbol != substrate.symbol:
            raise ValueError(
                f"{file} is a crystal of {solid.symbol}, not of symbol = "
                f"{substrate.symbol!r}"
            )
        if substrate.surface not in ("", solid.surface):
            raise ValueError(
                f"{file} has the surface {solid.surface}, not surface = "
                f"{substrate.surface!r}"
            )
        return solid
    if substrate.calculator:
        lookup(substrate.calculator, {"emt": EMT}, "calculator")
        if substrate.symbol not in _EMT_METALS:
            raise ValueError(
                f"EMT knows the metals {', '.join(_EMT_METALS)}, got symbol = "
                f"{substrate.symbol!r}: give one of them, or potential or crystal"
            )
    surface = substrate.surface or _SURFACE
    return _calculated_crystal(file, changed, substrate.symbol, surface)


@lru_cache(maxsize=8)
def _read_crystal(file: str, changed: int) -> Crystal:
    return Crystal.read(file)


@lru_cache(maxsize=8)
def _calculated_crystal(
    potential: str, changed: int, symbol: str, surface: str
) -> Crystal:
    """Return the crystal of EMT or of a potential of embedded atoms."""
    if not potential:
        return Crystal.from_calculator(EMT(), symbol, surface)
    kind = _FORMATS.get(Path(potential).suffix, "eam/alloy")
    try:
        calculator = EAM(potential, kind=kind)
    except Exception as error:
        raise ValueError(
            f"{potential} is not a potential in the format {kind}: {error}. The format "
            f"follows from the end of the name, one of {', '.join(_FORMATS)}; crystals "
            "of other potentials are written with Python, and given by crystal"
        ) from error
    return Crystal.from_calculator(calculator, symbol, surface, **_EAM_SLABS)
