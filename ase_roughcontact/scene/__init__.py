"""A whole calculation as one object, also written as a TOML file.

See ``ase_roughcontact/default.toml`` for the format, key by key.
"""

from ase_roughcontact.scene.config import (
    InteractionTable,
    PathTable,
    RoughnessTable,
    SolverTable,
    SphereTable,
    SubstrateTable,
)
from ase_roughcontact.scene.optimizers import OPTIMIZERS
from ase_roughcontact.scene.scene import NANONEWTON, Scene, default_text

__all__ = [
    "NANONEWTON",
    "OPTIMIZERS",
    "InteractionTable",
    "PathTable",
    "RoughnessTable",
    "Scene",
    "SolverTable",
    "SphereTable",
    "SubstrateTable",
    "default_text",
]
