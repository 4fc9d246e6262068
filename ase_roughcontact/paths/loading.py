"""Quasi-static load paths: one relaxed state after another, each written at once."""

from __future__ import annotations

import warnings
from collections.abc import Generator
from typing import Any

import numpy as np

from ase_roughcontact.paths.output import Output, open_output
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
    report = ValidityReport(validity)
    system = {}
    if output.trajectory is not None:
        system = stepper.describe_system(**description)
    path = PathDescription(system, stepper.control, targets)
    return _relaxed(stepper, path, output, report)


def _relaxed(
    stepper: Stepper, path: PathDescription, output: Output, report: ValidityReport
) -> Generator[LoadStep, None, None]:
    """Yield the steps of a path, and write those that are not done yet."""
    first = 0
    resumed = path if output.resume else None
    with open_output(output, stepper, resumed) as (finished, write):
        for step in finished.steps:
            report(step.step, step.validity)
            yield step
        if finished.frame and output.frames:
            first = finished.steps[-1].step + 1
            state = output.frames.state(finished.frame)
            stepper.restart_from(state, path.targets[first - 1])
        for number in range(first, len(path.targets)):
            step = stepper.step(number, path.targets[number], output.record)
            write(step, path=path.of_step(number))
            report(number, step.validity)
            yield step
