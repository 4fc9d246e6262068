"""Linear elasticity of the substrate: Green's functions and half spaces."""

from ase_roughcontact.elasticity.cell_kernels import (
    cerruti_kernel,
    cross_kernel,
)
from ase_roughcontact.elasticity.creep import Creep, fit_relaxation
from ase_roughcontact.elasticity.crystals.crystal import Crystal
from ase_roughcontact.elasticity.crystals.cubic import Cubic
from ase_roughcontact.elasticity.crystals.impedance import surface_modulus
from ase_roughcontact.elasticity.fft_backends import BlockTransform
from ase_roughcontact.elasticity.greens import SOLIDS, ElasticSolid, Isotropic
from ase_roughcontact.elasticity.halfspace import (
    FreeHalfSpace,
    HalfSpace,
    PeriodicHalfSpace,
)
from ase_roughcontact.elasticity.largest_stress import (
    LargestStress,
    largest_stress,
    principal_stresses,
    tension,
    tresca,
    von_mises,
)
from ase_roughcontact.elasticity.layer import Layer
from ase_roughcontact.elasticity.love import love_kernel
from ase_roughcontact.elasticity.material import (
    CRYSTALS,
    HARDNESS,
    contact_modulus,
    crystal_modulus,
)
from ase_roughcontact.elasticity.reduced import ReducedHalfSpace
from ase_roughcontact.elasticity.stress_field import StressField
from ase_roughcontact.elasticity.viscoelastic import Viscoelastic

__all__ = [
    "CRYSTALS",
    "HARDNESS",
    "SOLIDS",
    "BlockTransform",
    "Creep",
    "Crystal",
    "Cubic",
    "ElasticSolid",
    "FreeHalfSpace",
    "HalfSpace",
    "Isotropic",
    "LargestStress",
    "Layer",
    "PeriodicHalfSpace",
    "ReducedHalfSpace",
    "StressField",
    "Viscoelastic",
    "cerruti_kernel",
    "contact_modulus",
    "cross_kernel",
    "crystal_modulus",
    "fit_relaxation",
    "largest_stress",
    "love_kernel",
    "principal_stresses",
    "surface_modulus",
    "tension",
    "tresca",
    "von_mises",
]
