"""Quasi-static load paths: one relaxed state after another, each written at once."""

from __future__ import annotations

import warnings
from collections.abc import Generator
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np
from ase import Atoms

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.validation import one_of
from ase_roughcontact.contact import State
from ase_roughcontact.paths.output import open_output
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.resume import PathDescription
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.paths.validity import ValidityReport
from ase_roughcontact.windows.regrid import GridChange, lost_text


class Frames(Protocol):
    """Makes the frames of a trajectory, and reads states from them."""

    def frame(self, stepper: Stepper, **info: Any) -> Atoms:
        """Return the frame of the last relaxed state."""
        ...

    def state(self, frame: Atoms) -> State:
        """Return the state of a frame."""
        ...


@dataclass(frozen=True)
class PathFiles:
    """Files of a path; see `load_path`.

    Attributes
    ----------
    trajectory, csv, keep, resume
        See `load_path`.
    frames : Frames, optional
        Needed for a trajectory.
    """

    trajectory: PathName | None = None
    csv: PathName | None = None
    keep: str = "all"
    resume: bool = False
    frames: Frames | None = None

    def __post_init__(self) -> None:
        """Check the options."""
        if self.resume and self.trajectory is None:
            raise ValueError("resume=True needs the trajectory to resume from")
        one_of(("all", "last"), keep=self.keep)


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
    files: PathFiles,
    validity: str = "warn",
    **description: Any,
) -> Generator[LoadStep, None, None]:
    """Relax a contact at one target after another, and write each step.

    Parameters
    ----------
    stepper : Stepper
    targets : ndarray, shape (steps,)
    files : PathFiles
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
    if files.trajectory is not None:
        system = stepper.describe_system(**description)
    path = PathDescription(system, stepper.control, targets)
    return _relaxed(stepper, path, files, report)


def _relaxed(
    stepper: Stepper, path: PathDescription, files: PathFiles, report: ValidityReport
) -> Generator[LoadStep, None, None]:
    """Yield the steps of a path, and write those that are not done yet."""
    first = 0
    with open_output(
        files.trajectory,
        files.csv,
        stepper.options.record,
        keep=files.keep,
        path=path if files.resume else None,
    ) as (finished, write):
        for step in finished.steps:
            report(step.step, step.validity)
            yield step
        if finished.frame and files.frames:
            first = finished.steps[-1].step + 1
            state = files.frames.state(finished.frame)
            stepper.restart_from(state, path.targets[first - 1])
        for number in range(first, len(path.targets)):
            step = stepper.step(number, path.targets[number])
            described = path.of_step(number)
            write(step, partial(frame_of, stepper, files.frames, step, path=described))
            report(number, step.validity)
            yield step


def frame_of(
    stepper: Stepper, frames: Frames | None, step: LoadStep, **info: Any
) -> Atoms:
    """Return the frame of a step for the trajectory."""
    if frames is None:
        raise ValueError("a trajectory needs frames: give PathFiles(frames=...)")
    return frames.frame(stepper, load_step=asdict(step), **info)
