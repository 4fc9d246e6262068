"""Restart file of a path: its finished steps, and the state after the last one.

A path is resumed from this file alone. It has all numbers in double precision, and is
replaced when the new one is complete, after each step. In an archive of NumPy (.npz,
without pickled objects) are

- ``description``: the system, the kind of path and its settings, as JSON,
- ``steps``: for each step its prescribed quantities and its columns, as lines of JSON,
- ``last/...``: arrays of the state after the last step, and
- ``converged/...``: arrays of the state before the first step that did not converge, if
  there is such a step: steps are calculated again from there if other settings may let
  them converge.
"""

from __future__ import annotations

import json
import os
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
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
FORMAT = 1
# Names of the two places in the archive.
_LAST, _CONVERGED = "last", "converged"


class Place(NamedTuple):
    """End of a step, from which a path can be continued.

    Attributes
    ----------
    number : int
        Number of the step in the path, from zero.
    state : State
        State in which the step leaves the surface.
    position : dict
        Position of the step in its path, beyond its number.
    """

    number: int
    state: State
    position: dict[str, Any]


class FinishedStep(NamedTuple):
    """Step of a path in a restart file.

    Attributes
    ----------
    target : dict
        Quantities that the step prescribes.
    columns : dict
        Result of the step.
    """

    target: dict[str, Any]
    columns: dict[str, Any]


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
    last : Place or None
        End of the last step.
    converged : Place or None
        End of the last step before the first one that did not converge; None without.
    """

    system: dict[str, Any]
    path: dict[str, Any]
    settings: dict[str, Any]
    steps: tuple[FinishedStep, ...] = ()
    last: Place | None = None
    converged: Place | None = None

    @property
    def all_converged(self) -> bool:
        """Whether all steps have converged."""
        return all(step.columns["converged"] for step in self.steps)

    def records(self, record: type[LoadStep]) -> list[LoadStep]:
        """Return the results of the steps, of a class of results."""
        return [record.from_columns(step.columns) for step in self.steps]

    def until_converged(self) -> Restart:
        """Return the steps before the first one that did not converge."""
        if self.all_converged:
            return self
        count = self.converged.number + 1 if self.converged else 0
        return replace(
            self, steps=self.steps[:count], last=self.converged, converged=None
        )


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
    _places: dict[str, Place] = field(init=False)
    _all_converged: bool = field(init=False)

    def __post_init__(self) -> None:
        """Begin with the known steps."""
        self._lines = bytearray(b"".join(map(_line, self.restart.steps)))
        places = {_LAST: self.restart.last, _CONVERGED: self.restart.converged}
        self._places = {name: place for name, place in places.items() if place}
        self._all_converged = self.restart.all_converged

    def add(self, step: FinishedStep, place: Place) -> None:
        """Add a step, and replace the file.

        Raises
        ------
        OSError
            If the file can't be written.
        """
        if self._all_converged and not step.columns["converged"]:
            self._all_converged = False
            if _LAST in self._places:
                self._places[_CONVERGED] = self._places[_LAST]
        self._lines += _line(step)
        self._places[_LAST] = place
        # a folder that was removed meanwhile does not lose what was calculated
        Path(self.file).parent.mkdir(parents=True, exist_ok=True)
        with replaced(self.file) as name, open(name, "wb") as archive:
            np.savez(archive, **self._arrays())  # type: ignore[arg-type]

    def _arrays(self) -> dict[str, np.ndarray]:
        """Return the contents of the archive."""
        places, arrays = {}, dict[str, np.ndarray]()
        for name, place in self._places.items():
            numbers, values = _of_state(place.state)
            places[name] = place._asdict() | {"state": numbers}
            arrays |= {f"{name}/{key}": value for key, value in values.items()}
        description = {
            "format": FORMAT,
            "system": self.restart.system,
            "path": self.restart.path,
            "settings": self.restart.settings,
            "places": places,
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
                raise ValueError(f"{damaged} is not what was written")
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
        raise ValueError(f"there is no file {os.fspath(file)}: run the path first")
    return restart.records(record)


def _restart(
    description: Mapping[str, Any], arrays: Mapping[str, np.ndarray]
) -> Restart:
    """Return the contents of an archive."""
    places = {
        name: Place(
            place["number"],
            _state(place["state"], dict(_below(f"{name}/", arrays))),
            place["position"],
        )
        for name, place in description["places"].items()
    }
    lines = bytes(arrays["steps"]).splitlines()
    return Restart(
        description["system"],
        description["path"],
        description["settings"],
        tuple(FinishedStep(**json.loads(line)) for line in lines),
        places.get(_LAST),
        places.get(_CONVERGED),
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
