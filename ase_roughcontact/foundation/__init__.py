"""Atoms with a user-supplied calculator on top of an elastic semi-infinite crystal."""

from ase_roughcontact.foundation.builders import crystal_slab
from ase_roughcontact.foundation.calculator import ElasticFoundation
from ase_roughcontact.foundation.indenter import RigidIndenter, add_indenter
from ase_roughcontact.foundation.precon import FoundationPrecon
from ase_roughcontact.foundation.surface import CrystalSurface

__all__ = [
    "CrystalSurface",
    "ElasticFoundation",
    "FoundationPrecon",
    "RigidIndenter",
    "add_indenter",
    "crystal_slab",
]
