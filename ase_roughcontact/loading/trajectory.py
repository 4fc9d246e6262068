"""ASE trajectory of a path: one frame per step, complete or absent, and checked.

ASE writes a frame to the end of the file and counts it in the header afterwards: a
process that is killed loses at most the frame that it is writing. A path that is
resumed copies the frames that are kept to a new file, which replaces the old one when
the first new frame is complete. Every frame carries a checksum, so that damage is
noticed.
"""

from __future__ import annotations

import os
import warnings
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from ase import Atoms
from ase.io import Trajectory
from ase.io.jsonio import encode
from ase.parallel import DummyMPI

from ase_roughcontact._util.files import (
    PathName,
    closed_at_end,
    named_in_errors,
    replaced,
)
from ase_roughcontact.results.record import LoadStep

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


def read_frames(file: PathName) -> Iterator[Atoms]:
    """Read one frame after another.

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

    Warns
    -----
    RuntimeWarning
        In the end, if frames are cut off at the end of the file.
    """
    name, cut = os.fspath(file), 0
    with _opened(file) as frames:
        for number in range(len(frames)):
            try:
                frame = frames[number]
                expected, found = frame.info.get(_CHECKSUM), checksum(frame)
            except ValueError:  # as arrays and texts that end too early
                cut += 1
                continue
            except Exception:  # of any kind: what is damaged can be anything
                expected, found = None, 0
            else:
                if expected is None and number == 0:
                    raise ValueError(
                        f"the frames of {name} are not those of a load path: they have "
                        "no checksum. Delete it, or give another file or folder"
                    )
            if cut or found != expected:
                raise ValueError(_damage(name, number - cut))
            yield frame
        if 0 < cut == len(frames):
            raise _unreadable(name, "all frames are incomplete")
        if cut:
            warnings.warn(
                f"the last {cut} of the {len(frames)} frames of {name} are cut "
                "off: they are left out",
                RuntimeWarning,
                stacklevel=2,
            )


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
    """
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
        If the file is not empty, but no frame can be read.
    """
    with _opened(file) as frames:
        for number in reversed(range(len(frames))):
            with suppress(Exception):  # the last frame may be torn
                _ = frames[number]
                return number + 1
        return 0


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
        It is not changed before a frame is written.
    keep : {"all", "last"}
        Frames that the file keeps.
    kept : int
        Number of frames of an earlier run that the file keeps, with "all".

    Yields
    ------
    callable
        Writes a frame.
    """
    trajectory: Any = None
    with closed_at_end(file) as stack:

        def write(frame: Atoms) -> None:
            nonlocal trajectory
            frame.info[_CHECKSUM] = checksum(frame)
            if trajectory is not None and keep == "all":
                with named_in_errors(file):
                    trajectory.write(frame)
                return
            stack.close()
            with replaced(file) as new:
                # ASE would count an incomplete frame when it closes the file
                opened = stack.enter_context(open(new, "wb"))  # noqa: SIM115
                trajectory = Trajectory(opened, "w", comm=DummyMPI())
                for old in islice(read_frames(file), kept if keep == "all" else 0):
                    trajectory.write(old)
                trajectory.write(frame)

        yield write


@contextmanager
def _opened(file: PathName) -> Iterator[Any]:
    """Open a trajectory; without frames if the file is missing or empty."""
    if not Path(file).exists() or not os.path.getsize(file):
        yield ()
        return
    with open(file, "rb") as opened:
        try:
            frames = Trajectory(opened)
        except Exception as error:
            raise _unreadable(os.fspath(file), error) from error
        yield frames


def _unreadable(name: str, cause: object) -> ValueError:
    return ValueError(
        f"no frame of {name} can be read, it is cut off, damaged or not a trajectory "
        f"({cause}): restore a copy, delete it to begin again, or give another file or "
        "folder"
    )


def _damage(name: str, number: int) -> str:
    """Return the message about the first damaged frame."""
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
