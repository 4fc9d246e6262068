"""What can be known of a path before it is calculated: failing steps, and a plan."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import replace
from functools import partial

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.contact import Problem
from ase_roughcontact.elasticity import Crystal, Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.paths.plan import LATERAL_LEFT_OUT, plan_path
from ase_roughcontact.paths.planned_steps import Plan, PlannedStep, thinned
from ase_roughcontact.paths.record import size_of
from ase_roughcontact.scene.path_kinds import PathKind
from ase_roughcontact.windows.expected import ExpectedContact, coarsened
from ase_roughcontact.windows.memory import frame_memory, friction_memory

# Number of steps up to which an error lists them.
_MOST_LISTED = 20


def check_targets(
    path: PathKind, targets: FloatArray, expected: ExpectedContact
) -> None:
    """Raise an error if a step certainly can't be calculated in automatic windows.

    Parameters
    ----------
    path : PathKind
    targets : ndarray
        Of the path.
    expected : ExpectedContact

    Raises
    ------
    ValueError
        If atoms touch where the roughness is not defined.
    MemoryError
        If a contact exceeds the free memory.
    """
    steps, control = np.sort(targets), f"{path.control}s"
    if control == "heights":  # the deepest one last
        steps = steps[::-1]
    problems = dict[int, ValueError | MemoryError]()

    def fails(number: int) -> bool:
        try:
            expected.check(control, float(steps[number]))
        except (ValueError, MemoryError) as error:
            problems[number] = error
        return number in problems

    if fails(len(steps) - 1):
        first = bisect_left(range(len(steps)), True, key=fails)
        error = problems[len(steps) - 1]  # what the others need is less
        kind = MemoryError if isinstance(error, MemoryError) else ValueError
        raise kind(_without(path, targets, steps[first:], str(error))) from error


def _without(
    path: PathKind, targets: FloatArray, failing: FloatArray, problem: str
) -> str:
    """Return a message that steps can't be calculated, and how to omit them."""
    unit = UNITS[path.unit]
    first, last = failing[[0, -1]] / unit
    kept = targets[~np.isin(targets, failing)] / unit
    which = f"{first:g}" if first == last else f"{first:g} to {last:g}"
    text = f"[path] {path.control} of {which} {path.unit}: {problem}"
    if not kept.size:
        return text
    if kept.size > _MOST_LISTED:
        return f"{text}; or leave out the {len(failing)} steps from {first:g} on"
    return f"{text}; or give values = [{', '.join(f'{k:.6g}' for k in kept)}]"


def plan_targets(
    problem: Problem,
    window: Box,
    control: str,
    targets: FloatArray,
    expected: ExpectedContact,
    fixed: bool,
) -> Plan:
    """Return the windows, memory and time of the steps of a path.

    Very large automatic windows and roughnesses are planned on a coarser lattice.

    Parameters
    ----------
    problem, window, control
        See `plan_path`.
    targets : ndarray
    expected : ExpectedContact
    fixed : bool
        Whether all steps have the same window.

    Returns
    -------
    Plan
    """
    planner = partial(plan_path, indenter=expected.indenter, spacing=expected.spacing)
    if fixed:
        return planner(problem, window, control, targets, "fixed")
    targets, counts = thinned(targets)
    ratios = np.array([expected.coarsening(control, t) for t in targets.tolist()])
    plans, planned = {}, dict[float, PlannedStep]()
    for ratio in np.unique(ratios).tolist():
        lattice = problem if ratio <= 1 else _coarse_problem(expected, ratio)
        part = targets[ratios == ratio]
        plans[ratio] = planner(lattice, window, control, part, "auto")
        planned |= {step.target: step for step in plans[ratio].steps}
    failing = next((p for p in reversed(plans.values()) if p.advice), plans[ratio])
    return replace(
        failing,
        steps=tuple(
            replace(planned[target], count=count)
            for target, count in zip(targets.tolist(), counts.tolist(), strict=True)
        ),
    )


def with_frames(plan: Plan) -> Plan:
    """Return a plan with the memory of the frames that a run writes and draws."""
    steps = (
        replace(s, memory=s.memory + frame_memory(size_of(s.window))) if s.window else s
        for s in plan.steps
    )
    return replace(plan, steps=tuple(steps))


def with_friction(plan: Plan, coupled: bool = False) -> Plan:
    """Return a plan with the memory of friction, and what this leaves out.

    Steps with equal targets are one. The coupling of normal and lateral motion is left
    out unless it is solved for.
    """
    distinct = {step.target: step for step in plan.steps}
    sizes = {t: size_of(step.window) for t, step in distinct.items() if step.window}
    steps = (
        replace(
            step,
            count=sum(s.count for s in plan.steps if s.target == target),
            memory=step.memory + friction_memory(sizes.get(target, 0), coupled),
        )
        for target, step in distinct.items()
    )
    left_out = (
        "changes of the heights by sliding, which must be small compared to the "
        "roughness"
    )
    if not coupled:
        left_out += (
            ", and of the pressure by lateral tractions: none for a Poisson's ratio of "
            "1/2"
        )
    others = (text for text in plan.left_out if text != LATERAL_LEFT_OUT)
    return replace(plan, steps=tuple(steps), left_out=(left_out, *others))


def _coarse_problem(expected: ExpectedContact, ratio: int) -> Problem:
    """Return the problem with which a plan is made on a coarser lattice."""
    surface, spacing = coarsened(expected.indenter, expected.spacing, ratio)
    solid = expected.solid  # a crystal has only the spacing of its own
    if isinstance(solid, Crystal):
        solid = Isotropic(solid.contact_modulus)
    return Problem(surface, solid, expected.wall, spacing)
