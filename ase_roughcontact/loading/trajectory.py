"""Frames of a path for looking at it: ``sweep.traj``.

A frame has the pressure and the displacement of each atom in single precision, and
fields of friction and of a plastic shape. By the plugin of ASE, `ase.io.read` and
`ase gui` read the file.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from itertools import chain
from typing import IO

from ase import Atoms

from ase_roughcontact._util.files import PathName
from ase_roughcontact.loading.frame_contents import (
    described,
    packed,
    read_description,
    unpacked,
)
from ase_roughcontact.loading.frame_file import (
    FrameFile,
    FramePlace,
    contents_at,
    frame_places,
    frames_of,
    read_contents,
)
from ase_roughcontact.loading.step_frame import StepFrame
from ase_roughcontact.paths.kept_frames import has_frame


def read_frames(file: PathName) -> Iterator[Atoms]:
    """Read one frame after another.

    Parameters
    ----------
    file : path
        File that `load_path` has written. It may be missing, empty, or cut off at its
        end.

    Returns
    -------
    iterator of Atoms
        Frames like the ones of `snapshot`, in single precision and without forces.

    Raises
    ------
    ValueError
        If the file is not empty, but no frame can be read, or a frame is not what was
        written.

    Warns
    -----
    RuntimeWarning
        In the end, if a frame is cut off at the end of the file.
    """
    return map(unpacked, read_contents(file))


def read_roughcontact(fd: IO[bytes], index: slice) -> Iterator[Atoms]:
    """Read frames for `ase.io.read`; see `read_frames`."""
    contents = list(frames_of(fd, getattr(fd, "name", "the file")))
    return map(unpacked, contents[index])


def steps_with_frames(file: PathName) -> list[int]:
    """Return the numbers of the steps that have a frame; see `read_frames`."""
    return [_step_of(contents) for contents in read_contents(file)]


def places_of_steps(file: PathName) -> Mapping[int, FramePlace]:
    """Return the places of the frames of a trajectory by the numbers of their steps.

    The frames are not read. Places are found again if the file has changed, as it does
    while a path goes on.

    Raises
    ------
    ValueError
        If the file is not empty, but no frame can be read, or one is damaged.
    """
    if not os.path.exists(file):
        return {}
    status = os.stat(file)
    version = status.st_ino, status.st_size, status.st_mtime_ns
    return _places(os.fspath(file), version) if status.st_size else {}


@lru_cache(maxsize=1)
def _places(name: str, version: tuple[int, ...]) -> dict[int, FramePlace]:
    """Return the places of the frames of a file that has not changed."""
    with open(name, "rb") as opened:
        return {
            _step_at(opened, name, place): place for place in frame_places(opened, name)
        }


def _step_at(opened: IO[bytes], name: str, place: FramePlace) -> int:
    """Return the number of the step of a frame in an open file."""
    opened.seek(place.start)
    try:
        return _step_of(read_description(opened))
    except (LookupError, TypeError, ValueError, struct.error):
        contents_at(opened, name, place)  # its error names the damaged frame
        raise


def frame_of_step(file: PathName, step: int) -> Atoms:
    """Read the frame of a step.

    Raises
    ------
    KeyError
        If the step has no frame.
    ValueError
        If the frame is damaged; see also `places_of_steps`.
    """
    return _frame_at(file, places_of_steps(file)[step])


def frames_of_steps(file: PathName, steps: Container[int]) -> Iterator[Atoms]:
    """Read the frames of some steps, one after another; see `frame_of_step`."""
    places = places_of_steps(file)
    return (_frame_at(file, places[step]) for step in places if step in steps)


def _frame_at(file: PathName, place: FramePlace) -> Atoms:
    with open(file, "rb") as opened:
        return unpacked(contents_at(opened, os.fspath(file), place))


@contextmanager
def trajectory_writer(
    file: PathName, keep: str, finished: int | None
) -> Iterator[Callable[[StepFrame], None]]:
    """Open a trajectory; a frame is written completely or not at all.

    Parameters
    ----------
    file : path
        The trajectory, which is not changed before a frame is written.
    keep : {"thinned", "all", "last"}
        Frames that the file keeps; see `has_frame`.
    finished : int or None
        Number of finished steps of a path that is resumed; None to begin again whatever
        the file contains.

    Yields
    ------
    callable
        Function that writes the frame of a step.

    Raises
    ------
    ValueError
        If the path is resumed, and a frame is damaged, not of a path, or of a later
        step than the finished ones.
    """
    found = [] if finished is None else steps_with_frames(file)
    # the frame of a step is written before the step is finished
    if finished is not None and found and found[-1] > finished:
        raise ValueError(
            f"{os.fspath(file)} has a frame of step {found[-1]}, but only {finished} "
            "steps are finished: restore the restart file, or delete the trajectory to "
            "begin again"
        )
    frames: FrameFile | None = None
    steps = found

    def write(frame: StepFrame) -> None:
        nonlocal frames, steps
        contents, step = packed(frame), frame.info["load_step"]["step"]
        kept = [each for each in steps if each < step and has_frame(keep, each, step)]
        if frames is None or kept not in (steps, steps[:-1]) or not kept:
            frames = _replaced(frames, file, kept, contents)
        else:
            if kept != steps:
                frames.drop_last()
            frames.add(contents)
        steps = [*kept, step]

    try:
        yield write
    finally:
        if frames is not None:
            frames.close()


def _replaced(
    frames: FrameFile | None, file: PathName, kept: Container[int], last: bytes
) -> FrameFile:
    """Return a new file with the frames of some steps and another one."""
    if frames is not None:
        frames.check_is_there()
        frames.close()
    return FrameFile(file, chain(_contents_of(file, kept), [last]))


def _contents_of(file: PathName, steps: Container[int]) -> Iterator[bytes]:
    """Yield the contents of the frames of some steps."""
    if steps:
        for contents in read_contents(file):
            if _step_of(contents) in steps:
                yield contents


def _step_of(contents: bytes) -> int:
    return described(contents)["info"]["load_step"]["step"]
