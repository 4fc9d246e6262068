"""Imports of packages from extras when they are needed."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from typing import Any


def imported(module: str, extra: str, need: str, instead: str = "") -> Any:
    """Return a module of an extra.

    Parameters
    ----------
    module : str
        Name of the module.
    extra : str
        Name of the extra that installs the module.
    need : str
        Reason for the import, such as ``"completion needs shtab"``.
    instead : str
        Other advice, which is appended to the error.

    Raises
    ------
    ImportError
        If the module is not installed. The error tells how to install it.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise ImportError(
            f"{need}: install the extra {extra}: pip install '.[{extra}]' in the "
            f"folder of the source code{instead}"
        ) from error


@contextmanager
def silenced() -> Iterator[None]:
    """Suppress warnings and log messages of a library; errors are still raised."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(before)
