"""Files of a path: a CSV file of results and a trajectory of frames."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import asdict
from itertools import chain, islice
from pathlib import Path

from ase import Atoms

from ase_roughcontact._util.files import PathName, locked, refuse_link, table_writer
from ase_roughcontact.paths.record import LoadStep, columns_of
from ase_roughcontact.paths.resume import FinishedSteps, PathDescription
from ase_roughcontact.paths.trajectory import trajectory_writer

# Writes the result of a step, and its frame, which is made only for a trajectory.
Write = Callable[[LoadStep, Callable[[], Atoms]], None]


@contextmanager
def open_output(
    trajectory: PathName | None,
    table: PathName | None,
    record: type[LoadStep] = LoadStep,
    *,
    keep: str = "all",
    path: PathDescription | None = None,
) -> Iterator[tuple[FinishedSteps, Write]]:
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
    path : PathDescription, optional
        Path to resume from the trajectory; None to start both files anew. The CSV file
        keeps its lines for earlier steps.

    Yields
    ------
    finished : FinishedSteps
        Steps from which the path is resumed.
    write : callable
        Writes the result of a step, and its frame.

    Raises
    ------
    ValueError
        If the trajectory is damaged or of another path, or the lines that the CSV file
        keeps are not those of the earlier steps.
    RuntimeError
        If another run is writing the trajectory.
    OSError
        If a file can't be written, or is a symbolic link.
    """
    finished, rows, frames = FinishedSteps(), None, None
    with ExitStack() as files:
        if trajectory is not None:
            refuse_link(trajectory)
            files.enter_context(locked(trajectory))
            if path is not None:
                finished = path.finished_steps(trajectory, keep, record)
            kept = len(finished.steps)
            frames = files.enter_context(trajectory_writer(trajectory, keep, kept))
        if table is not None:
            first = finished.steps[0].step if finished.steps else 0
            known = chain(_lines(table, first), map(asdict, finished.steps))
            columns = list(columns_of(record))
            rows = files.enter_context(table_writer(table, columns, known))

        def write(step: LoadStep, make_frame: Callable[[], Atoms]) -> None:
            if frames is not None:
                frames(make_frame())
            if rows is not None:
                rows(asdict(step))

        yield finished, write


def _lines(table: PathName, count: int) -> Sequence[Mapping[str, str]]:
    """Return the lines of a table for the first steps, if it has any lines."""
    if not count or not Path(table).exists():
        return []
    try:
        with open(table, newline="", encoding="utf-8") as file:
            lines = list(islice(csv.DictReader(file), count))
            steps = [int(line["step"]) for line in lines]
    except (KeyError, TypeError, ValueError, csv.Error):
        steps = [-1]
    if steps not in ([], list(range(count))):
        raise ValueError(
            f"the first {count} lines of {table} are not those of the steps before "
            f"step {count}: restore a copy of the file, or name another one"
        )
    return lines
