"""Output of a path: its results, a CSV file of them and a trajectory of states."""

from __future__ import annotations

import csv
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import asdict, dataclass, replace
from itertools import chain, islice
from pathlib import Path
from typing import Any, Protocol

from ase_roughcontact._util.files import (
    PathName,
    locked,
    refuse_link,
    table_rows,
    table_writer,
)
from ase_roughcontact._util.validation import one_of
from ase_roughcontact.contact import State
from ase_roughcontact.paths.path_steps import LastStep, PathSteps
from ase_roughcontact.paths.record import LoadStep, columns_of
from ase_roughcontact.paths.resume import FinishedSteps, Frame
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.paths.validity import ValidityReport

# Writes the result of a step, and its frame with a description of the path.
Write = Callable[..., None]


class Frames(Protocol):
    """Makes the frames of a trajectory, and reads states from them."""

    def frame(self, stepper: Stepper, **info: Any) -> Frame:
        """Return the frame of the last relaxed state."""
        ...

    def state(self, frame: Any) -> State:
        """Return the state of a frame."""
        ...

    def read(self, file: PathName) -> Iterator[Frame]:
        """Read one frame after another."""
        ...

    def writer(
        self, file: PathName, keep: str, kept: int
    ) -> AbstractContextManager[Callable[[Any], None]]:
        """Open a file for frames, of which it keeps all or the last one."""
        ...


@dataclass(frozen=True, kw_only=True)
class Output:
    """Results of a path, and the files to which they are written.

    Attributes
    ----------
    csv : path, optional
        CSV file of the results, one line per step, which is on disk before the next
        step begins.
    trajectory : path, optional
        ASE trajectory of snapshots, one per step.
    keep : {"all", "last"}
        Frames that the trajectory keeps. The last one is enough to resume.
    resume : bool
        Resume after the steps that `trajectory` already contains: they are yielded, but
        not calculated, again. The path may have been extended at its end. Lines of the
        CSV file for steps before those in the trajectory are kept.
    record : type
        Class of the results: `LoadStep`, or a subclass with more columns.
    frames : Frames, optional
        What makes the frames of a trajectory; `load_path` sets it.

    Raises
    ------
    ValueError
        If `resume` is set without a trajectory, or `keep` is unknown.
    TypeError
        If `record` is not a dataclass of columns.

    Examples
    --------
    >>> from ase_roughcontact import Output
    >>> output = Output(trajectory='sweep.traj', csv='curve.csv', resume=True)
    """

    csv: PathName | None = None
    trajectory: PathName | None = None
    keep: str = "all"
    resume: bool = False
    record: type[LoadStep] = LoadStep
    frames: Frames | None = None

    def __post_init__(self) -> None:
        """Check the options."""
        if self.resume and self.trajectory is None:
            raise ValueError("resume=True needs the trajectory to resume from")
        one_of(("all", "last"), keep=self.keep)
        columns_of(self.record)  # raises if it is not a class of results

    def of_record(self, kind: type[LoadStep], what: str) -> Output:
        """Return the output with results of a kind, or of one derived from it.

        Raises
        ------
        TypeError
            If the given one is not derived from it.
        """
        if self.record is LoadStep:
            return replace(self, record=kind)
        if not issubclass(self.record, kind):
            raise TypeError(
                f"results of a {what}: derive {self.record.__name__} from "
                f"{kind.__name__}"
            )
        return self


def follow(
    path: PathSteps, output: Output, validity: str, **description: Any
) -> Generator[Any, None, None]:
    """Yield the steps of a path, and write those that are not done yet.

    Parameters
    ----------
    path : PathSteps
    output : Output
    validity : {"warn", "raise", "ignore"}
        See `load_path`.
    **description
        What a state depends on beside the problem, such as springs.

    Returns
    -------
    generator of LoadStep
        Each after it is written; files are read and written as it advances.
    """
    path.record, report = output.record, ValidityReport(validity)
    if output.trajectory is not None:  # which carries it
        path.system = path.stepper.describe_system(**description)
    return _followed(path, output, report)


def _followed(
    path: PathSteps, output: Output, report: ValidityReport
) -> Generator[Any, None, None]:
    with open_output(output, path) as (finished, write):
        for step in finished.steps:
            report(step.step, step.validity)
            yield step
        last = None
        if finished.frame and output.frames:
            state = output.frames.state(finished.frame)
            last = LastStep(finished.steps[-1], state, finished.frame.info["path"])
        for step, described in path.remaining(last):
            write(step, path=described)
            report(step.step, step.validity)
            yield step


@contextmanager
def open_output(
    output: Output, path: PathSteps
) -> Iterator[tuple[FinishedSteps, Write]]:
    """Open the files of a path.

    Parameters
    ----------
    output : Output
    path : PathSteps
        Resumed from the trajectory, or started anew.

    Yields
    ------
    finished : FinishedSteps
        Steps from which the path is resumed.
    write : callable
        Called with the result of a step; writes it, and the frame of the last state
        with `info` given by keyword.

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
    finished, rows, add_frame = FinishedSteps(), None, None
    frames, file, table = output.frames, output.trajectory, output.csv
    with ExitStack() as files:
        if file is not None:
            if frames is None:
                raise ValueError("a trajectory needs frames: give Output(frames=...)")
            refuse_link(file)
            files.enter_context(locked(file))
            if output.resume:
                read, keep = frames.read(file), output.keep
                finished = path.finished_steps(read, file, keep)
            kept = len(finished.steps)
            add_frame = files.enter_context(frames.writer(file, output.keep, kept))
        if table is not None:
            first = finished.steps[0].step if finished.steps else 0
            known = chain(_lines(table, first), map(asdict, finished.steps))
            columns = {
                name: f"{name} ({each.unit})" if each.unit else name
                for name, each in columns_of(output.record).items()
            }
            rows = files.enter_context(table_writer(table, columns, known))

        def write(step: LoadStep, **info: Any) -> None:
            if frames is not None and add_frame is not None:
                add_frame(frames.frame(path.stepper, load_step=asdict(step), **info))
            if rows is not None:
                rows(asdict(step))

        yield finished, write


def _lines(table: PathName, count: int) -> Sequence[Mapping[str, str]]:
    """Return the lines of a table for the first steps, if it has any lines."""
    if not count or not Path(table).exists():
        return []
    try:
        with open(table, newline="", encoding="utf-8") as file:
            lines = list(islice(table_rows(file), count))
            steps = [int(line["step"]) for line in lines]
    except (KeyError, TypeError, ValueError, csv.Error):
        steps = [-1]
    if steps not in ([], list(range(count))):
        raise ValueError(
            f"the first {count} lines of {table} are not those of the steps before "
            f"step {count}: restore a copy of the file, or name another one"
        )
    return lines
