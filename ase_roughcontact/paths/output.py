"""Output of a path: its results, a CSV file of them and a trajectory of states."""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, closing
from dataclasses import asdict, dataclass, replace
from itertools import chain, islice
from pathlib import Path
from typing import Any, Protocol

from ase_roughcontact._util.files import (
    PathName,
    check_different,
    locked,
    refuse_link,
    table_rows,
    table_writer,
)
from ase_roughcontact._util.validation import boolean, instance_of, one_of
from ase_roughcontact.contact import State
from ase_roughcontact.paths.path_steps import Frame, LastStep, PathSteps
from ase_roughcontact.results.record import LoadStep, columns_of, missing_values
from ase_roughcontact.results.validity import ValidityReport
from ase_roughcontact.stepping.relaxed import RelaxedStep


class Frames(Protocol):
    """Makes the frames of a trajectory, and reads states from them."""

    def frame(self, left: RelaxedStep, **info: Any) -> Frame:
        """Return the frame of a step as it leaves the surface."""
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
    columns : sequence of str, optional
        Names of columns that are calculated where they are asked for, such as
        ``["conductance"]``; by default those of the class. Steps that are resumed have
        what they were calculated with.
    frames : Frames, optional
        What makes the frames of a trajectory; `load_path` sets it.

    Raises
    ------
    ValueError
        If `resume` is set without a trajectory, both files are one, or `keep` is
        unknown.
    TypeError
        If `record` is not a dataclass of columns, or a file no path.

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
    columns: Sequence[str] | None = None
    frames: Frames | None = None

    def __post_init__(self) -> None:
        """Check the options."""
        if self.resume and self.trajectory is None:
            raise ValueError("resume=True needs the trajectory to resume from")
        one_of(("all", "last"), keep=self.keep)
        boolean(resume=self.resume)
        for name in ("csv", "trajectory"):
            if getattr(self, name) is not None:
                instance_of((str, os.PathLike), **{name: getattr(self, name)})
        instance_of(type, record=self.record)
        if self.csv is not None and self.trajectory is not None:
            check_different(csv=self.csv, trajectory=self.trajectory)
        columns_of(self.record)  # raises if it is not a class of results


@dataclass(frozen=True)
class Done:
    """Step of a path that is done.

    Attributes
    ----------
    record : LoadStep
    left : RelaxedStep or None
        The step as it leaves the surface; None if a later one was read from a file.
    relaxed : bool
        Whether it was relaxed now, not read from a file.
    """

    record: Any
    left: RelaxedStep | None = None
    relaxed: bool = False


def follow(
    path: PathSteps,
    output: Output | None = None,
    validity: str = "warn",
    **description: Any,
) -> Generator[Any, None, None]:
    """Yield the steps of a path, and write those that are not done yet.

    Parameters
    ----------
    path : PathSteps
    output : Output, optional
    validity : {"warn", "raise", "ignore"}
        See `load_path`.
    **description
        What a state depends on beside the problem and the path, such as springs.

    Returns
    -------
    generator of LoadStep
        Each after it is written; files are read and written as it advances.

    Raises
    ------
    TypeError
        If the class of the results is not derived from that of the path.
    ValueError
        If the results have no such column.
    """
    return _records(follow_states(path, output, validity, **description))


def _records(steps: Generator[Done, None, None]) -> Generator[Any, None, None]:
    with closing(steps):
        for done in steps:
            yield done.record


def follow_states(
    path: PathSteps,
    output: Output | None = None,
    validity: str = "warn",
    first: Callable[[], State] | None = None,
    **description: Any,
) -> Generator[Done, None, None]:
    """Yield the steps of a path with their states, and write those not done yet.

    Parameters
    ----------
    path, output, validity, **description
        See `follow`.
    first : callable, optional
        Returns the state from which the path starts when it does, by default
        `Stepper.start`.

    Returns
    -------
    generator of Done

    Raises
    ------
    TypeError
        As `follow` does.
    """
    output, report, kind = output or Output(), ValidityReport(validity), path.kind
    record = kind if output.record is LoadStep else output.record
    if not issubclass(record, kind):
        raise TypeError(
            f"the results of this path are of the class {kind.__name__}: derive "
            f"{record.__name__} from {kind.__name__}"
        )
    record, system = record.with_columns(output.columns), None
    if output.trajectory is not None:  # which carries it
        system = path.stepper.describe_system(**path.parameters, **description)
    return _followed(path, output, report, record, system, first)


def _followed(
    path: PathSteps,
    output: Output,
    report: ValidityReport,
    record: type[LoadStep],
    system: dict[str, Any] | None,
    first: Callable[[], State] | None,
) -> Generator[Done, None, None]:
    """Yield the steps in the trajectory, and then the others as they are written.

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
    frames, file, control = output.frames, output.trajectory, path.stepper.control.name
    done, last, add_frame, add_row = list[LoadStep](), None, None, None
    with ExitStack() as files:
        if file is not None and system is not None:
            if frames is None:
                raise ValueError("a trajectory needs frames: give Output(frames=...)")
            refuse_link(file)
            files.enter_context(locked(file))
            if output.resume:
                done, frame = path.finished_steps(
                    frames.read(file), record, system, file, output.keep
                )
                if frame:
                    last = _last_step(frames, frame, done[-1])
            add_frame = files.enter_context(frames.writer(file, output.keep, len(done)))
        if output.csv is not None:
            lines = _lines(output.csv, done[0].step if done else 0)
            before = (missing_values(record) | dict(line) for line in lines)
            known = chain(before, map(asdict, done))
            heads = {
                name: f"{name} ({each.unit})" if each.unit else name
                for name, each in columns_of(record).items()
            }
            add_row = files.enter_context(table_writer(output.csv, heads, known))
        for step in done:
            report(step.step, step.validity)
            left = None
            if last is not None and step is last.step:
                left = path.stepper.restored(last.state, last.path["target"])
            yield Done(step, left)
        start = path.stepper.start
        if last is not None:
            start = last.state
        elif first is not None:
            start = first()
        for new in path.steps(start, record, last):
            if frames and add_frame:
                info = {"system": system, "control": control} | new.path
                info["mean_force"] = new.left.state.mean_force
                columns = asdict(new.record)
                add_frame(frames.frame(new.left, load_step=columns, path=info))
            if add_row:
                add_row(asdict(new.record))
            report(new.record.step, new.record.validity)
            yield Done(new.record, new.left, relaxed=True)


def _last_step(frames: Frames, frame: Any, step: LoadStep) -> LastStep:
    """Return the last step of a trajectory, with the state of its frame."""
    path = frame.info["path"]
    state = replace(frames.state(frame), mean_force=path["mean_force"])
    return LastStep(step, state, path)


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
