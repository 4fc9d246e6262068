"""Frames of a path in an ASE trajectory: kept whole or not at all, read one by one."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ase import Atoms
from ase.io import Trajectory
from ase.io.ulm import N1
from ase.parallel import DummyMPI

from ase_roughcontact.paths.record import LoadStep, Table

try:
    import fcntl
except ImportError:  # no Unix: then nothing keeps a second run away
    fcntl = None  # type: ignore[assignment]

PathName = str | os.PathLike
# Keeps a record and its frame, which is made if it is asked for.
Keep = Callable[[LoadStep, Callable[[], Atoms]], None]

# What a trajectory begins with; then come the number of its frames and the place of
# their table.
_MAGIC = b"- of UlmASE-Trajectory  "
_COUNT, _TABLE = slice(32, 40), slice(40, 48)


@dataclass(frozen=True)
class Frames:
    """Where frames are kept, whole or not at all: all of them, or the last one.

    Parameters
    ----------
    file : path, optional
        ASE trajectory; without one nothing is kept.
    keep : {"all", "last"}
        Frames that are kept.
    """

    file: PathName | None
    keep: str = "all"

    def infos(self) -> Iterator[dict[str, Any]]:
        """Read the `info` of one frame after the other, but for a torn one at the end.

        Arrays are read of the last frame only, to see that it is whole.

        Yields
        ------
        dict

        Raises
        ------
        ValueError
            If the file holds something, but no frame can be read.
        """
        if self.file is None or not Path(self.file).exists() or _begun(self.file):
            return
        whole = 0
        with open(self.file, "rb") as file:  # ASE leaves open what it can't read
            try:
                frames = Trajectory(file)
                for number in range(len(frames)):
                    last = number == len(frames) - 1
                    info = frames[-1].info if last else _info(frames, number)
                    if last and whole and "load_step" not in info:
                        return
                    yield info
                    whole += 1
            except Exception as error:
                if not whole:
                    raise ValueError(
                        f"can't resume: no frame of {os.fspath(self.file)} can be "
                        f"read, it is cut off or no trajectory ({error}): delete it, "
                        "or give another file or folder"
                    ) from error

    def records(self) -> Iterator[LoadStep]:
        """Read the record of one frame after the other; see `infos`.

        Yields
        ------
        LoadStep

        Raises
        ------
        ValueError
            If the file holds something, but no frame can be read, or one without such a
            record.
        """
        for info in self.infos():
            try:
                yield LoadStep(**info["load_step"])
            except (KeyError, TypeError) as error:
                raise ValueError(
                    f"the frames of {os.fspath(self.file or '')} are not those of a "
                    "load path: they have no record of a step, or another one"
                ) from error

    def frame(self, number: int) -> Atoms:
        """Read a whole frame.

        Parameters
        ----------
        number : int

        Returns
        -------
        Atoms
        """
        with Trajectory(os.fspath(self.file or "")) as frames:
            return frames[number]

    def claim(self, files: ExitStack, done: Sequence[LoadStep] | None) -> None:
        """Keep other runs from the file as long as this one lives, and mend it.

        Parameters
        ----------
        files : ExitStack
            Until when.
        done : sequence of LoadStep, optional
            Of the frames that the path goes on from; None if it begins anew.

        Raises
        ------
        RuntimeError
            If another run is writing the file, or has written it.
        """
        if self.file is None:
            return
        file = os.fspath(self.file)
        if self.keep == "all":
            _lock(files, file, file)
        elif fcntl is not None:  # a file that is replaced can't hold the lock itself
            _lock(files, f"{file}.lock", file)
            files.callback(Path(f"{file}.lock").unlink, missing_ok=True)
        if done is None:
            return
        if not self._holds(done):
            raise RuntimeError(f"another run has written {file}: start again to go on")
        if done and self.keep == "all":
            _mend(file, len(done))

    def open(self, files: ExitStack, append: bool) -> Callable[[Atoms], None] | None:
        """Open the file.

        Parameters
        ----------
        files : ExitStack
            Until when.
        append : bool
            Whether the frames that are there stay.

        Returns
        -------
        callable, optional
            Writes a frame; None if there is no file.
        """
        if self.file is None:
            return None
        if self.keep == "last":
            return partial(_replace, os.fspath(self.file))
        mode = "a" if append else "w"
        trajectory = Trajectory(os.fspath(self.file), mode, comm=DummyMPI())
        return partial(_append, files.enter_context(trajectory))

    def _holds(self, done: Sequence[LoadStep]) -> bool:
        """Whether the file holds the frames of some steps still, and no others."""
        if self.keep == "last":
            return list(self.records()) == list(done)
        file = os.fspath(self.file or "")
        return _counted(file) == len(done) or count_steps(file) == len(done)


def count_steps(trajectory: PathName) -> int:
    """Count the steps that a trajectory holds, but for a torn one at the end.

    Parameters
    ----------
    trajectory : path
        As `load_path` writes it.

    Returns
    -------
    int
        Zero if there is no such file, or the first step was not finished.

    Raises
    ------
    ValueError
        If the file holds something, but no frame can be read.
    """
    return sum(1 for _ in Frames(trajectory).infos())


def keeper(
    files: ExitStack,
    frames: Frames,
    table: PathName | None,
    done: Sequence[LoadStep] | None = None,
) -> Keep:
    """Open the files of a path.

    Parameters
    ----------
    files : ExitStack
        Until when.
    frames : Frames
    table : path, optional
        File of the records, written anew from the first of the steps on.
    done : sequence of LoadStep, optional
        Steps whose frames stay; None if the path begins anew.

    Returns
    -------
    callable
        Keeps a record and its frame, which is made if it is asked for.
    """
    frames.claim(files, done)
    # the table first: a trajectory that is there is lost once it is opened to write
    before = done[0].step if done else 0  # their frames were not kept
    rows = None if table is None else files.enter_context(Table(table, before))
    write = frames.open(files, append=bool(done))

    def keep(record: LoadStep, frame: Callable[[], Atoms]) -> None:
        if write is not None:
            write(frame())
        if rows is not None:
            rows.write(record)

    if rows is not None:
        for record in done or ():
            rows.write(record)
    return keep


def _lock(files: ExitStack, name: str, file: str) -> None:
    """Lock a file, made if it is not there, in the name of the one that is written."""
    held = files.enter_context(open(name, "ab"))  # noqa: SIM115
    try:
        if fcntl is not None:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        # its owner may have removed it since it was opened
        alone = os.path.samestat(os.fstat(held.fileno()), os.stat(name))
    except (BlockingIOError, FileNotFoundError):
        alone = False
    if not alone:
        raise RuntimeError(f"another run is writing {file}")


def _head(file: PathName) -> bytes:
    with open(file, "rb") as begun:
        return begun.read(_TABLE.stop)


def _counted(file: PathName) -> int:
    """Return the number of frames by a trajectory's own count, a torn one included."""
    return int.from_bytes(_head(file)[_COUNT], "little")


def _begun(file: PathName) -> bool:
    """Whether a trajectory was begun, and no frame of it was ever finished."""
    return _MAGIC.startswith(_head(file)[: len(_MAGIC)]) and not _counted(file)


def _mend(file: PathName, whole: int) -> None:
    """Count whole frames only, and give back their table what was cut off its end."""
    rows = 1  # as ASE has it
    while rows < _counted(file):
        rows *= N1
    end = int.from_bytes(_head(file)[_TABLE], "little") + 8 * rows
    with open(file, "r+b") as torn:
        if torn.seek(0, os.SEEK_END) < end:
            torn.truncate(end)
        torn.seek(_COUNT.start)
        torn.write(whole.to_bytes(8, "little"))


def _info(frames: Any, number: int) -> dict[str, Any]:
    """Return what is known of a frame, without reading its arrays."""
    return frames.backend[number].get("info", {})


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
