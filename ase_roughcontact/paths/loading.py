"""Quasi-static load paths: one relaxed state after the other, each written at once."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact.atoms.build import snapshot
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.paths.trajectory import Frames, PathName, keeper

# Difference of targets that is rounding, which a path that was made longer has: of a
# target or, near zero, of the distance of its neighbours.
_SAME_TARGET = 1e-12


def load_path(
    atoms: Atoms,
    penetrations: Sequence[float] | None = None,
    optimizer: Callable[..., Any] | None = None,
    fmax: float | None = None,
    trajectory: PathName | None = None,
    csv: PathName | None = None,
    *,
    heights: Sequence[float] | None = None,
    loads: Sequence[float] | None = None,
    accuracy: str | float = "normal",
    max_steps: int = 10_000,
    window: str = "fixed",
    edge: str = "raise",
    keep: str = "all",
    resume: bool = False,
) -> Iterator[LoadStep]:
    """Relax the atoms at one load after the other.

    Parameters
    ----------
    atoms : Atoms
        From `substrate`, with a `RoughContact` calculator. They are moved.
    penetrations, heights, loads : sequence of float
        The path, exactly one of: distances that the indenter has come down since it
        first repels the flat substrate (Å), heights of the indenter (Å), or loads on
        it (eV/Å). The first two need an indenter that is fixed, loads one that is free.
    optimizer : callable, optional
        Called as ``optimizer(atoms, logfile=None)``; returns an ASE optimizer. A class,
        or a `functools.partial` of one with its options. By default `NewtonKrylov`,
        or `ActiveSet` where the wall is hard.
    fmax : float, optional
        Tolerance of the force on every atom (eV/Å), instead of `accuracy`.
    trajectory : path, optional
        File of an ASE trajectory of snapshots, one per step.
    csv : path, optional
        File of a table of the records, one line per step. If the path goes on, the
        lines of steps before those in the trajectory stay.
    accuracy : {"fast", "normal", "high"} or float
        Relative error that is allowed in force and area, see `Accuracy`; it sets a
        tolerance relative to the mean force on the atoms in contact, which fits loads
        of any size. "high" takes 1.2 to 1.5 times as long as "fast".
    max_steps : int
        Steps of the optimizer at most, each time that it is started: a window that
        grows, or a tolerance that turns out too large, starts it again.
    window : {"fixed", "auto"}
        Keep the window of the atoms, or, on a free half space, exchange it in place for
        one that holds all atoms that can touch at the step, and few others. That needs
        an indenter that rises out of reach, such as `RoughSphere`.
    edge : {"raise", "ignore"}
        What to do when the wall acts on an atom at the edge of a fixed free window: the
        atoms beyond it, which can't touch, would have touched, unless the indenter ends
        there, as a flat punch does.
    keep : {"all", "last"}
        Frames that the trajectory keeps. The last one is enough to go on from.
    resume : bool
        Go on from the steps that `trajectory` holds already: they are yielded again and
        not calculated again. The path may have got more steps at its end. Of the frames
        only the last one is read into memory.

    Yields
    ------
    LoadStep
        As soon as it is known, and written. A step that does not converge is yielded
        and written too, marked.

    Raises
    ------
    ValueError
        If not exactly one path is given, it is empty or not finite, the indenter's
        constraint does not fit it, `resume` finds another path (told with what differs)
        or a file without a frame, or there is a trajectory and the indenter has no
        `todict` to be told by. With automatic windows, if the indenter does
        not rise out of reach, or atoms could touch at which its roughness is not known.
    RuntimeError
        If the contact has come to the edge of a fixed window, or another run is writing
        `trajectory`, or has written it since it was read.
    MemoryError
        If an automatic window does not fit into the memory that is free.
    OSError
        If a file can't be written.
    """
    if resume and trajectory is None:
        raise ValueError("resume needs the trajectory to go on from")
    control, targets = _one_path(
        penetrations=penetrations, heights=heights, loads=loads
    )
    if keep not in ("all", "last"):
        raise ValueError(f"keep must be 'all' or 'last', got {keep!r}")
    stepper = Stepper(
        atoms,
        control,
        optimizer,
        fmax=fmax,
        accuracy=accuracy,
        max_steps=max_steps,
        window=window,
        edge=edge,
    )
    system = {} if trajectory is None else stepper.system()
    path = _Path(stepper, system, targets)
    frames = Frames(trajectory, keep)
    return _steps(path, frames, csv, _done(path, frames) if resume else None)


@dataclass(frozen=True)
class _Path:
    """The targets of a path, and what goes along it."""

    stepper: Stepper
    system: dict[str, Any]
    targets: np.ndarray

    def mark(self, number: int) -> dict[str, Any]:
        """Tell a step's place on the path from all others."""
        return {
            "system": self.system,
            "control": self.stepper.control,
            "target": self.targets[number],
        }

    def step(self, number: int) -> LoadStep:
        """Relax the atoms at a step."""
        return self.stepper.step(number, self.targets[number])

    def frame(self, record: LoadStep) -> Atoms:
        """Return what is kept of the atoms, from which the path goes on."""
        mark = self.mark(record.step)
        return snapshot(self.stepper.atoms, load_step=asdict(record), path=mark)


