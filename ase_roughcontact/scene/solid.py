"""The elastic solid of a scene, from the keys of its section ``[substrate]``."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from ase.calculators.emt import EMT
from matscipy.calculators.eam import EAM

from ase_roughcontact._util.units import LENGTHS, UNITS, pressure_unit
from ase_roughcontact._util.validation import lookup, positive
from ase_roughcontact.elasticity import (
    Creep,
    Crystal,
    Cubic,
    ElasticSolid,
    Isotropic,
    Layer,
    Viscoelastic,
)
from ase_roughcontact.elasticity.material import (
    check_element,
    contact_modulus,
    crystal_constants,
    crystal_modulus,
    fcc_spacing,
    poisson_ratio,
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
# The surface if none is named, and the crystal direction of the rows of atoms along x.
_SURFACE = "fcc100"
_AXES = {"fcc100": "110", "bcc100": "100", "diamond100": "110"}
# Formats of potentials by the ends of the names of their files.
_FORMATS = {".alloy": "eam/alloy", ".fs": "eam/fs", ".eam": "eam"}
# Keys of an elastic base, which a rigid one does not have.
_OF_BASES = "poisson", "contact_modulus", "elastic_constants"
# Keys of solids that do not have the modulus of a material.
_WITHOUT_MODULUS = "anisotropic", "rigid_base", "calculator", "potential", "crystal"


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
    solids = [key for key in _SOLIDS if getattr(substrate, key)]
    if len(solids) > 1:
        raise ValueError(f"give one of {' and '.join(solids)}: they are several solids")
    defaults = SubstrateConfig()
    without = [
        f"{key} needs {'one of ' * (len(needed) > 1)}{', '.join(needed)}"
        for key, needed in _NEEDED.items()
        if getattr(substrate, key) != getattr(defaults, key)
        and not set(needed) & set(solids)
    ]
    if without:
        raise ValueError("; ".join(without))
    if substrate.poisson is not None and solids and solids != ["layer_thickness"]:
        raise ValueError(
            f"{solids[0]} gives elastic constants, which poisson does not change: "
            "leave it out"
        )
    return _SOLIDS[solids[0]](substrate) if solids else _isotropic(substrate)


def named(substrate: SubstrateConfig) -> SubstrateConfig:
    """Return the section with a symbol, and with values of its material.

    Parameters
    ----------
    substrate : SubstrateConfig

    Returns
    -------
    SubstrateConfig
        Without the grid of a continuum in place of the spacing.

    Raises
    ------
    ValueError
        If the symbol or the material is unknown, or both are given.
    """
    given, name = substrate, substrate.material
    if GridChange.of(spacing=given.spacing) is not None:
        given = replace(given, spacing=None)
    if not name:
        check_element(given.symbol or SYMBOL)
        return replace(given, symbol=given.symbol or SYMBOL)
    if given.symbol:
        raise ValueError(
            f"give symbol or material, not both, got {given.symbol!r} and {name!r}"
        )
    known = material(name)
    spacing = known.spacing if given.spacing is None else given.spacing
    given = replace(given, symbol=known.symbol, spacing=spacing)
    if given.contact_modulus is not None or given.elastic_constants is not None:
        return given
    other = next((key for key in _WITHOUT_MODULUS if getattr(given, key)), "")
    if other:
        raise ValueError(
            f"material = {name!r} gives the modulus of an isotropic half space, which "
            f"{other} does not have: give symbol instead of material"
        )
    return replace(given, contact_modulus=known.contact_modulus)


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
        If it is not positive, or neither given nor known.
    """
    spacing = substrate.plain(["spacing"], LENGTHS, "Å").spacing
    if spacing is not None:
        positive(spacing=spacing)
        return spacing
    return None if substrate.of_atoms else _known(substrate, fcc_spacing)


