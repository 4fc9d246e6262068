"""Columns of steps, which functions for figures take in place of arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeGuard

import numpy as np

from ase_roughcontact.results.record import LoadStep


def is_steps(values: Any) -> TypeGuard[Sequence[LoadStep]]:
    """Return whether values are steps, and not an array."""
    if not isinstance(values, Sequence) or not values:
        return False
    return all(isinstance(each, LoadStep) for each in values)


def column_of_steps(steps: Sequence[LoadStep], name: str) -> np.ndarray:
    """Return a column of steps, in units of ASE."""
    return np.array([getattr(step, name) for step in steps])
