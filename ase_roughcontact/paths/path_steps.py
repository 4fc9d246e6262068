"""Steps of a path of any kind: their order, and their description in files.

A restart file describes the path: the system, its kind, its control and its targets. A
path is resumed from it only if these agree; if not, the error lists the differences.
"""

from __future__ import annotations

import math
import os
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.identity import differences
from ase_roughcontact._util.rounding import ROUNDING
from ase_roughcontact._util.validation import finite_array, shown
from ase_roughcontact.contact import State
from ase_roughcontact.contact.control import Control
from ase_roughcontact.paths.restart import Restart
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.stepping.retraction import relax_in_contact
from ase_roughcontact.stepping.step import Stepper


class OtherPathError(ValueError):
    """A trajectory has the steps of another path or system."""


@dataclass(frozen=True)
class Position:
    """Position of a step in its path, beyond its number; a kind of path adds to it."""


@dataclass(frozen=True, eq=False)
class PathStep:
    """End of a step of a path, from which the next step starts; or start of the path.

    Attributes
    ----------
    record : LoadStep or None
        Result of the step; None at the start of the path.
    state : State
        State from which the next step starts.
    target : dict
        Quantities that the step prescribes; empty at the start of the path.
    position : Position
        Position of the step in its path, of the class `PathSteps.position`.
    """

    record: Any
    state: State
    target: dict[str, Any]
    position: Any

    @property
    def number(self) -> int:
        """Number of the step in the path, from zero; -1 at the start of the path."""
        return -1 if self.record is None else int(self.record.step)


@dataclass
class PathSteps(ABC):
    """Steps of a kind of path, which `follow` writes.

    Attributes
    ----------
    kind : type
        Class from which the class of the results must be derived.
    position : type
        Class of the positions of the steps, derived from `Position`.
    stepper : Stepper
    """

    kind: ClassVar[type[LoadStep]] = LoadStep
    position: ClassVar[type[Position]] = Position
    stepper: Stepper

    def start(self, state: State) -> PathStep:
        """Return the start of the path in a state of the surface."""
        return PathStep(None, state, {}, self.position())

    @abstractmethod
    def steps(
        self, last: PathStep, record: type[Any]
    ) -> Iterator[tuple[PathStep, RelaxedStep]]:
        """Relax the steps after the last one.

        Parameters
        ----------
        last : PathStep
            Last finished step, or the start of the path.
        record : type
            Class of the results.

        Yields
        ------
        step : PathStep
        left : RelaxedStep
            The step as it leaves the surface; see `Stepper.commit`.
        """

    @abstractmethod
    def differences(self, done: Restart) -> list[str]:
        """Return the differences of finished steps from the steps of this path."""

    @property
    def parameters(self) -> dict[str, Any]:
        """Values that the steps depend on beside the problem and the targets.

        A path is resumed only with equal values.
        """
        return {}

    @property
    def specification(self) -> dict[str, Any]:
        """Quantities that the path prescribes for all its steps."""
        return {}

    @property
    def described(self) -> dict[str, Any]:
        """Kind, control and specification of the path, as its restart file has them."""
        kind, control = type(self).__name__, self.stepper.control.name
        return {"kind": kind, "control": control} | self.specification

    def check(self, done: Restart, system: dict[str, Any], file: PathName) -> None:
        """Raise `OtherPathError` unless finished steps are the first ones of this path.

        Parameters
        ----------
        done : Restart
            Contents of the restart file.
        system : dict
            Description of the system of this path; see `Stepper.describe_system`.
        file : path
            File from which the steps are read.

        Raises
        ------
        OtherPathError
            If they differ; the message lists the differences.
        """
        mismatch = self._mismatch(done, system)
        if mismatch:
            raise OtherPathError(
                f"can't resume: {os.fspath(file)} holds steps of another path or "
                f"system: {'; '.join(mismatch)} (eV, Å): use the former "
                "parameters, delete the file, or give another file or folder"
            )

    def _mismatch(self, done: Restart, system: dict[str, Any]) -> list[str]:
        """Return the reasons why finished steps do not belong to this path."""
        for key in "control", "kind":
            old, new = done.path[key], self.described[key]
            if old != new:
                return [f"its path is one of {old}, this one of {new}"]
        old, new = _shared(done.system, system), _shared(system, done.system)
        return self.differences(done) + differences(old, new)


