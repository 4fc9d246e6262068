"""Files of a path: a CSV file of results and a trajectory of frames."""

from __future__ import annotations

import csv
import zlib
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from itertools import islice
from typing import IO

from ase import Atoms

from ase_roughcontact._util.files import (
    PathName,
    locked,
    named_in_errors,
    open_file,
    refuse_link,
)
from ase_roughcontact.paths.record import LoadStep, columns_of
from ase_roughcontact.paths.resume import LINES, FinishedSteps
from ase_roughcontact.paths.trajectory import signature, trajectory_writer

# Writes the result of a step, and its frame, which is made only for a trajectory.
Write = Callable[[LoadStep, Callable[[], Atoms]], None]


@contextmanager
def open_output(
    trajectory: PathName | None,
    table: PathName | None,
    record: type[LoadStep] = LoadStep,
    *,
    keep: str = "all",
    finished: FinishedSteps | None = None,
) -> Iterator[Write]:
    """Open the files of a path.

    Parameters
    ----------
    trajectory : path, optional
        ASE trajectory of frames.
    table : path, optional
        CSV file. Its lines are on disk before the next step begins.
    record : type
        Class of the results.
    keep : {"all", "last"}
        Frames that the trajectory keeps.
    finished : FinishedSteps, optional
        Steps from which the path is resumed; None to start both files anew. The CSV
        file keeps its lines for earlier steps.

    Yields
    ------
    callable
        Writes the result of a step, and its frame.

    Raises
    ------
    ValueError
        If the lines that the CSV file keeps are not those that were written.
    RuntimeError
        If another run is writing the trajectory, or has written it since it was read.
    OSError
        If a file can't be written, or is a symbolic link.
    """
    rows = frames = None
    with ExitStack() as files:
        if trajectory is not None:
            refuse_link(trajectory)
            files.enter_context(locked(trajectory))
            if finished and signature(trajectory) != finished.signature:
                raise RuntimeError(
                    f"another run has written {trajectory} since it was read: call "
                    "again to resume from it"
                )
        if table is not None:  # before an old trajectory is overwritten
            rows = files.enter_context(_open_table(table, record, finished))
        if trajectory is not None:
            kept = len(finished.steps) if finished else 0
            frames = files.enter_context(trajectory_writer(trajectory, keep, kept))

        def write(step: LoadStep, make_frame: Callable[[], Atoms]) -> None:
            if frames is not None:
                frame = make_frame()
                if rows is not None and keep == "last":
                    frame.info[LINES] = rows.checksum
                frames(frame)
            if rows is not None:
                rows.write_step(step)

        yield write


class _Table:
    """CSV file of results: each line is written at once, and enters a checksum."""

    def __init__(self, file: IO[str], path: PathName, record: type[LoadStep]) -> None:
        self.checksum = 0
        self._file, self._path = file, path
        self._rows = csv.DictWriter(self, list(columns_of(record)))

    def write_header(self) -> None:
        self._rows.writeheader()

    def write_step(self, step: LoadStep) -> None:
        self._rows.writerow(asdict(step))

    def keep(self, count: int, checksum: int | None) -> bool:
        """Keep some lines of the file; return whether it has any."""
        self._file.seek(0)
        lines: list[str] = []
        for _ in islice(csv.reader(self._lines(lines)), count):
            pass
        self.checksum = zlib.crc32("".join(lines).encode())
        if lines and self.checksum != checksum:
            raise ValueError(
                f"the first {count} lines of {self._path} are not those that were "
                "written: restore a copy of the file, or name another one"
            )
        self._file.truncate(self._file.tell())
        return bool(lines)

    def _lines(self, read: list[str]) -> Iterator[str]:
        """Yield the lines of the file, and append them to a list."""
        while line := self._file.readline():  # next(file) would disable tell()
            read.append(line)
            yield line

    def write(self, text: str) -> None:
        with named_in_errors(self._path):
            self._file.write(text)
            self._file.flush()
        self.checksum = zlib.crc32(text.encode(), self.checksum)

    def close(self) -> None:
        with named_in_errors(self._path):
            self._file.close()


@contextmanager
def _open_table(
    path: PathName, record: type[LoadStep], finished: FinishedSteps | None
) -> Iterator[_Table]:
    """Open a CSV file; lines of finished steps are rewritten, earlier ones kept."""
    steps = finished.steps if finished else []
    earlier = steps[0].step if steps else 0  # lines of frames that were not kept
    mode = "a+" if earlier else "w"
    file = open_file(path, mode, newline="", encoding="utf-8")
    table = _Table(file, path, record)
    try:
        if not (earlier and finished and table.keep(earlier + 1, finished.lines)):
            table.write_header()
        for step in steps:
            table.write_step(step)
        yield table
    finally:
        table.close()
