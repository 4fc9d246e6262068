"""Atoms with any ASE calculator on top of an elastic semi-infinite crystal."""

from ase_roughcontact.foundation.builders import crystal_slab
from ase_roughcontact.foundation.calculator import ElasticFoundation
from ase_roughcontact.foundation.indenter import RigidIndenter, add_indenter
from ase_roughcontact.foundation.precon import FoundationPrecon
from ase_roughcontact.foundation.surface import CrystalSurface

SHOWN = {
    "": {
        "CrystalSurface": "surface",
        "ElasticFoundation": "calculator",
        "FoundationPrecon": "precon",
        "RigidIndenter": "indenter",
        "add_indenter": "indenter",
        "crystal_slab": "builders",
    }
}

__all__ = [
    "CrystalSurface",
    "ElasticFoundation",
    "FoundationPrecon",
    "RigidIndenter",
    "add_indenter",
    "crystal_slab",
]
