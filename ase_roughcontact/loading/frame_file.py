"""File of frames: one after the other, each with its size and a checksum.

A frame is at the end of the file, completely, or it is cut off: a process that is
killed loses at most the frame that it is writing.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO, NamedTuple

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.files import (
    PathName,
    check_is_there,
    named_in_errors,
    replaced,
)

#: Beginning of the file, with the version of the format.
MAGIC = b"frames of ase_roughcontact 2\n"
# Format of the size and the CRC-32 of the contents of a frame.
_SIZES = struct.Struct("<QI")
# Format of the CRC-32 of both.
_CHECK = struct.Struct("<I")


def read_contents(file: PathName) -> Iterator[bytes]:
    """Read the contents of one frame after another.

    Parameters
    ----------
    file : path
        The file; it may be missing, empty, or cut off at its end.

    Yields
    ------
    bytes

    Raises
    ------
    ValueError
        If the file has no frames of this format, or one is damaged.

    Warns
    -----
    RuntimeWarning
        In the end, if a frame is cut off at the end of the file.
    """
    if not Path(file).exists() or not os.path.getsize(file):
        return
    with open(file, "rb") as opened:
        yield from frames_of(opened, os.fspath(file))


def frames_of(opened: IO[bytes], name: str) -> Iterator[bytes]:
    """Read the contents of the frames in an open file; see `read_contents`."""
    for place in frame_places(opened, name):
        yield contents_at(opened, name, place)


class FramePlace(NamedTuple):
    """Place of a frame in a file.

    Attributes
    ----------
    number : int
        Number of the frame in the file, from zero.
    start, size : int
        First byte and number of bytes of its contents.
    check : int
        CRC-32 of its contents.
    """

    number: int
    start: int
    size: int
    check: int


def frame_places(opened: IO[bytes], name: str) -> Iterator[FramePlace]:
    """Find the frames in an open file without reading them; see `read_contents`."""
    begin = opened.read(len(MAGIC))
    if begin != MAGIC:
        cut = MAGIC.startswith(begin)
        cause = "it is cut off" if cut else "it is not a trajectory of a load path"
        raise ValueError(
            f"no frame of {name} can be read, {cause}: restore a copy, delete it to "
            "begin again, or give another file or folder"
        )
    end = opened.seek(0, os.SEEK_END)
    number, start = 0, len(MAGIC)
    while start < end:
        opened.seek(start)
        head = opened.read(_SIZES.size + _CHECK.size)
        sizes, check = head[: _SIZES.size], head[_SIZES.size :]
        if len(check) < _CHECK.size:
            break
        if _CHECK.pack(zlib.crc32(sizes)) != check:
            raise ValueError(_damage(name, number))
        size, expected = _SIZES.unpack(sizes)
        place = FramePlace(number, start + len(head), size, expected)
        if place.start + size > end:
            break
        yield place
        number, start = number + 1, place.start + size
    else:
        return
    warn(f"frame {number} of {name} is cut off: it is left out", RuntimeWarning)


def contents_at(opened: IO[bytes], name: str, place: FramePlace) -> bytes:
    """Read the contents of a frame, or raise `ValueError` if they are damaged."""
    opened.seek(place.start)
    contents = opened.read(place.size)
    if zlib.crc32(contents) != place.check:
        raise ValueError(_damage(name, place.number))
    return contents


class FrameFile:
    """File that frames are added to, or taken from its end.

    Parameters
    ----------
    file : path
        The file, which is replaced by one with the given frames.
    contents : iterable of bytes
        Contents of the given frames.
    """

    def __init__(self, file: PathName, contents: Iterable[bytes]) -> None:
        self._file = file
        self._ends = [len(MAGIC)]
        with named_in_errors(file):
            with replaced(file) as new, open(new, "wb") as first:
                first.write(MAGIC)
                for each in contents:
                    self._write(each, first)
            # not before it has its name: Windows replaces no open file
            self._opened = open(file, "r+b")  # noqa: SIM115
            self._opened.seek(self._ends[-1])

    def add(self, contents: bytes) -> None:
        """Add a frame.

        Raises
        ------
        OSError
            If it can't be written, or the file was removed or replaced.
        """
        self.check_is_there()
        with named_in_errors(self._file):
            self._write(contents, self._opened)
            self._opened.flush()

    def drop_last(self) -> None:
        """Take the last frame from the file."""
        self.check_is_there()
        with named_in_errors(self._file):
            del self._ends[-1]
            self._opened.truncate(self._ends[-1])
            self._opened.seek(self._ends[-1])

    def check_is_there(self) -> None:
        """Raise `OSError` if the file of this name is another one."""
        check_is_there(self._file, self._opened)

    def close(self) -> None:
        """Close the file."""
        with named_in_errors(self._file):
            self._opened.close()

    def _write(self, contents: bytes, opened: IO[bytes]) -> None:
        sizes = _SIZES.pack(len(contents), zlib.crc32(contents))
        opened.write(sizes + _CHECK.pack(zlib.crc32(sizes)) + contents)
        self._ends.append(self._ends[-1] + len(sizes) + _CHECK.size + len(contents))


def _damage(name: str, number: int) -> str:
    """Return the message about the first damaged frame."""
    return (
        f"frame {number} of {name} is damaged: restore a copy of the file, or delete "
        "it to go on without earlier frames"
    )
