"""Cases that can't be calculated, found before they run."""

from __future__ import annotations

from collections.abc import Iterable

from ase_roughcontact._util.callers import warn
from ase_roughcontact.paths.plan import plan_path
from ase_roughcontact.paths.planned_steps import Plan
from ase_roughcontact.results.record import shape_of
from ase_roughcontact.scene import Scene


def foreseen_problem(scene: Scene) -> str:
    """Return why the deepest known target of a path can't be calculated, with advice.

    The roughness is generated for this, but nothing is relaxed. Adhesion may extend a
    contact beyond the planned window.

    Parameters
    ----------
    scene : Scene
        Valid scene.

    Returns
    -------
    str
        The reason, such as atoms that can touch beyond the domain of the roughness, and
        the remedy; empty if no problem is foreseen.
    """
    try:
        plan = _deepest_step(scene)
    except (ValueError, MemoryError) as error:
        return str(error)
    return ": ".join(filter(None, [plan.steps[0].problem, plan.advice]))


def expected_width(scene: Scene) -> float:
    """Return the larger side of the window at the deepest known target (Å).

    It is zero if there is none, as this step can't be calculated.
    """
    try:
        (step,) = _deepest_step(scene).steps
    except (ValueError, MemoryError):
        return 0.0
    spacing = scene.planned.problem.spacing
    return max(shape_of(step.window)) * spacing if step.window else 0.0


def _deepest_step(scene: Scene) -> Plan:
    """Return the plan of the deepest known target."""
    planned = scene.planned
    deepest = planned.path.deepest_of(planned.targets.tolist())
    return plan_path(
        planned.problem, planned.start, planned.control, [deepest], planned.window
    )


def warn_of_problems(named: Iterable[tuple[str, Scene]]) -> None:
    """Warn of cases that probably fail, with the first one, the reason and the remedy.

    Parameters
    ----------
    named : iterable of (str, Scene)
        Names of cases by their values, and the scenes.
    """
    total = 0
    found: dict[str, str] = {}
    for name, scene in named:
        total += 1
        problem = foreseen_problem(scene)
        if problem:
            found[name] = problem
    if found:
        name, problem = next(iter(found.items()))
        warn(f"{len(found)} of {total} will probably fail, first {name}: {problem}")
