"""Results of a sliding path in time: friction coefficients and energies."""

from __future__ import annotations

import math

import numpy as np

from ase_roughcontact.analysis.path_values import friction_coefficients
from ase_roughcontact.scene.path_result import FinishedPath, PathResult


def _touches(done: FinishedPath) -> bool:
    return any(step.repulsive_atoms for step in done.steps)


def _last_hold(done: FinishedPath) -> float:
    """Return the time at which the last hold before a slide ends, NaN without one."""
    schedule = done.path.lateral_schedule(done.bodies)
    parts, found = list(schedule.timed_parts()), math.nan
    for begin, start, part in parts[:-1]:
        if part.end == start and not part.amplitude:
            found = begin + part.duration
    return found


def _after_hold(done: FinishedPath) -> float:
    end = _last_hold(done)
    times = np.array([step.time for step in done.steps])
    return float(np.nanmax(friction_coefficients(done.steps)[times >= end]))


#: Results of sliding paths in time by name.
RESULTS = {
    "largest_friction_coefficient": PathResult(
        lambda done: float(np.nanmax(friction_coefficients(done.steps))),
        "largest ratio of lateral and normal force",
        label="largest friction",
        where="paths in contact",
        includes=_touches,
    ),
    "last_friction_coefficient": PathResult(
        lambda done: float(friction_coefficients(done.steps)[-1]),
        "ratio of lateral and normal force at the end",
        label="last friction",
        where="paths in contact",
        includes=_touches,
    ),
    "friction_after_hold": PathResult(
        _after_hold,
        "largest ratio of lateral and normal force after the last hold",
        label="friction after the hold",
        where="paths in contact with a hold before a slide",
        includes=lambda done: _touches(done) and not math.isnan(_last_hold(done)),
    ),
    "largest_slip_rate": PathResult(
        lambda done: float(np.nanmax([step.slip_rate for step in done.steps])),
        "largest mean slip rate",
        "Å/s",
        "largest rate",
        "paths in contact",
        _touches,
    ),
    "total_dissipated_energy": PathResult(
        lambda done: done.steps[-1].dissipated_energy,
        "energy lost by slip during the path",
        "eV",
        "lost energy",
    ),
}
