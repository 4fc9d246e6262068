"""Restart file of a path: its finished steps, and the state after the last one.

A path is resumed from this file alone. It has all numbers in double precision, and is
replaced when the new one is complete, after each step. In an archive of NumPy (.npz,
without pickled objects) are

- ``description``: the system, the kind of path and its settings, as JSON,
- ``steps``: for each step its prescribed quantities, its columns and its position in
  the path, as lines of JSON, and
- ``12/...``: arrays of the state after 12 steps. There is one after the last step; one
  before the first step that did not converge, if there is such a step: steps are
  calculated again from there if other settings may let them converge; and one at the
  start of the path, without pressure, if the surface has a history there.
"""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ase_roughcontact._util.files import PathName, replaced
from ase_roughcontact.contact import State
from ase_roughcontact.contact.history import entry_of
from ase_roughcontact.contact.state import EarlierState
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.results.record import LoadStep

#: Version of the format.
FORMAT = 2


class FinishedStep(NamedTuple):
    """Step of a path as a restart file keeps it.

    Attributes
    ----------
    target : dict
        Quantities that the step prescribes.
    columns : dict
        Result of the step.
    position : dict
        Position of the step in its path, beyond its number.
    """

    target: dict[str, Any]
    columns: dict[str, Any]
    position: dict[str, Any]


@dataclass(frozen=True)
class Restart:
    """Contents of a restart file.

    Attributes
    ----------
    system : dict
        Description of the parameters of a state; see `Stepper.describe_system`.
    path : dict
        Kind of the path, its control, and parameters of all its steps.
    settings : dict
        Settings of results beside the state; see `Stepper.describe_settings`.
    steps : tuple of FinishedStep
        Finished steps, in order.
    states : dict of int to State
        State after all steps, after all before the first that did not converge, and at
        the start if the surface has a history there; by the number of these steps.
    """

    system: dict[str, Any]
    path: dict[str, Any]
    settings: dict[str, Any]
    steps: tuple[FinishedStep, ...] = ()
    states: Mapping[int, State] = field(default_factory=dict)

    @property
    def converged(self) -> int:
        """Number of steps before the first one that did not converge."""
        found = (step.columns["converged"] for step in self.steps)
        return sum(1 for _ in takewhile(bool, found))

    def records(self, record: type[LoadStep]) -> list[LoadStep]:
        """Return the results of the steps, of a class of results."""
        return [record.from_columns(step.columns) for step in self.steps]

    def until_converged(self) -> Restart:
        """Return the steps before the first one that did not converge."""
        kept = 0, self.converged
        states = {n: each for n, each in self.states.items() if n in kept}
        return replace(self, steps=self.steps[: self.converged], states=states)


@dataclass
class RestartWriter:
    """Adds steps to a restart file, which is replaced by a complete one each time.

    Attributes
    ----------
    file : path
    restart : Restart
        Steps that are known from an earlier run, and descriptions of the path.
    """

    file: PathName
    restart: Restart
    _lines: bytearray = field(init=False)
    _count: int = field(init=False)
    _converged: int = field(init=False)
    _states: dict[int, State] = field(init=False)

    def __post_init__(self) -> None:
        """Begin with the known steps."""
        self._lines = bytearray(b"".join(map(_line, self.restart.steps)))
        self._count, self._converged = len(self.restart.steps), self.restart.converged
        self._states = dict(self.restart.states)

    def add(self, step: FinishedStep, state: State) -> None:
        """Add a step and the state after it, and replace the file.

        Raises
        ------
        OSError
            If the file can't be written.
        """
        if self._converged == self._count and step.columns["converged"]:
            self._converged += 1
        self._count += 1
        self._lines += _line(step)
        self._states[self._count] = state
        kept = 0, self._converged, self._count
        self._states = {n: each for n, each in self._states.items() if n in kept}
        # a folder that was removed meanwhile does not lose what was calculated
        Path(self.file).parent.mkdir(parents=True, exist_ok=True)
        with replaced(self.file) as name, open(name, "wb") as archive:
            np.savez(archive, **self._arrays())  # type: ignore[arg-type]

    def _arrays(self) -> dict[str, np.ndarray]:
        """Return the contents of the archive."""
        states, arrays = {}, dict[str, np.ndarray]()
        for count, state in self._states.items():
            states[count], values = _of_state(state)
            arrays |= {f"{count}/{key}": value for key, value in values.items()}
        description = {
            "format": FORMAT,
            "system": self.restart.system,
            "path": self.restart.path,
            "settings": self.restart.settings,
            "states": states,
        }
        text = json.dumps(description, default=_number).encode()
        return {
            "description": np.frombuffer(text, np.uint8),
            "steps": np.frombuffer(bytes(self._lines), np.uint8),
            **arrays,
        }


