"""Steps of a path one after the other, resumed from its files and written to them."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from typing import Any

from ase_roughcontact.contact import State
from ase_roughcontact.paths.output import Output
from ase_roughcontact.paths.path_files import path_files
from ase_roughcontact.paths.path_steps import PathSteps
from ase_roughcontact.paths.restart import Restart
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.results.validity import Reaction, ValidityReport
from ase_roughcontact.stepping.relaxed import RelaxedStep


def follow(
    path: PathSteps,
    output: Output | None = None,
    validity: Reaction = "warn",
    **description: Any,
) -> Generator[Any, None, None]:
    """Return the results of the steps of a path; see `follow_states`.

    Parameters
    ----------
    path, output, validity, **description
        See `follow_states`.

    Returns
    -------
    generator of LoadStep
        The results, each after it is written.

    Raises
    ------
    TypeError, ValueError
        As `follow_states` does.
    """
    states = follow_states(path, output, validity, **description)

    def results() -> Generator[Any, None, None]:
        with closing(states):
            for record, _ in states:
                yield record

    return results()


def follow_states(
    path: PathSteps,
    output: Output | None = None,
    validity: Reaction = "warn",
    first: Callable[[], State] | None = None,
    **description: Any,
) -> Generator[tuple[Any, RelaxedStep | None], None, None]:
    """Return the steps of a path; relax and write those that are not finished yet.

    Parameters
    ----------
    path : PathSteps
    output : Output, optional
    validity : {"warn", "raise", "ignore"}
        See `load_path`.
    first : callable, optional
        Function that returns the state from which the path starts, called when it
        does; by default the state is `Stepper.start`.
    **description
        Parameters of a state beside the problem and the path, such as springs.

    Returns
    -------
    generator of (LoadStep, RelaxedStep or None)
        The result of each step after it is written, and the step as it leaves the
        surface; None for a step from a file before the last one there. Files are read
        and written as the generator advances. It raises `ValueError` if the restart
        file is damaged, or of another path or surface, `RuntimeError` if another run is
        writing the files, and `OSError` if a file can't be written or is a symbolic
        link.

    Raises
    ------
    TypeError
        If the class of the results is not derived from the class of the path.
    ValueError
        If the results have no such column.
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

    def steps() -> Generator[tuple[Any, RelaxedStep | None], None, None]:
        start = first() if first else stepper.start
        with path_files(path, output, record, new, start) as files:
            for earlier in files.earlier:
                report(earlier.step, earlier.validity)
                yield earlier, None
            if files.last is None:
                last = path.start(start)
            else:
                last = files.last
                report(last.number, last.record.validity)
                yield last.record, stepper.restored(last.state, last.target["target"])
            for step, left in path.steps(last, record):
                files.write(step, left)
                report(step.number, step.record.validity)
                yield step.record, left

    return steps()
