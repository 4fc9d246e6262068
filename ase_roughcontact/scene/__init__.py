"""A whole calculation as one object, also written as a TOML file.

See ``ase_roughcontact/default.toml`` for the format, key by key.
"""

from ase_roughcontact.scene.config import (
    InteractionConfig,
    PathConfig,
    RoughnessConfig,
    SolverConfig,
    SphereConfig,
    SubstrateConfig,
)
from ase_roughcontact.scene.optimizers import OPTIMIZERS
from ase_roughcontact.scene.scene import NANONEWTON, Scene, default_text

__all__ = [
    "NANONEWTON",
    "OPTIMIZERS",
    "InteractionConfig",
    "PathConfig",
    "RoughnessConfig",
    "Scene",
    "SolverConfig",
    "SphereConfig",
    "SubstrateConfig",
    "default_text",
]
