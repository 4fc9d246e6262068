"""Quasi-static load paths: one relaxed state after the other, each written at once."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from ase import Atoms
from ase.io import Trajectory
from ase.parallel import DummyMPI

from ase_roughcontact.record import LoadStep, Table
from ase_roughcontact.stepping import Stepper
from ase_roughcontact.substrate import snapshot

PathName = str | os.PathLike

# Where in a trajectory its number of frames stands.
_COUNTED = 32


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
        or `HardWallCG` where the wall is hard.
    fmax : float, optional
        Tolerance of the force on every atom (eV/Å), instead of `accuracy`.
    trajectory : path, optional
        File of an ASE trajectory of snapshots, one per step.
    csv : path, optional
        File of a table of the records, one line per step.
    accuracy : {"fast", "normal", "high"} or float
        Relative error that is allowed in force and area, see `Accuracy`; it sets a
        tolerance relative to the mean force on the atoms in contact, which fits loads
        of any size. "high" takes 1.2 to 1.5 times as long as "fast".
    max_steps : int
        Steps of the optimizer at most, per step of the path.
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
        not calculated again.

    Yields
    ------
    LoadStep
        As soon as it is known, and written. A step that does not converge is yielded
        and written too, marked.

    Raises
    ------
    ValueError
        If not exactly one path is given, it is empty or not finite, the indenter's
        constraint does not fit it, or `resume` finds another path. With automatic
        windows, if the indenter does not rise out of reach, or atoms could touch at
        which its roughness is not known.
    RuntimeError
        If the contact has come to the edge of a fixed window.
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
    path, frames = _Path(stepper, targets), _Frames(trajectory, keep)
    return _steps(path, frames, csv, _done(path, frames) if resume else None)


@dataclass(frozen=True)
class _Path:
    """The targets of a path, and what goes along it."""

    stepper: Stepper
    targets: np.ndarray

    def mark(self, number: int) -> dict[str, Any]:
        """Tell a step's place on the path from all others."""
        return {
            "system": self.stepper.fingerprint(),
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


@dataclass(frozen=True)
class _Frames:
    """Where frames are kept: all of them, or the last one."""

    file: PathName | None
    keep: str

    def read(self) -> list[Atoms]:
        """Return the frames that are there, but for a torn one at the end."""
        if self.file is None or not Path(self.file).exists():
            return []
        if Path(self.file).stat().st_size == 0:
            return []
        frames: list[Atoms] = []
        try:
            with Trajectory(os.fspath(self.file)) as trajectory:
                for number in range(len(trajectory)):
                    frames.append(trajectory[number])
        except Exception as error:
            if not frames:
                raise ValueError(
                    f"can't resume: {os.fspath(self.file)} has no whole frame "
                    f"({error}): delete it, or give another file or folder"
                ) from error
        marked = ["path" in frame.info for frame in frames]
        return frames[:-1] if any(marked) and not marked[-1] else frames

    def claim(self, files: ExitStack, done: list[Atoms] | None) -> None:
        """Keep other runs from the file as long as this one lives, and mend it.

        Parameters
        ----------
        files : ExitStack
            Until when.
        done : list of Atoms, optional
            Frames that the path goes on from; None if it begins anew.
        """
        if self.file is None or self.keep == "last":
            return
        file = os.fspath(self.file)
        held = files.enter_context(open(file, "ab"))  # noqa: SIM115
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise RuntimeError(f"another run is writing {file}") from error
        if done is None or _count(file) == len(done):
            return
        if len(self.read()) != len(done):
            raise RuntimeError(f"another run has written {file}: start again to go on")
        with open(file, "r+b") as torn:
            torn.seek(_COUNTED)
            torn.write(np.array(len(done), "<i8").tobytes())

    def open(self, files: ExitStack, append: bool) -> Callable[[Atoms], None] | None:
        """Return what writes a frame, None if there is no file."""
        if self.file is None:
            return None
        if self.keep == "last":
            return partial(_replace, os.fspath(self.file))
        mode = "a" if append else "w"
        trajectory = Trajectory(os.fspath(self.file), mode, comm=DummyMPI())
        return partial(_append, files.enter_context(trajectory))


def _count(file: str) -> int:
    """Count the frames of a trajectory, torn ones among them."""
    if Path(file).stat().st_size == 0:
        return 0
    with Trajectory(file) as trajectory:
        return len(trajectory)


def _append(trajectory: Any, frame: Atoms) -> None:
    """Write a frame, or none: when it is closed, ASE counts what there is of one."""
    try:
        trajectory.write(frame)
    except BaseException:
        trajectory.backend.data, trajectory.backend.nmissing = {}, 0
        raise


def _replace(file: str, frame: Atoms) -> None:
    """Write a trajectory of one frame in place of what is there, or not at all."""
    with Trajectory(f"{file}.new", "w", comm=DummyMPI()) as trajectory:
        _append(trajectory, frame)
    os.replace(f"{file}.new", file)


def _steps(
    path: _Path, frames: _Frames, table: PathName | None, done: list[Atoms] | None
) -> Iterator[LoadStep]:
    with ExitStack() as files:
        frames.claim(files, done)
        # the table first: a trajectory that is there is lost once it is opened to write
        rows = None if table is None else files.enter_context(Table(table))
        keep = frames.open(files, append=bool(done))
        before = [LoadStep(**frame.info["load_step"]) for frame in done or []]
        if rows is not None:
            for record in before:
                rows.write(record)
        yield from before
        if done:
            path.stepper.proceed_from(done[-1])
        first = before[-1].step + 1 if done else 0
        for number in range(first, len(path.targets)):
            record = path.step(number)
            if keep is not None:
                keep(path.frame(record))
            if rows is not None:
                rows.write(record)
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
    except (TypeError, ValueError):
        targets = np.array(np.nan)
    if targets.ndim != 1 or targets.size == 0 or not np.isfinite(targets).all():
        raise ValueError(f"{control} must be a sequence of finite numbers, got {path}")
    return control, targets


def _done(path: _Path, frames: _Frames) -> list[Atoms]:
    """Frames that were calculated before, checked against the path."""
    done = frames.read()
    steps = [frame.info.get("load_step", {}).get("step", -1) for frame in done]
    first = steps[0] if done and frames.keep == "last" else 0
    in_order = steps == list(range(first, first + len(done)))
    known = [frame.info.get("path") for frame in done]
    if steps and not (
        in_order
        and 0 <= steps[-1] < len(path.targets)
        and known == [path.mark(step) for step in steps]
    ):
        raise ValueError(
            f"can't resume: {os.fspath(frames.file or '')} holds {len(done)} steps of "
            "another path or system (indenter, wall, solid, window, loads or tolerance "
            "differ): delete it, or give another file or folder"
        )
    return done
