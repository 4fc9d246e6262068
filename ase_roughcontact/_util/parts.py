"""Packages that can be left out, found by their folders.

No package below the command line imports them by name. The ``__init__`` of each part
has a table ``SHOWN``: the names that other packages show as theirs, with the module
of the part that defines them::

    SHOWN = {"plot": {"plot_loop": "figures"}}

lets ``ase_roughcontact.plot.plot_loop`` be the function of the module ``figures``.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

_PACKAGE = "ase_roughcontact"
# Packages that are parts.
_PARTS = ("fitting", "foundation", "tradeoff")
# Package in which each folder is a part.
_KINDS = "path_kinds"


@cache
def found_parts() -> tuple[str, ...]:
    """Return the parts that are there, as names within the package."""
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
    """Return the names of parts that a package shows, with their modules.

    Parameters
    ----------
    package : str
        Name within ``ase_roughcontact``, such as ``"plot"``.

    Returns
    -------
    dict of str to str
        Whole names of the modules by the names.
    """
    found = {}
    for part in found_parts():
        shown = import_module(f"{_PACKAGE}.{part}").SHOWN
        for name, module in shown.get(package, {}).items():
            found[name] = f"{_PACKAGE}.{part}.{module}"
    return found


def import_shown(package: str, name: str) -> Any:
    """Return a name of a part that a package shows.

    Parameters
    ----------
    package, name : str
        See `shown_by`.

    Returns
    -------
    object

    Raises
    ------
    AttributeError
        If no part that is there has this name for the package.
    """
    modules = shown_by(package)
    if name not in modules:
        raise AttributeError(f"module '{_PACKAGE}.{package}' has no attribute {name!r}")
    return getattr(import_module(modules[name]), name)
