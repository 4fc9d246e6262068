"""Steps of a path one after the other, resumed from its files and written to them."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from dataclasses import dataclass
from typing import Any

from ase_roughcontact.contact import State
from ase_roughcontact.paths.output import Output
from ase_roughcontact.paths.path_files import path_files
from ase_roughcontact.paths.path_steps import PathSteps
from ase_roughcontact.paths.restart import Restart
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.results.validity import ValidityReport
from ase_roughcontact.stepping.relaxed import RelaxedStep


@dataclass(frozen=True)
class Done:
    """Finished step of a path.

    Attributes
    ----------
    record : LoadStep
        Result of the step.
    left : RelaxedStep or None
        The step as it leaves the surface; None if a later one was read from a file.
    relaxed : bool
        Whether the step was relaxed in this run, not read from a file.
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
    """Yield the steps of a path, and write the ones that are not finished yet.

    Parameters
    ----------
    path : PathSteps
    output : Output, optional
    validity : {"warn", "raise", "ignore"}
        See `load_path`.
    **description
        Parameters of a state beside the problem and the path, such as springs.

    Returns
    -------
    generator of LoadStep
        The results, each after it is written. Files are read and written as the
        generator advances.

    Raises
    ------
    TypeError
        If the class of the results is not derived from the class of the path.
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
    """Yield the steps of a path with their states, and write the unfinished ones.

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
    record, stepper = record.with_columns(output.columns), path.stepper
    new: Restart | None = None
    if output.restart_file is not None:  # it has the descriptions
        system = stepper.describe_system(**path.parameters, **description)
        new = Restart(system, path.described, stepper.describe_settings())
    return _followed(path, output, report, record, new, first)


def _followed(
    path: PathSteps,
    output: Output,
    report: ValidityReport,
    record: type[LoadStep],
    new: Restart | None,
    first: Callable[[], State] | None,
) -> Generator[Done, None, None]:
    """Yield the steps in the restart file, and then the others as they are written.

    Raises
    ------
    ValueError
        If the restart file is damaged or of another path.
    RuntimeError
        If another run is writing the files.
    OSError
        If a file can't be written, or is a symbolic link.
    """
    with path_files(path, output, record, new) as files:
        last, start = files.last, path.stepper.start
        for step in files.done:
            report(step.step, step.validity)
            left = None
            if last is not None and step is last.record:
                left = path.stepper.restored(last.state, last.target["target"])
            yield Done(step, left)
        if last is not None:
            start = last.state
        elif first is not None:
            start = first()
        for added in path.steps(start, record, last):
            files.write(added)
            report(added.record.step, added.record.validity)
            yield Done(added.record, added.left, relaxed=True)
