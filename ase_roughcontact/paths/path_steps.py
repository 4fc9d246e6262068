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
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.identity import differences
from ase_roughcontact._util.validation import finite_array
from ase_roughcontact.contact import State
from ase_roughcontact.contact.control import Control
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.stepping.retraction import relax_in_contact
from ase_roughcontact.stepping.step import Stepper

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


class PathStep(NamedTuple):
    """Step of a path that was relaxed.

    Attributes
    ----------
    record : LoadStep
        Result of the step.
    left : RelaxedStep
        The step as it leaves the surface; see `Stepper.commit`.
    path : dict
        What the step prescribes, and where in its path it is, as its frame carries it.
    """

    record: Any
    left: RelaxedStep
    path: dict[str, Any]


@dataclass
class PathSteps(ABC):
    """Steps of a kind of path, which `output.follow` writes.

    Attributes
    ----------
    kind : type
        Class from which the class of the results must be derived.
    stepper : Stepper
    """

    kind: ClassVar[type[LoadStep]] = LoadStep
    stepper: Stepper

    @abstractmethod
    def steps(
        self, start: State, record: type[Any], last: LastStep | None = None
    ) -> Iterator[PathStep]:
        """Yield the steps of the path.

        Parameters
        ----------
        start : State
            State from which the first step starts.
        record : type
            Class of the results.
        last : LastStep, optional
            Last step that is done: those after it are relaxed.

        Yields
        ------
        PathStep
        """

    @abstractmethod
    def differences(self, path: dict[str, Any], number: int) -> list[str]:
        """Return in what the description of a step differs from that of this path."""

    @property
    def parameters(self) -> dict[str, Any]:
        """What a state depends on beside the problem."""
        return {}

    def finished_steps(
        self,
        frames: Iterable[Frame],
        record: type[LoadStep],
        system: dict[str, Any],
        file: PathName,
        keep: str,
    ) -> tuple[list[LoadStep], Frame | None]:
        """Read the results of the steps in a trajectory, which must be of this path.

        Parameters
        ----------
        frames : iterable of Frame
        record : type
            Class of the results.
        system : dict
            Description of the system of this path; see `Stepper.describe_system`.
        file : path
            File from which the frames are read.
        keep : {"all", "last"}
            Frames that the trajectory keeps: with "last" it begins at any step.

        Returns
        -------
        steps : list of LoadStep
        frame : Frame or None
            Frame of the last step.

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
            mismatch = self._mismatch(frame.info, expected, system)
            if mismatch:
                raise OtherPathError(
                    f"can't resume: {os.fspath(file)} holds steps of another path or "
                    f"system: {'; '.join(mismatch)} (eV, Å): use the former "
                    "parameters, delete the file, or give another file or folder"
                )
            steps.append(record.from_columns(frame.info["load_step"]))
        return steps, frame

    def _mismatch(
        self, info: dict[str, Any], expected: int | None, system: dict[str, Any]
    ) -> list[str]:
        """Return what keeps a frame from being the expected step of this path."""
        if not {"path", "load_step"} <= set(info):
            return ["its frames are not those of a load path"]
        path, number = info["path"], info["load_step"]["step"]
        if "mean_force" not in path:
            return ["its frames are of an earlier version"]
        if expected is not None and number != expected:
            return [f"it has step {number} in place of step {expected}"]
        if path["control"] != (control := self.stepper.control.name):
            return [f"its path is one of a {path['control']}, this one of a {control}"]
        return self.differences(path, number) + differences(path["system"], system)


@dataclass
class NumberedSteps(PathSteps):
    """Steps at one target after another.

    Attributes
    ----------
    targets : ndarray, shape (steps,)
    """

    targets: np.ndarray

    def steps(
        self, start: State, record: type[Any], last: LastStep | None = None
    ) -> Iterator[PathStep]:
        """Relax the steps after the last one that is done; see `PathSteps`."""
        first, state, previous = 0, start, None
        if last is not None:
            first, state, previous = last.step.step + 1, last.state, last.step
        for number in range(first, len(self.targets)):
            relaxed, history = self.relax(state, number, previous)
            previous, left = record.of(relaxed), self.stepper.commit(relaxed, **history)
            state = left.state
            yield PathStep(previous, left, self.described(number))

    def relax(
        self, state: State, number: int, previous: Any
    ) -> tuple[RelaxedStep, dict[str, np.ndarray]]:
        """Relax a step, and return it with what the surface keeps of it.

        Parameters
        ----------
        state : State
        number : int
        previous : LoadStep or None
            Result of the step before, None without one.

        Returns
        -------
        relaxed : RelaxedStep
        history : dict of ndarray, shape (n, m)
            Entries of `State.history` beyond those of any path.
        """
        target = self.targets[number]
        return relax_in_contact(self.stepper, state, target, number), {}

    def described(self, number: int) -> dict[str, Any]:
        """Return the description that the frame of a step carries."""
        return {"target": self.targets[number]}

    def differences(self, path: dict[str, Any], number: int) -> list[str]:
        """Return in what the description of a step differs; see `PathSteps`."""
        if number >= len(self.targets):
            count = len(self.targets)
            return [f"its path has {number + 1} steps or more, this one {count}"]
        if self._same_target(path["target"], number):
            return []
        name, target = f"{self.stepper.control.plural}[{number}]", self.targets[number]
        return [f"{name} was {path['target']}, is {target}"]

    def _same_target(self, target: float, number: int) -> bool:
        neighbours = self.targets[max(number - 1, 0) : number + 2]
        rounding = _ROUNDING * float(np.ptp(neighbours))
        return math.isclose(
            target, self.targets[number], rel_tol=_ROUNDING, abs_tol=rounding
        )


def targets_of(control: Control, path: Any) -> np.ndarray:
    """Return the targets of a path as an array.

    Raises
    ------
    ValueError
        If it is not a sequence of finite numbers.
    """
    with suppress(ValueError):
        targets = finite_array(control.plural, path)
        if targets.ndim == 1 and targets.size:
            return targets
    raise ValueError(
        f"{control.plural} must be a sequence of finite numbers, got {path}"
    )
