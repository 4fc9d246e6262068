"""A whole calculation as one object, which can be written as a TOML file.

The built-in scene file, `default_text`, explains every key.
"""

from ase_roughcontact.scene.config import (
    HeterogeneityConfig,
    InteractionConfig,
    PathConfig,
    RoughnessConfig,
    SolverConfig,
    SphereConfig,
    SubstrateConfig,
    TopographyConfig,
)
from ase_roughcontact.scene.optimizers import OPTIMIZERS, on_modes
from ase_roughcontact.scene.scene import NANONEWTON, Scene, default_text

__all__ = [
    "NANONEWTON",
    "OPTIMIZERS",
    "HeterogeneityConfig",
    "InteractionConfig",
    "PathConfig",
    "RoughnessConfig",
    "Scene",
    "SolverConfig",
    "SphereConfig",
    "SubstrateConfig",
    "TopographyConfig",
    "default_text",
    "on_modes",
]
