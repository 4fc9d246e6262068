"""Optional parts: packages that can be deleted, found by their folders.

No package below the command line imports a part by name. The ``__init__`` of each part
has a table ``SHOWN``: names that other packages offer as their own, with the module of
the part that defines them::

    SHOWN = {"plot": {"plot_loop": "figures"}}

makes the function of the module ``figures`` available as
``ase_roughcontact.plot.plot_loop``. The package ``""`` is ``ase_roughcontact`` itself,
which has these names without listing them.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

# Name of this package.
_PACKAGE = "ase_roughcontact"
# Packages that are parts.
_PARTS = ("fitting", "foundation", "tradeoff")
# Package with one part in each folder.
_KINDS = "path_kinds"


@cache
def found_parts() -> tuple[str, ...]:
    """Return the names of the existing parts within the package."""
    folders = import_module(_PACKAGE).__path__
    packages = {each.name for each in iter_modules(folders) if each.ispkg}
    found = [name for name in _PARTS if name in packages]
    if _KINDS in packages:
        folders = import_module(f"{_PACKAGE}.{_KINDS}").__path__
        kinds = [each.name for each in iter_modules(folders) if each.ispkg]
        found += [f"{_KINDS}.{name}" for name in kinds]
    return tuple(found)


@cache
def shown_by(package: str) -> dict[str, str]:
    """Return the names from parts that a package offers, with their modules.

    Parameters
    ----------
    package : str
        Name of a package within ``ase_roughcontact``, such as ``"plot"``; empty for
        the package itself.

    Returns
    -------
    dict of str to str
        Full names of modules, by the offered names.
    """
    found = {}
    for part in found_parts():
        shown = import_module(f"{_PACKAGE}.{part}").SHOWN
        for name, module in shown.get(package, {}).items():
            found[name] = f"{_PACKAGE}.{part}.{module}"
    return found


def import_shown(package: str, name: str) -> Any:
    """Return an object of a part that a package offers.

    Parameters
    ----------
    package, name : str
        Names of the package and of the object; see `shown_by`.

    Returns
    -------
    object
        The object.

    Raises
    ------
    AttributeError
        If no existing part has this name for the package.
    """
    modules = shown_by(package)
    if name not in modules:
        module = f"{_PACKAGE}.{package}".rstrip(".")
        raise AttributeError(f"module {module!r} has no attribute {name!r}")
    return getattr(import_module(modules[name]), name)
