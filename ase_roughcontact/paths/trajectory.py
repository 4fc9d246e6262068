"""ASE trajectory of a path: one frame per step, complete or absent, also after a kill.

ASE writes a frame to the end of the file and counts it in the header afterwards: a
process that is killed loses at most the frame that it is writing. If the end of the
file is lost, its complete frames are copied to a new file before the path is resumed.
"""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

from ase import Atoms
from ase.io import Trajectory, ulm
from ase.parallel import DummyMPI

from ase_roughcontact.paths.record import LoadStep

try:
    import fcntl
except ImportError:  # not on Unix: a second run is not noticed
    fcntl = None  # type: ignore[assignment]

PathName = str | os.PathLike
_TAG = "ASE-Trajectory"


def read_infos(file: PathName) -> Iterator[dict[str, Any]]:
    """Read the `info` of one complete frame after another, without arrays.

    Parameters
    ----------
    file : path
        As `load_path` writes it. It may be missing, empty, or damaged at its end.

    Yields
    ------
    dict

    Raises
    ------
    ValueError
        If the file is not empty, but no frame can be read.
    """
    if not Path(file).exists() or _is_empty(file):
        return
    number = 0
    with open(file, "rb") as opened:  # ASE does not close a file that it can't read
        try:
            frames = Trajectory(opened)
            for number in range(len(frames)):
                yield frames.backend[number].get("info", {})
        except Exception as error:  # a later frame that can't be read is incomplete
            if not number:
                raise ValueError(
                    f"can't resume: no frame of {os.fspath(file)} can be read, it is "
                    f"cut off or not a trajectory ({error}): delete it, or give "
                    "another file or folder"
                ) from error


def read_steps(file: PathName, record: type[LoadStep] = LoadStep) -> Iterator[LoadStep]:
    """Read the result of one step after another from a trajectory.

    Parameters
    ----------
    file : path
        See `read_infos`.
    record : type
        Class of the results, `LoadStep` or the subclass that the path was written with.

    Yields
    ------
    LoadStep

    Raises
    ------
    ValueError
        If no frame can be read, or one has no result of this class.
    """
    for info in read_infos(file):
        try:
            yield record(**info["load_step"])
        except (KeyError, TypeError) as error:
            raise ValueError(
                f"the frames of {os.fspath(file)} are not those of a load path: they "
                f"have no results of steps, or not the columns of {record.__name__}"
            ) from error


def count_steps(file: PathName) -> int:
    """Count the complete frames of a trajectory; zero if there is no file.

    Parameters
    ----------
    file : path
        See `read_infos`.

    Returns
    -------
    int

    Raises
    ------
    ValueError
        If the file is not empty, but no frame can be read.
    """
    return sum(1 for _ in read_infos(file))


@contextmanager
def locked(file: PathName) -> Iterator[None]:
    """Keep other runs from writing a file, as long as this process lives.

    Parameters
    ----------
    file : path
        The lock is on a file beside it, ``file.lock``, removed in the end.

    Raises
    ------
    RuntimeError
        If another run is writing the file.
    """
    name = f"{os.fspath(file)}.lock"
    with open(name, "ab") as lock:
        try:
            if fcntl is not None:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # the run that held the lock may have removed the file since it was opened
            alone = os.path.samestat(os.fstat(lock.fileno()), os.stat(name))
        except (BlockingIOError, FileNotFoundError):
            alone = False
        if not alone:
            raise RuntimeError(f"another run is writing {os.fspath(file)}")
        try:
            yield
        finally:
            Path(name).unlink(missing_ok=True)


@contextmanager
def trajectory_writer(
    file: PathName, keep: str, kept: int
) -> Iterator[Callable[[Atoms], None]]:
    """Open a trajectory; a frame is written completely or not at all.

    Parameters
    ----------
    file : path
    keep : {"all", "last"}
        Frames that the file keeps.
    kept : int
        Number of complete frames that the file keeps; the rest is discarded.

    Yields
    ------
    callable
        Writes a frame.
    """
    file = os.fspath(file)
    if keep == "last":
        yield partial(_replace, file)
        return
    if kept:
        _discard_rest(file, kept)
    with Trajectory(file, "a" if kept else "w", comm=DummyMPI()) as trajectory:
        yield partial(_append, trajectory)


def _is_empty(file: PathName) -> bool:
    """Whether a file ends in or before the header of a trajectory without frames."""
    header = ulm.Writer(io.BytesIO(), tag=_TAG).header
    with open(file, "rb") as opened:
        return header.startswith(opened.read(len(header) + 1))


def _discard_rest(file: str, kept: int) -> None:
    """Copy the first frames to a new file if it is not safe to append to this one."""
    with Trajectory(file, "a", comm=DummyMPI()) as trajectory:
        index = trajectory.backend  # of the frames, with unused entries for later ones
        end = index.pos0 + index.offsets.nbytes
        if len(trajectory) == kept and end <= os.path.getsize(file):
            return
    with ulm.Reader(file) as old, ulm.Writer(f"{file}.new", tag=_TAG) as new:
        for number in range(kept):
            ulm.copy(old[number], new)
            new.sync()
    os.replace(f"{file}.new", file)


def _append(trajectory: Any, frame: Atoms) -> None:
    try:
        trajectory.write(frame)
    except BaseException:  # else ASE counts the incomplete frame when it closes
        trajectory.backend.data, trajectory.backend.nmissing = {}, 0
        raise


def _replace(file: str, frame: Atoms) -> None:
    with Trajectory(f"{file}.new", "w", comm=DummyMPI()) as trajectory:
        _append(trajectory, frame)
    os.replace(f"{file}.new", file)
