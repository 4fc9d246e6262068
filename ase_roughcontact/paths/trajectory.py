"""ASE trajectory of a path: one frame per step, complete or absent, and checked.

ASE writes a frame to the end of the file and counts it in the header afterwards: a
process that is killed loses at most the frame that it is writing. If the end of the
file is lost, its complete frames are copied to a new file before the path is resumed.
Every frame carries a checksum, so that damage elsewhere is noticed.
"""

from __future__ import annotations

import io
import os
import sys
import warnings
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np
from ase import Atoms
from ase.io import Trajectory, ulm
from ase.io.jsonio import encode
from ase.parallel import DummyMPI

from ase_roughcontact._util.files import PathName, named_in_errors, replaced
from ase_roughcontact.paths.record import LoadStep

_TAG = "ASE-Trajectory"
# Numbers of frames for which the index in the file has no unused entry.
_FULL = [ulm.N1**power for power in range(8)]
# Key of the checksum in the `info` of a frame.
_CHECKSUM = "checksum"
# Arrays of atoms that a trajectory keeps.
_ARRAYS = (
    "numbers",
    "positions",
    "tags",
    "initial_charges",
    "initial_magmoms",
    "momenta",
    "masses",
)


Signature = tuple[int, int, int] | None


def signature(file: PathName) -> Signature:
    """Return what changes whenever a file is written; None if it does not exist."""
    try:
        status = os.stat(file)
    except FileNotFoundError:
        return None
    return status.st_ino, status.st_size, status.st_mtime_ns


def read_frames(file: PathName) -> Iterator[Atoms]:
    """Read one complete frame after another.

    Parameters
    ----------
    file : path
        As `load_path` writes it. It may be missing, empty, or cut off at its end.

    Yields
    ------
    Atoms

    Raises
    ------
    ValueError
        If the file is not empty, but no frame can be read, or a frame is not what was
        written.
    """
    name = os.fspath(file)
    with _opened(file) as (opened, count, cut):
        if not count:
            return
        try:
            frames = Trajectory(opened)
        except Exception as error:
            raise _unreadable(name, error) from error
        for number in range(count - cut):
            try:
                frame = frames[number]
                expected, found = frame.info.get(_CHECKSUM), checksum(frame)
            except Exception:  # of any kind: what is damaged can be anything
                expected, found = None, 0
            else:
                if expected is None and number == 0:
                    raise ValueError(
                        f"the frames of {name} are not those of a load path: they have "
                        "no checksum. Delete it, or give another file or folder"
                    )
            if found != expected:
                raise ValueError(_damage(name, number))
            yield frame


def read_steps(file: PathName, record: type[LoadStep] = LoadStep) -> Iterator[LoadStep]:
    """Read the result of one step after another from a trajectory.

    Parameters
    ----------
    file : path
        See `read_frames`.
    record : type
        Class of the results; see `LoadStep.from_columns`.

    Yields
    ------
    LoadStep

    Raises
    ------
    ValueError
        If no frame can be read, one is damaged, or has no result of a step.

    Warns
    -----
    RuntimeWarning
        If frames are cut off at the end of the file.
    """
    with _opened(file) as (_, count, cut):
        if cut:
            warnings.warn(
                f"the last {cut} of the {count} frames of {os.fspath(file)} are cut "
                "off: they are left out",
                RuntimeWarning,
                stacklevel=2,
            )
    for frame in read_frames(file):
        try:
            yield record.from_columns(frame.info["load_step"])
        except KeyError as error:
            raise ValueError(
                f"the frames of {os.fspath(file)} are not those of a load path: they "
                "have no results of steps"
            ) from error


def count_steps(file: PathName) -> int:
    """Count the complete frames of a trajectory, without checking them.

    Parameters
    ----------
    file : path
        See `read_frames`.

    Returns
    -------
    int
        Zero if there is no file.

    Raises
    ------
    ValueError
        If the file is not empty, but has no complete frame.
    """
    with _opened(file) as (_, count, cut):
        return count - cut


def checksum(frame: Atoms) -> int:
    """Return the CRC-32 of all that a trajectory keeps of a frame."""
    arrays = {name: frame.arrays[name] for name in _ARRAYS if name in frame.arrays}
    if frame.calc is not None:
        arrays |= frame.calc.results
    info = {key: value for key, value in frame.info.items() if key != _CHECKSUM}
    texts = [frame.cell.tolist(), frame.pbc.tolist(), frame.constraints, *info.items()]
    value = 0
    for text in texts:
        with suppress(TypeError):  # what ASE can't write, it leaves out
            value = zlib.crc32(encode(text).encode(), value)
    for name in sorted(arrays):
        value = zlib.crc32(name.encode(), value)
        value = zlib.crc32(np.ascontiguousarray(arrays[name]).data, value)
    return value