def restart_file(trajectory: PathName) -> Path:
    """Return the name of the restart file beside a trajectory."""
    return Path(trajectory).with_suffix(".restart.npz")


def read_restart(file: PathName) -> Restart | None:
    """Read a restart file.

    Parameters
    ----------
    file : path

    Returns
    -------
    Restart or None
        None if there is no file.

    Raises
    ------
    ValueError
        If the file is damaged, or of another version of the format.
    """
    if not Path(file).exists():
        return None
    try:
        with zipfile.ZipFile(file) as archive:
            if (damaged := archive.testzip()) is not None:
                raise ValueError(f"{damaged} has a wrong checksum")
        with np.load(file, allow_pickle=False) as archive:
            arrays = dict(archive.items())
        description = json.loads(bytes(arrays.pop("description")))
        if description["format"] == FORMAT:
            return _restart(description, arrays)
    except Exception as error:  # of any kind: a damaged file can contain anything
        raise ValueError(
            f"{os.fspath(file)} is damaged, or no restart file ({error}): restore a "
            "copy, delete it to begin again, or give another file or folder"
        ) from error
    raise ValueError(
        f"{os.fspath(file)} has the format {description['format']}, this version reads "
        f"{FORMAT}: use the version that wrote it, or delete it to begin again"
    )


def read_steps(file: PathName, record: type[LoadStep] = LoadStep) -> list[LoadStep]:
    """Read the results of the finished steps of a path.

    Parameters
    ----------
    file : path
        Restart file.
    record : type
        Class of the results; see `LoadStep.from_columns`.

    Returns
    -------
    list of LoadStep

    Raises
    ------
    ValueError
        If there is no file, or it is damaged.
    """
    restart = read_restart(file)
    if restart is None:
        raise ValueError(
            f"there is no file {os.fspath(file)}, as no step is finished: run the path"
        )
    return restart.records(record)


def _restart(
    description: Mapping[str, Any], arrays: Mapping[str, np.ndarray]
) -> Restart:
    """Return the contents of an archive."""
    states = {
        int(count): _state(numbers, dict(_below(f"{count}/", arrays)))
        for count, numbers in description["states"].items()
    }
    lines = bytes(arrays["steps"]).splitlines()
    return Restart(
        description["system"],
        description["path"],
        description["settings"],
        tuple(FinishedStep(**json.loads(line)) for line in lines),
        states,
    )


def _of_state(state: State) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return the numbers and the arrays of a state."""
    numbers = {
        "window": asdict(state.window),
        "height": state.height,
        "mean_force": state.mean_force,
        "creep": None if state.creep is None else state.creep.todict(),
        "earlier": [
            {"target": e.target, "window": asdict(e.window), "height": e.height}
            for e in state.earlier
        ],
    }
    arrays = {"pressure": state.pressure}
    if state.displacement is not None:
        arrays["displacement"] = state.displacement
    for number, each in enumerate(state.earlier):
        arrays[f"earlier/{number}"] = each.pressure
    for name, values in state.history.items():
        arrays[f"history/{name}"] = values
    for name, values in state.depths.items():
        arrays[f"depths/{name}"] = values
    return numbers, arrays


def _state(numbers: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> State:
    """Return the state of numbers and arrays."""
    earlier = tuple(
        EarlierState(
            each["target"],
            _box(each["window"]),
            arrays[f"earlier/{number}"],
            each["height"],
        )
        for number, each in enumerate(numbers["earlier"])
    )
    creep, history = numbers["creep"], dict(_below("history/", arrays))
    for name in history:
        entry_of(name)  # raises unless it is registered
    return State(
        _box(numbers["window"]),
        numbers["height"],
        arrays["pressure"],
        arrays.get("displacement"),
        history,
        dict(_below("depths/", arrays)),
        None if creep is None else Creep(**creep),
        earlier,
        numbers["mean_force"],
    )


def _box(numbers: Mapping[str, Any]) -> Box:
    return Box(tuple(numbers["start"]), tuple(numbers["shape"]))


def _below(
    prefix: str, arrays: Mapping[str, np.ndarray]
) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the arrays with names that begin with a prefix, which is left out."""
    for name, values in arrays.items():
        if name.startswith(prefix):
            yield name.removeprefix(prefix), values


def _line(step: FinishedStep) -> bytes:
    return json.dumps(step._asdict(), default=_number).encode() + b"\n"


def _number(value: Any) -> Any:
    """Return a number or an array of NumPy as types of JSON."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    raise ValueError(f"a restart file can't keep a {type(value).__name__}: {value!r}")
