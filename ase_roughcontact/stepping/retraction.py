"""Steps away from an attractive wall, which do not lose the contact by their length.

A surface that a wall holds follows the indenter in steps that are short compared to the
range of the attraction. In a longer step the contact, or asperities of a rough one, may
be lost although they would have held. Such a step is made in parts.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ase_roughcontact._util.rounding import RATIO_ROUNDING
from ase_roughcontact.contact import State
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.stepping.step import Stepper

# Largest part of a step, in units of the range of the attraction.
_MAX_RELATIVE_PART = 0.5


def relax_in_contact(
    stepper: Stepper, state: State, target: float, number: int = 0
) -> RelaxedStep:
    """Relax a step, in parts if it is a long one away from an attractive wall.

    A step is made in parts if the wall acts on the surface and the indenter is raised
    by more than half the range of the attraction. A part is at most half that range.
    When the wall acts on no atom, the surface has torn off.

    Parameters
    ----------
    stepper : Stepper
    state, target, number
        See `Stepper.relax`.

    Returns
    -------
    RelaxedStep
        The relaxed step, with the statistics of all parts added.
    """
    spent = list[RelaxedStep]()
    for part in _targets_between(stepper, state, target):
        spent.append(stepper.relax(state, part, number=number))
        state = stepper.commit(spent[-1]).state
        if not state.displaced:
            break
    return _with_costs(stepper.relax(state, target, number=number), spent)


def _targets_between(stepper: Stepper, state: State, target: float) -> list[float]:
    """Return the targets of the parts of a step before its own target."""
    wall, control = stepper.problem.wall, stepper.control
    if not wall.attractive or control.free or not state.displaced:
        return []
    first = control.target(state.height, stepper.windows.first_contact)
    rise = control.deeper * (first - target)
    parts = rise / (_MAX_RELATIVE_PART * wall.attraction_range)
    count = max(1, math.ceil(parts - RATIO_ROUNDING))
    return np.linspace(first, target, count + 1)[1:-1].tolist()


def _with_costs(relaxed: RelaxedStep, others: list[RelaxedStep]) -> RelaxedStep:
    """Return a step with the iterations, FFT pairs and seconds of others added."""
    run = relaxed.run
    iterations = run.iterations + sum(each.run.iterations for each in others)
    pairs = run.pairs + sum(each.run.pairs for each in others)
    seconds = relaxed.seconds + sum(each.seconds for each in others)
    return replace(
        relaxed, run=replace(run, iterations=iterations, pairs=pairs), seconds=seconds
    )
