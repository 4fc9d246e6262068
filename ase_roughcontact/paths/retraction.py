"""Steps away from an attractive wall, which do not lose the contact by their length.

A surface that a wall holds follows the indenter in steps that are short compared to the
range of the attraction. After a longer step nothing may pull it any more, although the
contact would have held. Such a step is repeated in parts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from ase_roughcontact.paths.record import LoadStep, Step
from ase_roughcontact.paths.relaxed import RelaxedStep
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.paths.step_options import FREE

# Length of a part of a step, in units of the range of the attraction.
_PART = 0.5
# Class of results with which nothing is evaluated.
_RELAXED: Any = RelaxedStep


def step_in_contact(
    stepper: Stepper,
    number: int,
    target: float,
    record: type[Step] = LoadStep,  # type: ignore[assignment]
    completed: Callable[[RelaxedStep], RelaxedStep] | None = None,
) -> Step:
    """Relax a step; repeat it in parts if it loses a contact that the wall may hold.

    That is, if the wall acts on the surface before the step, the indenter is raised by
    more than half the range of the attraction, and no atom is in contact after it. The
    parts are at most that long. The surface has torn off when nothing acts on it.

    Parameters
    ----------
    stepper : Stepper
    number, target, record, completed
        See `Stepper.step`.

    Returns
    -------
    LoadStep
        Of the class of the results, with the cost of all parts.
    """
    parts = _parts(stepper, target)
    if len(parts) == 1:
        return stepper.step(number, target, record, completed=completed)
    before = stepper.state
    whole = stepper.step(number, target, _RELAXED)
    if whole.touches and completed is None:
        return record.of(whole)
    spent = [whole]
    if not whole.touches:
        stepper.restart_from(before)
        spent += _until_torn(stepper, number, parts[:-1])

    def with_all_costs(relaxed: RelaxedStep) -> RelaxedStep:
        relaxed = _with_costs(relaxed, spent)
        return completed(relaxed) if completed else relaxed

    return stepper.step(number, target, record, completed=with_all_costs)


def _parts(stepper: Stepper, target: float) -> np.ndarray:
    """Return the targets of the parts of a step, the last of which is its own."""
    wall, control = stepper.problem.wall, stepper.control
    if not wall.attractive or control in FREE or not stepper.state.displaced:
        return np.array([target])
    first = stepper.state.height
    if control == "penetrations":
        first = stepper.windows.first_contact - first
    rise = target - first if control == "heights" else first - target
    count = max(1, math.ceil(rise / (_PART * wall.attraction_range)))
    return np.linspace(first, target, count + 1)[1:]


def _until_torn(
    stepper: Stepper, number: int, targets: np.ndarray
) -> Iterator[RelaxedStep]:
    """Yield the parts of a step while the wall acts on the surface."""
    for target in targets:
        yield stepper.step(number, float(target), _RELAXED)
        if not stepper.state.displaced:
            return


def _with_costs(relaxed: RelaxedStep, others: list[RelaxedStep]) -> RelaxedStep:
    """Return a step with the iterations, FFT pairs and seconds of others added."""
    run = relaxed.run
    iterations = run.iterations + sum(each.run.iterations for each in others)
    pairs = run.pairs + sum(each.run.pairs for each in others)
    seconds = relaxed.seconds + sum(each.seconds for each in others)
    return replace(
        relaxed, run=replace(run, iterations=iterations, pairs=pairs), seconds=seconds
    )
