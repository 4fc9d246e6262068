"""Resuming a path: which frames of a trajectory are its first steps.

Every frame carries a description of the path: the system, the control and the target.
A path is resumed from a file only if these agree; if not, the error lists what differs.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.identity import differences, digest
from ase_roughcontact.contact import Problem
from ase_roughcontact.paths.record import LoadStep

# Relative difference of targets that counts as rounding, as between the common part of
# a path and of a longer one; near zero, relative to the neighbouring targets.
_ROUNDING = 1e-12


class Frame(Protocol):
    """State of a path in a file, with all that was written with it."""

    info: dict[str, Any]


class OtherPathError(ValueError):
    """A trajectory has the steps of another path or system."""


@dataclass(frozen=True)
class FinishedSteps:
    """First steps of a path, read from its trajectory.

    Attributes
    ----------
    steps : list of LoadStep
    frame : Frame or None
        Of the last step.
    """

    steps: list[LoadStep] = field(default_factory=list)
    frame: Frame | None = None


@dataclass(frozen=True)
class PathDescription:
    """Parameters of a path as written to every frame of its trajectory.

    Attributes
    ----------
    system : dict
        All that a state depends on except target and displacement; see
        `describe_system`.
    control : {"penetrations", "heights", "loads"}
    targets : ndarray, shape (steps,)
    """

    system: dict[str, Any]
    control: str
    targets: np.ndarray

    def of_step(self, number: int) -> dict[str, Any]:
        """Return the description that the frame of a step carries."""
        return self.of_target(self.targets[number])

    def of_target(self, target: float, **more: Any) -> dict[str, Any]:
        """Return the description of a step at a target, and what is of its kind."""
        path = {"system": self.system, "control": self.control, "target": target}
        return path | more

    def finished_steps(
        self,
        frames: Iterable[Frame],
        file: PathName,
        keep: str,
        record: type[LoadStep],
    ) -> FinishedSteps:
        """Read the results of the steps in a trajectory, which must be of this path.

        Parameters
        ----------
        frames : iterable of Frame
        file : path
            From which they are read.
        keep : {"all", "last"}
            Frames that the trajectory keeps: with "last" it begins at any step.
        record : type
            Class of the results.

        Returns
        -------
        FinishedSteps

        Raises
        ------
        OtherPathError
            If the frames are of another path, with what differs.
        ValueError
            If a frame is damaged.
        """
        steps, frame = list[LoadStep](), None
        for frame in frames:
            expected = steps[-1].step + 1 if steps else None if keep == "last" else 0
            mismatch = self._mismatch(frame.info, expected)
            if mismatch:
                raise OtherPathError(
                    f"can't resume: {os.fspath(file)} holds steps of another path or "
                    f"system: {'; '.join(mismatch)} (eV, Å): use the former "
                    "parameters, delete the file, or give another file or folder"
                )
            steps.append(record.from_columns(frame.info["load_step"]))
        return FinishedSteps(steps, frame)

    def _mismatch(self, info: dict[str, Any], expected: int | None) -> list[str]:
        """Return what keeps a frame from being the expected step of this path."""
        if not {"path", "load_step"} <= set(info):
            return ["its frames are not those of a load path"]
        path, number = info["path"], info["load_step"]["step"]
        if expected is not None and number != expected:
            return [f"it has step {number} in place of step {expected}"]
        if path["control"] != self.control:
            return [f"its path is one of {path['control']}, this one of {self.control}"]
        return self._differences(path, number)

    def _differences(self, path: dict[str, Any], number: int) -> list[str]:
        """Return in what the description of a step differs."""
        if number >= len(self.targets):
            count = len(self.targets)
            return [f"its path has {number + 1} steps or more, this one {count}"]
        found = differences(path["system"], self.system)
        if not self._same_target(path["target"], number):
            name = f"{self.control}[{number}]"
            found.append(f"{name} was {path['target']}, is {self.targets[number]}")
        return found

    def _same_target(self, target: float, number: int) -> bool:
        neighbours = self.targets[max(number - 1, 0) : number + 2]
        rounding = _ROUNDING * float(np.ptp(neighbours))
        return math.isclose(
            target, self.targets[number], rel_tol=_ROUNDING, abs_tol=rounding
        )


def describe_system(problem: Problem, **more: Any) -> dict[str, Any]:
    """Describe all that a relaxed state depends on except height, load, displacement.

    Parameters
    ----------
    problem : Problem
    **more
        Of the path: its lattice, its tolerance and springs.

    Returns
    -------
    dict
        Numbers, strings, lists and dicts as a JSON file returns them.

    Raises
    ------
    ValueError
        If something can't be described, such as an indenter without `todict`.
    """
    return json.loads(json.dumps(problem.todict() | more, default=_encode))


def _encode(value: Any) -> Any:
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return digest(value.tobytes())
    raise ValueError(
        "a trajectory needs a description of the system, but "
        f"{type(value).__name__} has none: give it a method todict that returns its "
        "name and parameters, or leave the trajectory out"
    )
