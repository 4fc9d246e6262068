"""Warnings at the line of the code that uses the package."""

from __future__ import annotations

import sys
import warnings

# Beginnings of the names of modules that are skipped: ASE calls the package, and the
# package calls ASE.
_SKIPPED = "ase_roughcontact.", "ase."


def warn(message: str, category: type[Warning] = UserWarning) -> None:
    """Issue a warning at the line of the code that uses the package."""
    frame, level = sys._getframe(1), 2
    while frame.f_back and frame.f_globals["__name__"].startswith(_SKIPPED):
        frame, level = frame.f_back, level + 1
    warnings.warn(message, category, stacklevel=level)
