"""Contact of rough spheres with elastic solids, as an ASE calculator."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from ase_roughcontact.api import *  # noqa: F403
else:

    def __getattr__(name: str) -> Any:
        """Import the package when a name is used, so that `__main__` handles Ctrl-C."""
        public = import_module("ase_roughcontact.api")
        if name in ("__all__", *public.__all__):
            return getattr(public, name)
        if name in globals():  # a package that was imported just now
            return globals()[name]
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        imported = {"Any", "TYPE_CHECKING", "import_module"}
        public = import_module("ase_roughcontact.api").__all__
        return sorted({*globals(), *public} - imported)