@contextmanager
def trajectory_writer(
    file: PathName, keep: str, kept: int
) -> Iterator[Callable[[Atoms], None]]:
    """Open a trajectory; a frame is written completely or not at all.

    Parameters
    ----------
    file : path
        Removed in the end if no frame was written.
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
    trajectory = Trajectory(file, "a" if kept else "w", comm=DummyMPI())
    try:
        yield partial(_append, file, trajectory)
    finally:
        written = len(trajectory)
        with named_in_errors(file):
            trajectory.close()
        if not written:
            os.unlink(file)


@contextmanager
def _opened(file: PathName) -> Iterator[tuple[IO[bytes], int, int]]:
    """Open a trajectory; count its frames, and those that are cut off at its end."""
    name = os.fspath(file)
    if not Path(file).exists():
        yield io.BytesIO(), 0, 0
        return
    with open(file, "rb") as opened:
        empty = ulm.Writer(io.BytesIO(), tag=_TAG).header
        if empty.startswith(opened.read(len(empty) + 1)):
            yield opened, 0, 0
            return
        try:
            tag, version, _, index, offsets = ulm.read_header(opened)
        except Exception as error:
            raise _unreadable(name, error) from error
        if tag != _TAG:
            raise _unreadable(name, f"its kind is {tag!r}")
        if version != ulm.VERSION:
            raise ValueError(
                f"the header of {name} is damaged, it has version {version}: "
                f"'ase convert {name} new.traj' copies the frames to a new file"
            )
        count = len(offsets)
        if _integer_at(opened, index + 8 * count) > 0 and count not in _FULL:
            raise _unreadable(name, f"it counts {count} frames, but has more")
        cut = 0
        size = os.fstat(opened.fileno()).st_size
        while cut < count:
            offset = int(offsets[count - 1 - cut])  # of a text, after the arrays
            length = _integer_at(opened, offset) if 0 <= offset < size else size
            if offset + 8 + length <= size:
                break
            cut += 1
        if count and cut == count:
            raise _unreadable(name, "all frames are incomplete")
        opened.seek(0)
        yield opened, count, cut


def _integer_at(opened: IO[bytes], offset: int) -> int:
    """Return the integer at an offset; a large one where the file ends before."""
    opened.seek(offset)
    return int.from_bytes(opened.read(8).ljust(8, b"\x7f"), sys.byteorder, signed=True)


def _unreadable(name: str, cause: object) -> ValueError:
    return ValueError(
        f"no frame of {name} can be read, it is cut off, damaged or not a trajectory "
        f"({cause}): restore a copy, delete it to begin again, or give another file or "
        "folder"
    )


def _damage(name: str, number: int) -> str:
    """Return the message about a damaged frame."""
    advice = "delete it to begin again"
    if number:
        advice = (
            f"put the frames before in its place, by 'ase convert -n :{number} "
            f"{name} new.traj', and start again"
        )
    return (
        f"frame {number} of {name} is damaged, it is not what was written: restore a "
        f"copy of the file, or {advice}"
    )


def _discard_rest(file: str, kept: int) -> None:
    """Copy the first frames to a new file if it is not safe to append to this one."""
    with Trajectory(file, "a", comm=DummyMPI()) as trajectory:
        index = trajectory.backend  # of the frames, with unused entries for later ones
        end = index.pos0 + index.offsets.nbytes
        if len(trajectory) == kept and end <= os.path.getsize(file):
            return
    with (
        replaced(file) as name,
        ulm.Reader(file) as old,
        ulm.Writer(name, tag=_TAG) as new,
    ):
        for number in range(kept):
            ulm.copy(old[number], new)
            new.sync()


def _append(file: str, trajectory: Any, frame: Atoms) -> None:
    frame.info[_CHECKSUM] = checksum(frame)
    try:
        with named_in_errors(file):
            trajectory.write(frame)
    except BaseException:  # else ASE counts the incomplete frame when it closes
        trajectory.backend.data, trajectory.backend.nmissing = {}, 0
        raise


def _replace(file: str, frame: Atoms) -> None:
    with replaced(file) as name, Trajectory(name, "w", comm=DummyMPI()) as trajectory:
        _append(file, trajectory, frame)
