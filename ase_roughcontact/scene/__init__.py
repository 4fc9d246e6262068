"""A whole calculation as one object, which can be written as a TOML file.

The built-in scene file, `default_text`, explains every key. From the file to results:

====================  ================================================================
``section``           base class of sections: types, units, names of files
``config``, ``scan``  sections of bodies, solver and output, and of a measured surface
``random_fields``     sections of roughness and of the local work of adhesion
``path_kind``         base class of the kinds of path, and the steps that are given
``path_result``       numbers that follow from all steps of a path
``study``             values of parameters, for ensembles
``file``              all sections of a file: read, changed, compared
``solid``             the elastic solid, from ``[substrate]``
``spacing``           the spacing of the grid that fits a contact
``build``             from the sections to a `Problem` in units of ASE
``bodies``            solid, indenter and wall that are built, and theory for them
``scene``             `Scene`: bodies, path and solver, which relax the steps
``plan``              warnings, steps that can't be calculated, memory and time
``results``           folders of results
``finished_run``      `Results`: the folder of a run, read
``tabular``           columns with units: tables and figures of results
====================  ================================================================

``preview`` (a few steps on a coarse grid), ``reference`` (theory for the results) and
``optimizers`` (their comparison) are functions of a scene. Further kinds of path are in
`ase_roughcontact.path_kinds`: scenes find them by the entry "scene" of `SHOWN` in the
`__init__` of their folders.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from ase_roughcontact._util.parts import import_shown, shown_by
from ase_roughcontact._util.units import nN
from ase_roughcontact.scene.config import (
    OPTIMIZERS,
    IndenterConfig,
    InteractionConfig,
    OutputConfig,
    SolverConfig,
    SphereConfig,
    SubstrateConfig,
    on_modes,
)
from ase_roughcontact.scene.file import default_text
from ase_roughcontact.scene.finished_run import Results
from ase_roughcontact.scene.path_kind import PathKind, Steps
from ase_roughcontact.scene.path_result import PathResult
from ase_roughcontact.scene.random_fields import HeterogeneityConfig, RoughnessConfig
from ase_roughcontact.scene.scan import TopographyConfig
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.scene.section import lengths
from ase_roughcontact.scene.study import StudyConfig

__all__ = [
    "OPTIMIZERS",
    "HeterogeneityConfig",
    "IndenterConfig",
    "InteractionConfig",
    "OutputConfig",
    "PathKind",
    "PathResult",
    "Results",
    "RoughnessConfig",
    "Scene",
    "SolverConfig",
    "SphereConfig",
    "Steps",
    "StudyConfig",
    "SubstrateConfig",
    "TopographyConfig",
    "default_text",
    "lengths",
    "on_modes",
]

NANONEWTON = nN

if TYPE_CHECKING:
    from ase_roughcontact.path_kinds.loop.scene import Loop, relax_loop
    from ase_roughcontact.path_kinds.sliding.scene import Sliding
    from ase_roughcontact.path_kinds.sliding.timed_scene import TimedSliding
    from ase_roughcontact.path_kinds.time.scene import Timed

    __all__ += [
        "Loop",
        "Sliding",
        "Timed",
        "TimedSliding",
        "relax_loop",
    ]
else:
    __all__ += shown_by("scene")

    def __getattr__(name: str) -> Any:
        """Return a kind of path from its own package."""
        return import_shown("scene", name)


for _module in shown_by("scene").values():
    import_module(_module)  # makes a kind of path known to scene files
