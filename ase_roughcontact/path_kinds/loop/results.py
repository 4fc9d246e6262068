"""Results of a loop: pull-off force, dissipated energy, instabilities."""

from __future__ import annotations

import math

from ase_roughcontact.path_kinds.loop.cantilever import cantilever_curve
from ase_roughcontact.scene.path_result import FinishedPath, PathResult

_ON_CANTILEVER = "loops with a cantilever that does not jump in beyond the turn"


def _on_cantilever(done: FinishedPath, attribute: str) -> float:
    """Return a number of the force curve of the cantilever, NaN without a curve."""
    stiffness = done.path.stiffness
    if stiffness is None:
        return math.nan
    try:
        curve = cantilever_curve(done.result, stiffness)
    except ValueError:  # it jumps in beyond the turn
        return math.nan
    return float(getattr(curve, attribute))


#: Results of `AdhesionLoop` by name.
RESULTS = {
    "pull_off_force": PathResult(
        lambda done: done.result.pull_off_force,
        "largest tension during retraction; a lower bound if the tip is still pulled "
        "where it turns",
        "eV/Å",
        "pull-off force",
        theory=lambda sphere: sphere.pull_off_force,
        is_lower_bound=lambda done: done.result.turns_in_tension,
    ),
    "dissipated_energy": PathResult(
        lambda done: done.result.dissipated_energy,
        "area of the loop of force against height",
        "eV",
        "dissipated energy",
        error="dissipation_error",
    ),
    "dissipation_error": PathResult(
        lambda done: done.result.dissipation_error,
        "estimated error of the dissipated energy",
        "eV",
        "error of the dissipated energy",
    ),
    "turn_force": PathResult(
        lambda done: done.result.turn.normal_force,
        "normal force at the deepest state",
        "eV/Å",
        "force at the turn",
    ),
    "turn_penetration": PathResult(
        lambda done: done.result.turn.penetration,
        "penetration at the deepest state",
        "Å",
        "depth at the turn",
    ),
    "approach_jumps": PathResult(
        lambda done: len(done.result.approach_jumps),
        "number of instabilities during approach",
        label="instabilities on approach",
    ),
    "retraction_jumps": PathResult(
        lambda done: len(done.result.retraction_jumps),
        "number of instabilities during retraction",
        label="instabilities on retraction",
    ),
    "cantilever_pull_off_force": PathResult(
        lambda done: _on_cantilever(done, "pull_off_force"),
        "largest tension during retraction of the base of the cantilever",
        "eV/Å",
        "cantilever pull-off force",
        _ON_CANTILEVER,
        theory=lambda sphere: sphere.pull_off_force,
        is_lower_bound=lambda done: _on_cantilever(done, "turn_force") < 0.0,
    ),
    "cantilever_dissipated_energy": PathResult(
        lambda done: _on_cantilever(done, "dissipated_energy"),
        "area of the loop of force against height of the base of the cantilever",
        "eV",
        "cantilever dissipation",
        _ON_CANTILEVER,
    ),
}