def _steps(
    path: _Path, frames: Frames, table: PathName | None, done: list[LoadStep] | None
) -> Iterator[LoadStep]:
    with ExitStack() as files:
        keep = keeper(files, frames, table, done)
        first = 0
        if done:
            yield from done
            path.stepper.proceed_from(frames.frame(len(done) - 1))
            first = done[-1].step + 1
        for number in range(first, len(path.targets)):
            record = path.step(number)
            keep(record, partial(path.frame, record))
            yield record


def _one_path(**paths: Sequence[float] | None) -> tuple[str, np.ndarray]:
    given = {name: path for name, path in paths.items() if path is not None}
    if len(given) != 1:
        raise ValueError(
            f"give exactly one of {', '.join(paths)}; got {', '.join(given) or 'none'}"
        )
    ((control, path),) = given.items()
    try:
        targets = np.asarray(path, dtype=float)
    except (TypeError, ValueError, OverflowError):
        targets = np.array(np.nan)
    if targets.ndim != 1 or targets.size == 0 or not np.isfinite(targets).all():
        raise ValueError(f"{control} must be a sequence of finite numbers, got {path}")
    return control, targets


def _done(path: _Path, frames: Frames) -> list[LoadStep]:
    """Return the steps calculated before, checked against the path."""
    done: list[LoadStep] = []
    for info in frames.infos():
        other = _other(path, info, done[-1].step + 1 if done else None, frames.keep)
        if other:
            raise ValueError(
                f"can't resume: {os.fspath(frames.file or '')} holds steps of another "
                f"path or system: {'; '.join(other)} (eV, Å): take what was, delete "
                "the file, or give another file or folder"
            )
        done.append(LoadStep(**info["load_step"]))
    return done


def _other(
    path: _Path, info: dict[str, Any], expected: int | None, keep: str
) -> list[str]:
    """Tell what keeps a frame from being the next step of a path."""
    there, number = info.get("path"), info.get("load_step", {}).get("step")
    if there is None or number is None:
        return ["its frames are not those of a load path"]
    if expected is None:
        expected = number if keep == "last" else 0
    if number != expected:
        return [f"step {number} is where step {expected} should be"]
    if there["control"] != path.stepper.control:
        return [f"the path was one of {there['control']}, is of {path.stepper.control}"]
    if number >= len(path.targets):
        count = len(path.targets)
        return [f"the path had {number + 1} steps or more, has {count}"]
    here = path.mark(number)
    told = _differences(there["system"], here["system"])
    apart = float(np.ptp(path.targets[max(number - 1, 0) : number + 2]))
    rounding = {"rel_tol": _SAME_TARGET, "abs_tol": _SAME_TARGET * apart}
    if not math.isclose(there["target"], here["target"], **rounding):
        name = f"{here['control']}[{number}]"
        told.append(f"{name} was {there['target']}, is {here['target']}")
    return told


def _differences(old: Any, new: Any, name: str = "") -> list[str]:
    """Tell in words which parameters are not the same."""
    if not (isinstance(old, dict) and isinstance(new, dict)):
        return [] if old == new else [f"{name or 'system'} was {old}, is {new}"]
    return [
        told
        for key in {**old, **new}
        for told in _differences(old.get(key), new.get(key), f"{name}.{key}".strip("."))
    ]
