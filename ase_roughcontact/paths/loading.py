"""Quasi-static load paths: one relaxed state after another, each written at once."""

from __future__ import annotations

import warnings
from collections.abc import Generator
from typing import Any

import numpy as np

from ase_roughcontact.paths.output import Output, follow
from ase_roughcontact.paths.path_steps import NumberedSteps
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.windows.regrid import GridChange, lost_text


def targets_of(control: str, path: Any) -> np.ndarray:
    """Return the targets of a path as an array.

    Raises
    ------
    ValueError
        If it is not a sequence of finite numbers.
    """
    try:
        targets = np.asarray(path, dtype=float)
    except (TypeError, ValueError, OverflowError):
        targets = np.array(np.nan)
    if targets.ndim != 1 or targets.size == 0 or not np.isfinite(targets).all():
        raise ValueError(f"{control} must be a sequence of finite numbers, got {path}")
    return targets


def warn_of_lost_slope(
    stepper: Stepper, change: GridChange | None, validity: str
) -> None:
    """Warn of waves that a coarser grid can't resolve, unless limits are ignored."""
    lost = stepper.options.lost_slope
    if change and lost and validity != "ignore":
        warnings.warn(lost_text(change, lost), stacklevel=3)


def follow_path(
    stepper: Stepper,
    targets: np.ndarray,
    output: Output,
    validity: str = "warn",
    **description: Any,
) -> Generator[LoadStep, None, None]:
    """Relax a contact at one target after another, and write each step.

    Parameters
    ----------
    stepper : Stepper
    targets : ndarray, shape (steps,)
    output : Output
    validity : {"warn", "raise", "ignore"}
        See `load_path`.
    **description
        What a state depends on beside the problem, such as springs.

    Returns
    -------
    generator of LoadStep
        Files are read and written as it advances.
    """
    return follow(NumberedSteps(stepper, targets), output, validity, **description)
