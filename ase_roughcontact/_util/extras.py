"""Packages of extras, which are imported when they are needed."""

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
    extra : str
        Name of the extra that installs it.
    need : str
        What needs it, such as ``"completion needs shtab"``.
    instead : str
        What else helps.

    Raises
    ------
    ImportError
        If it is not installed, with how to install it.
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
    """Keep what a library warns of and logs off the terminal; errors are raised."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        logging.disable(before)
