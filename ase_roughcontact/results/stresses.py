"""Largest stresses below the surface of a relaxed step.

They follow from the pressure of the wall and the tractions of friction, also on
viscoelastic solids with one creep function. Under a wall with a hardness the stress is
elastic: the model limits pressures, and has no residual stress below the surface.
"""

from __future__ import annotations

import math
from weakref import WeakKeyDictionary

import numpy as np

from ase_roughcontact.contact.state import TRACTIONS
from ase_roughcontact.elasticity.largest_stress import LargestStress, largest_stress
from ase_roughcontact.elasticity.lattice import carried
from ase_roughcontact.elasticity.stress_field import StressField
from ase_roughcontact.results.column import ColumnOnRequest, Range, column_on_request
from ase_roughcontact.stepping.relaxed import RelaxedStep

#: Steps on solids with a stress below the surface.
WITH_STRESS = Range(
    "solids with elastic constants or Poisson's ratio",
    lambda s: s.problem.solid.has_subsurface,
    constant=True,
)
#: Steps with a place of the largest stress.
WITH_PLACE = Range(
    f"{WITH_STRESS.text} under pressure or tension",
    lambda s: WITH_STRESS.includes(s) and bool(s.fields.pressure.any()),
)

# Largest stresses of relaxed steps, for which several columns ask.
_by_step: WeakKeyDictionary[RelaxedStep, dict[str, LargestStress]] = WeakKeyDictionary()


def stress_field(step: RelaxedStep) -> StressField:
    """Return the stress below the surface of a relaxed step, in single precision."""
    halfspace = step.halfspace
    return StressField(
        step.problem.solid,
        halfspace.spacing,
        step.fields.pressure,
        _tractions(step),
        halfspace.periodic,
        dtype=np.float32,
    )


def _tractions(step: RelaxedStep) -> np.ndarray | None:
    """Return the tractions of friction on the window, of this step or kept; or None."""
    window, history = step.state.window, step.state.history
    if step.lateral is not None:
        found = step.lateral.solution.tractions
        return np.stack([carried(each, step.lateral.box, window) for each in found])
    if TRACTIONS[0] in history:
        return np.stack([history[name] for name in TRACTIONS])
    return None


def largest_stress_of(step: RelaxedStep, measure: str) -> LargestStress:
    """Return the largest stress below a relaxed step; see `largest_stress`.

    It is searched once for each step. Positions are relative to the indenter's axis.
    """
    known = _by_step.setdefault(step, {})
    if measure not in known:
        found = largest_stress(stress_field(step), measure)
        (x, *_), (y, *_) = step.positions
        known[measure] = LargestStress(
            found.value, found.depth, found.x + float(x), found.y + float(y)
        )
    return known[measure]


def yield_ratio(step: RelaxedStep) -> float:
    """Return the largest von Mises stress over the yield strength; NaN without one."""
    strength = step.options.yield_strength
    if math.isnan(strength) or not step.problem.solid.has_subsurface:
        return math.nan
    return largest_stress_of(step, "von_mises").value / strength


def value_column(measure: str, description: str) -> ColumnOnRequest:
    """Return the column of the largest value of a stress; see `MEASURES`."""
    return column_on_request(
        lambda s: largest_stress_of(s, measure).value,
        description,
        "eV/Å^3",
        where=WITH_STRESS,
    )


def place_column(measure: str, coordinate: str) -> ColumnOnRequest:
    """Return the column of a coordinate of a largest stress: depth, x or y."""
    place = f"position along {coordinate} from the indenter's axis"
    if coordinate == "depth":
        place = "depth"
    return column_on_request(
        lambda s: float(getattr(largest_stress_of(s, measure), coordinate)),
        f"{place} of the stress `largest_{measure}`",
        "Å",
        where=WITH_PLACE,
    )
