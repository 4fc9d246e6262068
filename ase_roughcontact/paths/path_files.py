"""Files of a path: their finished steps, and how a step is added."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ase_roughcontact._util.files import PathName, refuse_link, table_writer
from ase_roughcontact._util.identity import differences
from ase_roughcontact._util.locks import locked
from ase_roughcontact.contact import State
from ase_roughcontact.paths.output import Output
from ase_roughcontact.paths.path_steps import OtherPathError, PathStep, PathSteps
from ase_roughcontact.paths.restart import (
    FinishedStep,
    Restart,
    RestartWriter,
    read_restart,
)
from ase_roughcontact.results.limits import marked_for_hardness
from ase_roughcontact.results.record import LoadStep, columns_of
from ase_roughcontact.stepping.relaxed import RelaxedStep


@dataclass(frozen=True)
class PathFiles:
    """Finished steps of a path, and the files to which others are added.

    Attributes
    ----------
    earlier : list of LoadStep
        Results of the finished steps before the last one.
    last : PathStep or None
        The last finished step; None without one.
    """

    earlier: list[LoadStep]
    last: PathStep | None
    _add_frame: Callable[[PathStep, RelaxedStep, dict[str, Any]], None] | None
    _restart: RestartWriter | None
    _add_row: Callable[[Mapping[str, Any]], None] | None

    def write(self, step: PathStep, left: RelaxedStep) -> None:
        """Add a step, with the frame of the surface as the step leaves it.

        The restart file is written even if the frame can't be.

        Raises
        ------
        OSError
            If a file can't be written, or was removed since the last step.
        """
        names = columns_of(type(step.record))
        columns = {name: getattr(step.record, name) for name in names}
        try:
            if self._add_frame:
                self._add_frame(step, left, columns)
        except OSError:
            if self._restart:
                with suppress(OSError):  # the first error is raised
                    _add_to_restart(self._restart, step, columns)
            raise
        if self._restart:
            _add_to_restart(self._restart, step, columns)
        if self._add_row:
            self._add_row(columns)


@contextmanager
def path_files(
    path: PathSteps,
    output: Output,
    record: type[LoadStep],
    new: Restart | None,
    start: State,
) -> Iterator[PathFiles]:
    """Open the files of a path.

    Parameters
    ----------
    path : PathSteps
    output : Output
    record : type
        Class of the results.
    new : Restart or None
        Description of the path without steps; None without a restart file.
    start : State
        State of the surface before the path.

    Yields
    ------
    PathFiles

    Raises
    ------
    ValueError
        If a file to resume from is damaged, or of another path, or if the surface has
        another history than at the start of the path there or at its end.
    RuntimeError
        If another run is writing the files.
    OSError
        If a file can't be written, or is a symbolic link.
    """
    done, last = list[LoadStep](), None
    add_frame, writer, add_row = None, None, None
    with ExitStack() as files:
        if new is not None and (file := output.restart_file) is not None:
            restart, written = new, None
            Path(file).parent.mkdir(parents=True, exist_ok=True)
            # each file may be written without the other one by another run
            written_files = [name for name in (output.trajectory, file) if name]
            for name in written_files:
                refuse_link(name)
            files.enter_context(locked(*written_files))
            if output.resume:
                found = read_restart(file)
                written = len(found.steps) if found else 0
                if found:
                    restart = _resumed(path, found, new, file)
                    _check_history(start, found, file)
                done = restart.records(record)
            if not done:
                before = {0: start.flattened(start.height)} if start.history else {}
                restart = replace(new, states=before)
            else:
                target, _, position = restart.steps[-1]
                state, place = restart.states[len(done)], path.position(**position)
                last = PathStep(done[-1], state, target, place)
            writer = RestartWriter(file, restart)
            if output.trajectory is not None:
                add_frame = files.enter_context(_frames(path, output, written))
        if output.csv is not None:
            heads = {
                name: f"{name} ({each.unit})" if each.unit else name
                for name, each in columns_of(record).items()
            }
            rows = table_writer(output.csv, heads, map(asdict, done))
            add_row = files.enter_context(rows)
        yield PathFiles(done[:-1], last, add_frame, writer, add_row)


def _resumed(path: PathSteps, found: Restart, new: Restart, file: PathName) -> Restart:
    """Return the steps of a file that a path continues, with new descriptions."""
    path.check(found, new.system, file)
    if _may_converge(found.settings, new.settings):
        found = found.until_converged()
    steps, limits = found.steps, _limits_of_pressure(new.settings)
    if differences(_limits_of_pressure(found.settings), limits):
        steps = tuple(_marked(step, limits) for step in steps)
    return replace(new, steps=steps, states=found.states)


def _check_history(start: State, found: Restart, file: PathName) -> None:
    """Raise an error if a surface does not have the history of a path that it resumes.

    It is the history at the start of the path, or after its last step.
    """
    before = found.states.get(0, State.flat(start.window, start.height))
    changed = before.changed_entries(start)
    last = found.states.get(len(found.steps))
    if changed and (last is None or last.changed_entries(start)):
        raise OtherPathError(
            f"can't resume: the surface has another {', '.join(changed)} than at the "
            f"start or the end of the path in {os.fspath(file)}: give the atoms with "
            "which it began, or another file"
        )


def _may_converge(old: Mapping[str, Any], new: Mapping[str, Any]) -> bool:
    """Return whether unconverged steps may converge with other settings."""
    more = new["max_steps"] > old["max_steps"]
    return more or new["optimizer"] != old["optimizer"]


def _limits_of_pressure(settings: Mapping[str, Any]) -> dict[str, float]:
    """Return the hardness and its bound."""
    return {"hardness": settings["hardness"], "bound": settings["hardness_bound"]}


def _marked(step: FinishedStep, limits: Mapping[str, float]) -> FinishedStep:
    """Return a step, marked where pressures exceed the hardness or its bound."""
    validity = marked_for_hardness(step.columns, **limits)
    return step._replace(columns=step.columns | {"validity": validity})


def _add_to_restart(
    restart: RestartWriter, step: PathStep, columns: dict[str, Any]
) -> None:
    position = asdict(step.position)
    restart.add(FinishedStep(step.target, columns, position), step.state)


@contextmanager
def _frames(
    path: PathSteps, output: Output, finished: int | None
) -> Iterator[Callable[[PathStep, RelaxedStep, dict[str, Any]], None]]:
    """Open the trajectory, and yield what adds the frame of a step."""
    frames, control = output.frames, path.stepper.control.name
    if frames is None or output.trajectory is None:
        raise ValueError("a trajectory needs frames: give Output(frames=...)")
    with frames.writer(output.trajectory, output.keep, finished) as add:

        def add_frame(
            step: PathStep, left: RelaxedStep, columns: dict[str, Any]
        ) -> None:
            described = {"control": control} | step.target
            add(frames.frame(left, load_step=columns, path=described))

        yield add_frame