def poisson_of(substrate: SubstrateConfig) -> float:
    """Return Poisson's ratio of an isotropic solid, which friction needs.

    Parameters
    ----------
    substrate : SubstrateConfig
        See `named`, with the material as given.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If it is neither given nor known.
    """
    if substrate.poisson is not None:
        return substrate.poisson
    if substrate.elastic_constants is not None:
        return poisson_ratio(substrate.elastic_constants)
    known = None
    if substrate.name:
        with suppress(ValueError):
            known = material(substrate.name).poisson
    if known is None:
        raise ValueError(
            "friction needs Poisson's ratio, which is not known of this solid: give "
            "poisson"
        )
    return known


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
    given = "contact_modulus", "elastic_constants", "layer_modulus"
    if substrate.material and all(getattr(substrate, key) is None for key in given):
        raise ValueError(
            f"the modulus of material = {substrate.material!r} is not instantaneous: "
            "give contact_modulus, from which relaxation_moduli relax"
        )
    if not len(moduli) == len(times) > 0:
        raise ValueError(
            "give as many relaxation_moduli as relaxation_times, at least one, got "
            f"{len(moduli)} and {len(times)}"
        )
    positive(relaxation_moduli=min(moduli), relaxation_times=min(times))
    return Creep.of_relaxation(moduli, times)


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
    if isinstance(solid, Viscoelastic):
        label = label_of(substrate, solid.solid)
        if not solid.creep.relaxed:
            return f"{label}, a fluid in the end"
        relaxed = solid.creep.relaxed * solid.contact_modulus
        return f"{label}, relaxing to {_printed_modulus(relaxed)}"
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
    unit = pressure_unit(modulus)
    return f"E* = {modulus / UNITS[unit]:.4g} {unit}"


def _isotropic(substrate: SubstrateConfig) -> Isotropic:
    return Isotropic(UNITS["GPa"] * _modulus(substrate), substrate.poisson)


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
    advice = "; give contact_modulus or elastic_constants"
    return _known(substrate, crystal_modulus, advice)


def _known(
    substrate: SubstrateConfig, value_of: Callable[[str], float], advice: str = ""
) -> float:
    """Return a value that is known for the symbol of some solids."""
    try:
        return value_of(substrate.symbol)
    except ValueError as error:
        raise ValueError(f"symbol = {substrate.symbol!r}: {error}{advice}") from error


def _in_gpa(name: str, modulus: float) -> float:
    """Return a modulus after a check of its size (GPa)."""
    positive(**{name: modulus})
    if modulus > _LARGEST_MODULUS:
        raise ValueError(
            f"{name} is in GPa, at most {_LARGEST_MODULUS:g}, got {modulus:g}"
        )
    return modulus


def _cubic(substrate: SubstrateConfig) -> Cubic:
    if substrate.contact_modulus is not None:
        raise ValueError(
            "an anisotropic solid has several moduli: give elastic_constants instead "
            "of contact_modulus"
        )
    constants = substrate.elastic_constants
    if constants is None:
        constants = crystal_constants(substrate.symbol)
    if len(constants) != 3:
        raise ValueError(
            "an anisotropic solid needs the elastic_constants C11, C12 and C44, got "
            f"{len(constants)} numbers"
        )
    _in_gpa("C11", constants[0])
    c11, c12, c44 = (float(c) * UNITS["GPa"] for c in constants)
    return Cubic(c11, c12, c44, lookup(substrate.surface or _SURFACE, _AXES, "surface"))


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
            raise ValueError(f"can't read {file}: {error.strerror}") from error
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


# Solids other than the isotropic half space, by the key of [substrate] that asks for
# them, and keys that only some of them have.
_SOLIDS: dict[str, Callable[[SubstrateConfig], ElasticSolid]] = {
    **dict.fromkeys(("calculator", "potential", "crystal"), _crystal),
    "anisotropic": _cubic,
    "layer_thickness": _layer,
}
_NEEDED: dict[str, tuple[str, ...]] = {
    "surface": ("calculator", "potential", "crystal", "anisotropic"),
    **dict.fromkeys(
        ("layer_modulus", "layer_poisson", "rigid_base", "sliding"),
        ("layer_thickness",),
    ),
}