@dataclass
class NumberedSteps(PathSteps):
    """Steps at one target after another.

    Attributes
    ----------
    targets : ndarray, shape (steps,)
        Penetrations, heights, loads or other targets of the steps.
    """

    targets: np.ndarray

    def steps(
        self, last: PathStep, record: type[Any]
    ) -> Iterator[tuple[PathStep, RelaxedStep]]:
        """Relax the steps at the remaining targets; see `PathSteps`."""
        for number in range(last.number + 1, len(self.targets)):
            relaxed, history = self.relax(last, number)
            result, left = record.of(relaxed), self.stepper.commit(relaxed, **history)
            target, position = self.target(number), self.position()
            last = PathStep(result, left.state, target, position)
            yield last, left

    def relax(
        self, last: PathStep, number: int
    ) -> tuple[RelaxedStep, dict[str, np.ndarray]]:
        """Relax a step, and return it with the history that the surface keeps.

        Parameters
        ----------
        last : PathStep
            The step before, or the start of the path.
        number : int
            Number of the step, from zero.

        Returns
        -------
        relaxed : RelaxedStep
        history : dict of ndarray, shape (n, m)
            Entries of `State.history` beyond the plastic depth.
        """
        target = self.targets[number]
        return relax_in_contact(self.stepper, last.state, target, number), {}

    def target(self, number: int) -> dict[str, Any]:
        """Return the quantities that a step prescribes."""
        return {"target": float(self.targets[number])}

    def differences(self, done: Restart) -> list[str]:
        """Return the differences of the finished steps; see `PathSteps`."""
        count = len(self.targets)
        for number, step in enumerate(done.steps):
            if number >= count:
                return [f"its path has {number + 1} steps or more, this one {count}"]
            if found := self.change_of_target(step.target, number):
                return [found]
        return []

    def change_of_target(self, old: dict[str, Any], number: int) -> str:
        """Return the difference of a step's target from an old one; empty if none."""
        if self._same_target(old["target"], number):
            return ""
        name, target = f"{self.stepper.control.plural}[{number}]", self.targets[number]
        return f"{name} was {old['target']}, is {target}"

    def _same_target(self, target: float, number: int) -> bool:
        neighbours = self.targets[max(number - 1, 0) : number + 2]
        rounding = ROUNDING * float(np.ptp(neighbours))
        return math.isclose(
            target, self.targets[number], rel_tol=ROUNDING, abs_tol=rounding
        )


def targets_of(control: Control, path: Any) -> np.ndarray:
    """Return the targets of a path as an array; one number is a path of one step.

    Raises
    ------
    ValueError
        If it is neither a finite number nor a sequence of them.
    """
    with suppress(ValueError):
        targets = np.atleast_1d(finite_array(control.plural, path))
        if targets.ndim == 1 and targets.size:
            return targets
    raise ValueError(
        f"{control.plural} must be a finite number or a sequence of them, in units of "
        f"ASE (Å, eV), got {shown(path)}"
    )


def _shared(system: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Return the description of a system without a Poisson's ratio that another lacks.

    An isotropic solid needs the ratio only for friction, which can't do without, and
    for stresses below the surface: the contact is the same with and without it.
    """
    found = {}
    for key, value in system.items():
        counterpart = other.get(key)
        if isinstance(value, dict) and isinstance(counterpart, dict):
            found[key] = _shared(value, counterpart)
        elif key != "poisson" or key in other:
            found[key] = value
    return found
