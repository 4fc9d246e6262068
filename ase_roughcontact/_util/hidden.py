"""Imports without an optional package that another package would load."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.abc import MetaPathFinder
from threading import get_ident


@contextmanager
def hidden(name: str) -> Iterator[None]:
    """Let imports of a package fail as if it were not installed, if it is not loaded.

    Imports by other threads do not fail.

    Parameters
    ----------
    name : str
        Name of the package.
    """
    finder = _Absent(name)
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)


class _Absent(MetaPathFinder):
    """Finder by which one package is not found in the thread that has made it."""

    def __init__(self, package: str) -> None:
        self._package, self._thread = package, get_ident()

    def find_spec(self, fullname: str, *_: object) -> None:
        """Raise an error for the package; leave other imports to other finders."""
        if fullname == self._package and get_ident() == self._thread:
            raise ModuleNotFoundError(f"No module named {fullname!r}", name=fullname)
