"""Frames of a path for looking at it: ``sweep.traj``.

A frame has the pressure and the displacement of each atom in single precision, and
fields of friction and of a plastic shape. By the plugin of ASE, `ase.io.read` and
`ase gui` read the file.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Container, Iterator, Mapping
from contextlib import contextmanager
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


class StoredFrames(Mapping[int, Atoms]):
    """Frames of a trajectory by the number of their steps, each read when it is needed.

    Parameters
    ----------
    file : path
        File that `load_path` has written; see `read_frames`.

    Raises
    ------
    ValueError
        If the file is not empty, but no frame can be read, or, for a frame, if it is
        damaged.
    """

    def __init__(self, file: PathName) -> None:
        self._file, self._name = file, os.fspath(file)
        self._places: dict[int, FramePlace] = {}
        if not os.path.exists(file) or not os.path.getsize(file):
            return
        with open(file, "rb") as opened:
            for place in frame_places(opened, self._name):
                opened.seek(place.start)
                self._places[_step_of(read_description(opened))] = place

    def __getitem__(self, step: int) -> Atoms:
        place = self._places[step]
        with open(self._file, "rb") as opened:
            return unpacked(contents_at(opened, self._name, place))

    def __contains__(self, step: object) -> bool:
        return step in self._places

    def __iter__(self) -> Iterator[int]:
        return iter(self._places)

    def __len__(self) -> int:
        return len(self._places)


def frames_of_steps(file: PathName, steps: Container[int]) -> Iterator[Atoms]:
    """Read the frames of some steps, one after another; see `StoredFrames`."""
    stored = StoredFrames(file)
    return (stored[step] for step in stored if step in steps)


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
    new = FrameFile(file, chain(_contents_of(file, kept), [last]))
    if frames is not None:
        frames.close()
    return new


def _contents_of(file: PathName, steps: Container[int]) -> Iterator[bytes]:
    """Yield the contents of the frames of some steps."""
    if steps:
        for contents in read_contents(file):
            if _step_of(contents) in steps:
                yield contents


def _step_of(contents: bytes) -> int:
    return described(contents)["info"]["load_step"]["step"]
