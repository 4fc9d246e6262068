"""Results of a sliding path: static friction, stiffness, energies."""

from __future__ import annotations

import math

from ase_roughcontact.analysis.path_values import loop_energies, static_friction
from ase_roughcontact.results.record import columns_of
from ase_roughcontact.scene.path_result import FinishedPath, PathResult


def _touches(done: FinishedPath) -> bool:
    return any(step.repulsive_atoms for step in done.steps)


def _last_loop(done: FinishedPath) -> float:
    energies = loop_energies(done.steps)
    return float(energies[-1]) if len(energies) else math.nan


def _with_stiffness(done: FinishedPath) -> bool:
    return _touches(done) and "lateral_stiffness" in columns_of(type(done.steps[0]))


def _stiffness(done: FinishedPath) -> float:
    touching = [step for step in done.steps if step.repulsive_atoms]
    return float(touching[-1].lateral_stiffness)


#: Results of sliding paths by name.
RESULTS = {
    "static_friction": PathResult(
        lambda done: static_friction(done.steps),
        "largest lateral force of the first slide",
        "eV/Å",
        "static friction",
        "paths on which all atoms in contact slip in a step",
        _touches,
    ),
    "loop_energy": PathResult(
        _last_loop,
        "energy dissipated in the last closed loop of lateral displacement",
        "eV",
        "energy of a loop",
        "paths back and forth in contact",
        _touches,
    ),
    "total_dissipated_energy": PathResult(
        lambda done: done.steps[-1].dissipated_energy,
        "energy lost by slip during the path",
        "eV",
        "lost energy",
    ),
    "total_released_energy": PathResult(
        lambda done: done.steps[-1].released_energy,
        "energy released by instabilities of friction that weakens by slip",
        "eV",
        "released energy",
    ),
    "stiffness_without_slip": PathResult(
        _stiffness,
        "derivative of the lateral force along x to the displacement if no atom slips, "
        "in the last step in contact",
        "eV/Å^2",
        "stiffness without slip",
        'paths in contact with [output] columns = ["lateral_stiffness"]',
        _with_stiffness,
    ),
}
