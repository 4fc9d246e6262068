"""A whole calculation as one object, also written as a TOML file.

See ``ase_roughcontact/default.toml`` for the format, key by key.
"""

from ase_roughcontact.scene.calculation import NANONEWTON, Scene, default_text
from ase_roughcontact.scene.optimizers import OPTIMIZERS
from ase_roughcontact.tables import (
    InteractionTable,
    PathTable,
    RoughnessTable,
    SolverTable,
    SphereTable,
    SubstrateTable,
)

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
