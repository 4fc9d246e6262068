"""A whole calculation as one object, which can be written as a TOML file.

The built-in scene file, `default_text`, explains every key. A scene is read from the
top of this list downward:

================================  ====================================================
``section``                       common to all sections: types, units, names of files
``config``, ``scan``              the sections, one class each
``random_fields``                 sections of roughness and local work of adhesion
``path_kinds``, ``loop``          kinds of path: section, targets, run, table, pictures
``file``                          all sections of a file: read, changed, compared
``bodies``, ``solid``             solid, indenter and wall in units of ASE, with theory
``scene``                         `Scene`: problem, solver and steps; checks and runs
``plan``, ``results``             plans of paths, and folders of results
================================  ====================================================

The classes of ``file``, ``bodies`` and ``scene`` are each a subclass of the one before.
What they build from the sections is built once. ``reference``, ``preview``,
``tradeoff`` and ``fit`` are functions of a scene.
"""

from ase_roughcontact.scene.config import (
    HeterogeneityConfig,
    InteractionConfig,
    RoughnessConfig,
    SolverConfig,
    SphereConfig,
    SubstrateConfig,
    TopographyConfig,
)
from ase_roughcontact.scene.loop import Loop
from ase_roughcontact.scene.optimizers import OPTIMIZERS, on_modes
from ase_roughcontact.scene.path_kinds import PathKind, Steps
from ase_roughcontact.scene.scene import NANONEWTON, Scene, default_text

PathConfig = Steps

__all__ = [
    "NANONEWTON",
    "OPTIMIZERS",
    "HeterogeneityConfig",
    "InteractionConfig",
    "Loop",
    "PathConfig",
    "PathKind",
    "RoughnessConfig",
    "Scene",
    "SolverConfig",
    "SphereConfig",
    "Steps",
    "SubstrateConfig",
    "TopographyConfig",
    "default_text",
    "on_modes",
]
