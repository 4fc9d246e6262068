"""Quasi-static load paths: one relaxed state after another, each written at once."""

from __future__ import annotations

import warnings
from collections.abc import Generator, Iterator
from functools import partial
from typing import Any

import numpy as np

from ase_roughcontact.paths.output import Output, written
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.resume import PathDescription
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.paths.validity import ValidityReport
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
    report, system = ValidityReport(validity), output.system(stepper, **description)
    path = PathDescription(system, stepper.control, targets)
    remaining = partial(_remaining, stepper, path, output.record)
    return written(stepper, path, output, report, remaining)


def _remaining(
    stepper: Stepper, path: PathDescription, record: type[LoadStep], last: Any
) -> Iterator[tuple[LoadStep, dict[str, Any]]]:
    """Relax the steps after the last one that is done, a `LastStep`."""
    first = 0
    if last is not None:
        first = last.step.step + 1
        stepper.restart_from(last.state, path.targets[first - 1])
    for number in range(first, len(path.targets)):
        step = stepper.step(number, path.targets[number], record)
        yield step, path.of_step(number)
