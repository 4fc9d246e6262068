"""Linear elasticity of the substrate: Green's functions and half spaces."""

from ase_roughcontact.elasticity.greens import ElasticSolid, Isotropic, love_kernel
from ase_roughcontact.elasticity.halfspace import (
    FreeHalfSpace,
    HalfSpace,
    PeriodicHalfSpace,
)
from ase_roughcontact.elasticity.material import (
    CRYSTALS,
    contact_modulus,
    crystal_modulus,
)
from ase_roughcontact.elasticity.reduced import ReducedHalfSpace

__all__ = [
    "CRYSTALS",
    "ElasticSolid",
    "FreeHalfSpace",
    "HalfSpace",
    "Isotropic",
    "PeriodicHalfSpace",
    "ReducedHalfSpace",
    "contact_modulus",
    "crystal_modulus",
    "love_kernel",
]
