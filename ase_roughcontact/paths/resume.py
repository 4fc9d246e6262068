"""Resuming a path: the system of its frames, and what is read from them."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from ase_roughcontact._util.identity import digest
from ase_roughcontact.contact import Problem
from ase_roughcontact.paths.record import LoadStep


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
