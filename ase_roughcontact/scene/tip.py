"""The elastic solid of an indenter, from ``[tip]`` or the material of its shape."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.elasticity import named_materials
from ase_roughcontact.elasticity.material import plane_strain_modulus
from ase_roughcontact.scene.config import TipConfig
from ase_roughcontact.scene.file import SceneFile
from ase_roughcontact.scene.solid import MAX_HARDNESS, in_gpa


@dataclass(frozen=True)
class ElasticTip:
    """Elastic solid of an indenter.

    Attributes
    ----------
    name : str
        Name of its material; empty if only moduli are given.
    contact_modulus : float
        Contact modulus E/(1 - nu^2) (eV/Å^3).
    poisson : float or None
        Poisson's ratio; None if it is not known.
    hardness : float
        Hardness (GPa); NaN if it is not known.
    hardness_is_given : bool
        Whether the hardness is given, and does not follow from the material.
    """

    name: str
    contact_modulus: float
    poisson: float | None
    hardness: float
    hardness_is_given: bool

    @property
    def source(self) -> str:
        """What the modulus follows from, for messages."""
        return f"the material {self.name!r}" if self.name else "the tip"

    @property
    def label(self) -> str:
        """Name and contact modulus."""
        modulus = f"E* {self.contact_modulus / UNITS['GPa']:.4g} GPa"
        return f"{self.name} ({modulus})" if self.name else f"a tip of {modulus}"


def elastic_tip(scene: SceneFile) -> ElasticTip | None:
    """Return the elastic solid of the indenter; None if it is rigid.

    Raises
    ------
    ValueError
        If a material is unknown or given twice, or a value is out of range.
    """
    tip, name = scene.tip or TipConfig(), scene.tip_material
    of_shape = (scene.indenter or scene.sphere).material
    if tip.material and of_shape:
        raise ValueError(
            f"give the material of the tip once, got {tip.material!r} in [tip] and "
            f"{of_shape!r} in [sphere] or [indenter]"
        )
    material = named_materials.material(name) if name else None
    modulus = _modulus(tip)
    if modulus is None and material is None:
        if tip.given:
            raise ValueError(
                f"{', '.join(tip.given)} needs material, contact_modulus or "
                "youngs_modulus, without which the tip is rigid"
            )
        return None
    poisson = tip.poisson
    if material is not None:
        modulus = material.contact_modulus if modulus is None else modulus
        poisson = material.poisson if poisson is None else poisson
    assert modulus is not None
    return ElasticTip(
        name,
        modulus * UNITS["GPa"],
        poisson,
        _hardness(tip, name),
        tip.hardness is not None,
    )


def _modulus(tip: TipConfig) -> float | None:
    """Return the contact modulus of given moduli (GPa); None if none is given."""
    if tip.contact_modulus is not None and tip.youngs_modulus is not None:
        raise ValueError("give contact_modulus or youngs_modulus, not both")
    if tip.contact_modulus is not None:
        return in_gpa("contact_modulus", tip.contact_modulus)
    if tip.youngs_modulus is None:
        return None
    if tip.poisson is None:
        raise ValueError("youngs_modulus needs poisson: E* = E/(1 - nu^2)")
    young = in_gpa("youngs_modulus", tip.youngs_modulus)
    return plane_strain_modulus(young, tip.poisson)


def _hardness(tip: TipConfig, name: str) -> float:
    """Return the given hardness, or the hardness of the material; else NaN (GPa)."""
    if tip.hardness is None:
        return named_materials.hardness_of(name) if name else math.nan
    if tip.hardness == math.inf:
        return math.inf
    return in_gpa("hardness", tip.hardness, MAX_HARDNESS)
