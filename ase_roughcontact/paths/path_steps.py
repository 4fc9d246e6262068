"""Steps of a path of any kind: which come next, and what describes them in files.

Every frame carries a description of the path: the system, the control and the target.
A path is resumed from a file only if these agree; if not, the error lists what differs.
"""

from __future__ import annotations

import math
import os
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple, Protocol, TypeAlias

import numpy as np

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.identity import differences
from ase_roughcontact._util.validation import finite_array
from ase_roughcontact.contact import State
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.retraction import step_in_contact
from ase_roughcontact.paths.step import Stepper

# Relative difference of targets that counts as rounding, as between the common part of
# a path and of a longer one; near zero, relative to the neighbouring targets.
_ROUNDING = 1e-12


class Frame(Protocol):
    """State of a path in a file, with all that was written with it."""

    info: dict[str, Any]


class OtherPathError(ValueError):
    """A trajectory has the steps of another path or system."""


class LastStep(NamedTuple):
    """Last step of a path in a file: its result, its state, and what describes it."""

    step: Any
    state: State
    path: dict[str, Any]


#: Steps, each with the description that its frame carries.
DescribedSteps: TypeAlias = Iterator[tuple[Any, dict[str, Any]]]


@dataclass
class PathSteps(ABC):
    """Steps of a kind of path, which `output.follow` writes.

    Attributes
    ----------
    kind : type
        Class from which that of the results must be derived.
    stepper : Stepper
    record : type
        Class of the results.
    system : dict
        All that a state depends on except target and displacement; see
        `Stepper.describe_system`.
    """

    kind: ClassVar[type[LoadStep]] = LoadStep
    stepper: Stepper
    record: Any = field(default=LoadStep, init=False)
    system: dict[str, Any] = field(default_factory=dict, init=False)

    @abstractmethod
    def remaining(self, last: LastStep | None) -> DescribedSteps:
        """Yield the steps after the last one that is done, or all if none is."""

    @abstractmethod
    def differences(self, path: dict[str, Any], number: int) -> list[str]:
        """Return in what the description of a step differs from that of this path."""

    @property
    def parameters(self) -> dict[str, Any]:
        """What a state depends on beside the problem."""
        return {}

    def described(self, target: float, **more: Any) -> dict[str, Any]:
        """Return the description of a step at a target, and what is of its kind."""
        control = self.stepper.control
        return {"system": self.system, "control": control, "target": target} | more

    def finished_steps(
        self, frames: Iterable[Frame], file: PathName, keep: str
    ) -> tuple[list[LoadStep], Frame | None]:
        """Read the results of the steps in a trajectory, which must be of this path.

        Parameters
        ----------
        frames : iterable of Frame
        file : path
            From which they are read.
        keep : {"all", "last"}
            Frames that the trajectory keeps: with "last" it begins at any step.

        Returns
        -------
        steps : list of LoadStep
        frame : Frame or None
            Of the last step.

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
            steps.append(self.record.from_columns(frame.info["load_step"]))
        return steps, frame

    def _mismatch(self, info: dict[str, Any], expected: int | None) -> list[str]:
        """Return what keeps a frame from being the expected step of this path."""
        if not {"path", "load_step"} <= set(info):
            return ["its frames are not those of a load path"]
        path, number = info["path"], info["load_step"]["step"]
        if expected is not None and number != expected:
            return [f"it has step {number} in place of step {expected}"]
        if path["control"] != (control := self.stepper.control):
            return [f"its path is one of {path['control']}, this one of {control}"]
        return self.differences(path, number)


@dataclass
class NumberedSteps(PathSteps):
    """Steps at one target after another.

    Attributes
    ----------
    targets : ndarray, shape (steps,)
    """

    targets: np.ndarray

    def remaining(self, last: LastStep | None) -> DescribedSteps:
        """Relax the steps after the last one that is done; see `PathSteps`."""
        first = 0
        if last is not None:
            first = last.step.step + 1
            self.resume(last)
        for number in range(first, len(self.targets)):
            yield self.step(number), self.described_step(number)

    def resume(self, last: LastStep) -> None:
        """Continue after a step."""
        self.stepper.restart_from(last.state, self.targets[last.step.step])

    def step(self, number: int) -> LoadStep:
        """Relax a step."""
        return step_in_contact(self.stepper, number, self.targets[number], self.record)

    def described_step(self, number: int) -> dict[str, Any]:
        """Return the description that the frame of a step carries."""
        return self.described(self.targets[number])

    def differences(self, path: dict[str, Any], number: int) -> list[str]:
        """Return in what the description of a step differs; see `PathSteps`."""
        if number >= len(self.targets):
            count = len(self.targets)
            return [f"its path has {number + 1} steps or more, this one {count}"]
        found = differences(path["system"], self.system)
        if not self._same_target(path["target"], number):
            name, target = f"{self.stepper.control}[{number}]", self.targets[number]
            found.append(f"{name} was {path['target']}, is {target}")
        return found

    def _same_target(self, target: float, number: int) -> bool:
        neighbours = self.targets[max(number - 1, 0) : number + 2]
        rounding = _ROUNDING * float(np.ptp(neighbours))
        return math.isclose(
            target, self.targets[number], rel_tol=_ROUNDING, abs_tol=rounding
        )


def targets_of(control: str, path: Any) -> np.ndarray:
    """Return the targets of a path as an array.

    Raises
    ------
    ValueError
        If it is not a sequence of finite numbers.
    """
    with suppress(ValueError):
        targets = finite_array(control, path)
        if targets.ndim == 1 and targets.size:
            return targets
    raise ValueError(f"{control} must be a sequence of finite numbers, got {path}")
