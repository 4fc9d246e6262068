"""Files of a path: a CSV file of results and a trajectory of frames."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from itertools import islice
from typing import TextIO

from ase import Atoms

from ase_roughcontact.paths.record import LoadStep, columns_of
from ase_roughcontact.paths.trajectory import (
    PathName,
    locked,
    read_infos,
    trajectory_writer,
)

# Writes the result of a step, and its frame, which is made only for a trajectory.
Write = Callable[[LoadStep, Callable[[], Atoms]], None]


@contextmanager
def open_output(
    trajectory: PathName | None,
    table: PathName | None,
    record: type[LoadStep] = LoadStep,
    *,
    keep: str = "all",
    done: Sequence[LoadStep] | None = None,
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
    done : sequence of LoadStep, optional
        Results of the frames from which the path is resumed; None to start both files
        anew. The CSV file keeps its lines for earlier steps.

    Yields
    ------
    callable
        Writes the result of a step, and its frame.

    Raises
    ------
    RuntimeError
        If another run is writing the trajectory, or has written it since it was read.
    OSError
        If a file can't be written.
    """
    rows = frames = None
    with ExitStack() as files:
        if trajectory is not None:
            files.enter_context(locked(trajectory))
            if done is not None and not _holds(trajectory, done):
                raise RuntimeError(
                    f"another run has written {trajectory} since it was read: call "
                    "again to resume from it"
                )
        if table is not None:  # before an old trajectory is overwritten
            rows = files.enter_context(_csv_writer(table, record, done or ()))
        if trajectory is not None:
            kept = len(done or ())
            frames = files.enter_context(trajectory_writer(trajectory, keep, kept))

        def write(step: LoadStep, frame: Callable[[], Atoms]) -> None:
            if frames is not None:
                frames(frame())
            if rows is not None:
                rows(step)

        yield write


def _holds(trajectory: PathName, done: Sequence[LoadStep]) -> bool:
    """Return whether a trajectory still consists of the frames of some steps."""
    infos = [info.get("load_step") for info in read_infos(trajectory)]
    return repr(infos) == repr([asdict(step) for step in done])  # NaN equals NaN


@contextmanager
def _csv_writer(
    path: PathName, record: type[LoadStep], done: Sequence[LoadStep]
) -> Iterator[Callable[[LoadStep], None]]:
    """Open a CSV file; lines of finished steps are rewritten, earlier ones kept."""
    earlier = done[0].step if done else 0  # lines of frames that were not kept
    with open(path, "a+" if earlier else "w", newline="") as file:
        rows = csv.DictWriter(file, list(columns_of(record)))

        def write(step: LoadStep) -> None:
            rows.writerow(asdict(step))
            file.flush()

        if not (earlier and _truncate(file, earlier + 1)):
            rows.writeheader()
        for step in done:
            write(step)
        yield write


def _truncate(file: TextIO, count: int) -> int:
    """Truncate a CSV file after some lines; return its size."""
    file.seek(0)
    lines = csv.reader(iter(file.readline, ""))  # next(file) would disable tell()
    for _ in islice(lines, count):
        pass
    return file.truncate(file.tell())
