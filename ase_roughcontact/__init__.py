"""Contact of rough spheres with elastic solids, as an ASE calculator."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

# Packages with public names, which are attributes without an import of their own.
_PACKAGES = (
    "analysis",
    "elasticity",
    "ensemble",
    "interactions",
    "optimize",
    "plot",
    "scene",
    "theory",
    "topography",
)

if TYPE_CHECKING:
    from ase_roughcontact import (
        analysis,
        elasticity,
        ensemble,
        foundation,
        interactions,
        optimize,
        plot,
        scene,
        theory,
        topography,
    )
    from ase_roughcontact.api import *  # noqa: F403
else:

    def __getattr__(name: str) -> Any:
        """Import the package when a name is used, so that `__main__` handles Ctrl-C."""
        if name in _PACKAGES:
            return import_module(f"{__name__}.{name}")
        public = import_module("ase_roughcontact.api")
        if name in ("__all__", *public.__all__):
            return getattr(public, name)
        if name in globals():  # a package that was imported just now
            return globals()[name]
        parts = import_module("ase_roughcontact._util.parts")
        if name in parts.found_parts():
            return import_module(f"{__name__}.{name}")
        return parts.import_shown("", name)

    def __dir__() -> list[str]:
        imported = {"Any", "TYPE_CHECKING", "import_module", "_PACKAGES"}
        public = import_module("ase_roughcontact.api").__all__
        return sorted({*globals(), *_PACKAGES, *public} - imported)
