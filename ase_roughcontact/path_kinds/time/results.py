"""Results of a path in time: forces, energies, creep, stiffness."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import partial
from typing import Any

from ase_roughcontact.analysis.path_values import dynamic_stiffness
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.scene.path_result import FinishedPath, PathResult


def _holds(done: FinishedPath) -> Iterator[tuple[Any, Any]]:
    """Yield the first and the last step of each hold at the deepest target."""
    schedule = done.path.schedule(done.bodies)
    parts = list(schedule.timed_parts())
    deepest = done.path.deepest_of([schedule.first, *(part.end for *_, part in parts)])
    for begin, start, part in parts:
        if start == part.end == deepest and not part.amplitude:
            yield _step_at(done, begin), _step_at(done, begin + part.duration)


def _step_at(done: FinishedPath, time: float) -> Any:
    return min(done.steps, key=lambda step: abs(step.time - time))


def _creep_depth(done: FinishedPath) -> float:
    return sum(last.penetration - first.penetration for first, last in _holds(done))


def _relaxed_force(done: FinishedPath) -> float:
    return sum(first.normal_force - last.normal_force for first, last in _holds(done))


def _holds_load(done: FinishedPath) -> bool:
    return done.path.controlled == LOAD and any(_holds(done))


def _holds_depth(done: FinishedPath) -> bool:
    return done.path.controlled != LOAD and any(_holds(done))


def _stiffness(done: FinishedPath, part: str) -> float:
    """Return the real or imaginary part of the stiffness, NaN if it is not known."""
    try:
        stiffness = dynamic_stiffness(done.steps, done.path.frequency)
    except ValueError:  # too few cycles
        return math.nan
    return float(getattr(stiffness, part))


def _oscillates(done: FinishedPath) -> bool:
    return done.path.frequency is not None


#: Results of paths in time by name.
RESULTS = {
    "largest_force": PathResult(
        lambda done: max(step.normal_force for step in done.steps),
        "largest normal force",
        "eV/Å",
        "largest force",
    ),
    "pull_off_force": PathResult(
        lambda done: max(0.0, -min(step.normal_force for step in done.steps)),
        "largest tension; a lower bound if the tip is still pulled where its "
        "retraction begins",
        "eV/Å",
        "pull-off force",
        "walls that attract",
        lambda done: done.bodies.wall.attractive,
        theory=lambda sphere: sphere.pull_off_force,
        is_lower_bound=lambda done: bool(done.path.warnings(done.bodies, done.steps)),
    ),
    "creep_depth": PathResult(
        _creep_depth,
        "growth of the penetration while the largest load is held",
        "Å",
        "creep depth",
        "paths under control of the load that hold the largest one",
        _holds_load,
    ),
    "relaxed_force": PathResult(
        _relaxed_force,
        "decrease of the force while the deepest target is held",
        "eV/Å",
        "relaxed force",
        "paths under control of penetration, height or base that hold the deepest one",
        _holds_depth,
    ),
    "total_dissipated_energy": PathResult(
        lambda done: sum(step.dissipated_energy for step in done.steps),
        "energy that the solid has dissipated",
        "eV",
        "dissipated energy",
    ),
    "total_lost_energy": PathResult(
        lambda done: sum(step.lost_energy for step in done.steps),
        "energy lost in instabilities at the instantaneous modulus",
        "eV",
        "lost energy",
    ),
    "storage_stiffness": PathResult(
        partial(_stiffness, part="real"),
        "real part of the dynamic stiffness at the end of the path",
        "eV/Å^2",
        "storage stiffness",
        "paths with two cycles of an oscillation or more",
        _oscillates,
    ),
    "loss_stiffness": PathResult(
        partial(_stiffness, part="imag"),
        "imaginary part of the dynamic stiffness at the end of the path",
        "eV/Å^2",
        "loss stiffness",
        "paths with two cycles of an oscillation or more",
        _oscillates,
    ),
}
