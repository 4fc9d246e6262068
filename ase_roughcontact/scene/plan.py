"""Checks of a scene before it runs: warnings, impossible steps, and a plan."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.contact import Problem
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.contact.creep import (
    CREEP_PRESSURE,
    CREEP_TRACTIONS,
    PRESSURE_RATE,
)
from ase_roughcontact.contact.history import HistoryEntry, entry_of
from ase_roughcontact.contact.state import LATERAL, PLASTIC_DEPTH, TRACTION_DEPTH
from ase_roughcontact.interactions.rate_and_state import SLIP_RATES, RateFriction
from ase_roughcontact.paths.plan import LATERAL_LEFT_OUT, plan_path
from ase_roughcontact.paths.planned_steps import Plan
from ase_roughcontact.results.limits import LEAST_EDGE_ZONE, narrowest_zone
from ase_roughcontact.results.record import size_of
from ase_roughcontact.results.scan_errors import COPIES_LEFT_OUT, scans_of
from ase_roughcontact.scene.solid import has_own_spacing
from ase_roughcontact.topography import RoughSphere
from ase_roughcontact.windows.expected import ExpectedContact
from ase_roughcontact.windows.memory import friction_memory

# Share of the necessary zone at the edge below which there is a warning: surfaces jump
# atom by atom, in many steps.
_MIN_ZONE_SHARE = 0.25
# Contact radius in grid points above which a coarser grid is advised.
_MAX_POINTS_PER_RADIUS = 240
# Points of the advised grid on the shortest wavelength.
_POINTS_PER_WAVE = 4
# Panels of the curve of a flat, and of other figures with several of them.
_FLAT_PANELS = 3
_PANELS = {"time.png": 3, "friction.png": 2}
# Approximation of paths with friction.
_SLIDING_LEFT_OUT = (
    "changes of the heights by sliding, which must be small compared to the roughness"
)
# Approximation of paths with friction without coupling.
_COUPLING_LEFT_OUT = (
    ", and of the pressure by lateral tractions: none for a Poisson's ratio of 1/2"
)


def warnings_of(scene: Any) -> list[str]:
    """Return warnings about scan, radius and grid of a `Scene`."""
    found = range_warnings(scene.problem)
    for scan in scene.scans.values():
        found += scan.warnings(scene.radius, scene.whole_tip is not None)
    return found + _spacing_warnings(scene)


def range_warnings(problem: Problem) -> list[str]:
    """Return a warning if a grid is far too coarse for the range of the attraction.

    The limits of the model report it, too, but only after the first step.
    """
    if not problem.wall.attractive:
        return []
    spacing, length = problem.spacing, problem.wall.attraction_range
    zone = narrowest_zone(problem) / spacing
    if zone >= _MIN_ZONE_SHARE * LEAST_EDGE_ZONE:
        return []
    least, nm = length * math.sqrt(LEAST_EDGE_ZONE / zone), UNITS["nm"]
    return [
        f"the zone of attraction at the edge of a contact is {zone:.2g} spacings of "
        f"{spacing / nm:.3g} nm wide, and should be {LEAST_EDGE_ZONE:g} or more: give "
        f'a finer grid, or attraction_range = "{1.01 * least / nm:.3g} nm" (the '
        "pull-off force changes by about 1 % while Maugis' parameter is above 3)"
    ]


def _spacing_warnings(scene: Any) -> list[str]:
    """Return advice on a spacing that is chosen neither by the scene nor for it."""
    rough = scene.rough
    if has_own_spacing(scene.substrate) or scene.shape or rough is None:
        return []
    areas = scene.planned.expected_areas
    radius = math.sqrt(areas.max(initial=0.0) / math.pi)
    wave = rough.short_wavelength
    advised = float(f"{wave / _POINTS_PER_WAVE / UNITS['nm']:.1g}")  # one digit
    grid = scene.grid_change.spacing(scene.spacing)
    if radius < _MAX_POINTS_PER_RADIUS * grid or advised * UNITS["nm"] < 2.0 * grid:
        return []
    return [
        f"the contact has a radius of about {radius / grid:.0f} points of the grid of "
        f'{grid / UNITS["nm"]:.3g} nm: give [substrate] spacing = "{advised:g} nm", a '
        "quarter of the shortest wavelength"
    ]


def check_path(scene: Any) -> None:
    """Raise an error if a step of a `Scene` certainly can't be calculated.

    Nothing is calculated for this: neither the roughness nor a window.

    Parameters
    ----------
    scene : Scene
        Scene with known targets.

    Raises
    ------
    ValueError
        If atoms touch where the roughness is not defined.
    MemoryError
        If a contact exceeds the free memory.
    """
    if scene.shape or not isinstance(scene.surface, RoughSphere):
        return
    expected, path = ExpectedContact(scene.problem), scene.path
    # the deepest one last
    steps = np.sort(scene.targets)[:: int(scene.control.deeper)]

    def error_at(target: float) -> ValueError | MemoryError | None:
        try:
            expected.check(scene.control, float(target))
        except (ValueError, MemoryError) as error:
            return error
        return None

    worst = error_at(steps[-1])  # the other steps need less
    if worst is None:
        return
    failing = steps[bisect_left(steps, True, key=lambda step: bool(error_at(step))) :]
    ends = dict.fromkeys(f"{step / UNITS[path.unit]:g}" for step in failing[[0, -1]])
    text = f"[path] {scene.control.name} of {' to '.join(ends)} {path.unit}: {worst}"
    if len(failing) < len(steps):
        these = "this step" if len(failing) == 1 else f"these {len(failing)} steps"
        text += f"; or leave out {these}"
    kind = MemoryError if isinstance(worst, MemoryError) else ValueError
    raise kind(text) from worst


def warn_of_memory(scene: Any) -> None:
    """Warn if a `Scene` with known targets is expected to exceed the free memory.

    Windows are estimates, thus this is no error. A step without a window to fit into
    the memory ends the path.
    """
    plan = _plan_without_advice(scene, timed=False)
    if not plan.fits:
        warn(
            f"about {plan.memory / 1e9:.2g} GB of memory are expected to be needed, "
            f"but only {plan.available / 1e9:.2g} GB are free: a step that needs more "
            'ends the run; "ase-roughcontact plan" shows the steps'
        )


def plan_of(scene: Any) -> Plan:
    """Return the windows, memory and time of the path of a `Scene`.

    If the domain of the roughness is too small, the advised one is planned as well, as
    a larger one may be rougher.
    """
    plan = _plan_without_advice(scene)
    if not plan.domain:
        return plan
    change = scene.grid_change
    side = math.ceil(plan.domain / change.refine) * change.coarsen
    larger = plan_of(scene.with_values({"roughness.domain": f"{side} a0"}))
    advice = f"give the roughness a domain of {side} a0 or more"
    return replace(plan, advice=larger.advice or advice)


def _plan_without_advice(scene: Any, timed: bool = True) -> Plan:
    """Return the plan of a `Scene`, without advice on the domain of the roughness."""
    plan = plan_path(
        scene.problem, scene.start, scene.control, scene.targets, scene.window, timed
    )
    friction = scene.friction
    steps, left_out = list(plan.steps), plan.left_out
    if friction:  # steps with equal targets are one
        counts = Counter[float]()
        for step in steps:
            counts[step.target] += step.count
        distinct = {step.target: step for step in steps}
        steps = [replace(step, count=counts[t]) for t, step in distinct.items()]
        sliding = _SLIDING_LEFT_OUT
        if not friction.coupled:
            sliding += _COUPLING_LEFT_OUT
        others = [text for text in left_out if text != LATERAL_LEFT_OUT]
        left_out = (sliding, *others)
        for number, step in enumerate(steps):
            atoms = size_of(step.window) if step.window else 0
            memory = step.memory + friction_memory(atoms, friction.coupled)
            steps[number] = replace(step, memory=memory)
    if scans_of(scene.bodies.problem):
        left_out = (*left_out, COPIES_LEFT_OUT)
    plan = replace(plan, steps=tuple(steps), left_out=left_out)
    return with_files_of(scene, plan)


def with_files_of(scene: Any, plan: Plan) -> Plan:
    """Return a plan with the sizes of the files that a `Scene` writes."""
    schedule = scene.path.schedule(scene.bodies)
    return replace(
        plan,
        keep=scene.output.keep,
        fields_of_frame=_fields_of_frame(scene),
        fields_of_state=_fields_of_state(scene),
        figures=_number_of_figures(scene),
        views=schedule.sample_times().size if schedule else 0,
        inputs=sum(Path(file).stat().st_size for file in scene.files),
    )


def _number_of_figures(scene: Any) -> int:
    """Return the number of figures of a run, as far as it is known before.

    Figures that take as long as several others, by their panels, count as many.
    """
    path = scene.path
    drawn = [name for name in path.captions if name.endswith("png")]
    if path.stiffness is None:
        drawn = [name for name in drawn if name != "cantilever.png"]
    count = 1 + sum(_PANELS.get(name, 1) for name in drawn)
    if not path.in_order:
        curve = _FLAT_PANELS if scene.is_flat else 1
        count += curve + (path.controlled != LOAD)
    return count


def _history(scene: Any) -> list[HistoryEntry]:
    """Return the entries of the history of a scene's surface."""
    names = [PLASTIC_DEPTH] if scene.wall.permanent else []
    if scene.friction:
        names += LATERAL
        if scene.friction.coupled:
            names.append(TRACTION_DEPTH)
        law = scene.friction.law_on(scene.spacing)
        names += [entry.name for entry in law.histories]
        if isinstance(law, RateFriction):
            names += SLIP_RATES
    if (creep := scene.solid.creep) is not None:
        names += [CREEP_PRESSURE] * creep.terms
        if scene.friction:
            names += CREEP_TRACTIONS * creep.terms
        else:
            names.append(PRESSURE_RATE)
    return [entry_of(name) for name in names]


def _fields_of_frame(scene: Any) -> int:
    """Return the numbers of an atom in a frame: pressure, displacement and history."""
    return 2 + sum(entry.in_frames for entry in _history(scene))


def _fields_of_state(scene: Any) -> int:
    """Return the numbers of an atom in the restart file.

    Pressure, for its own and for the next step, displacement, history, and the depths
    that pressures of the past cause.
    """
    depths = 0 if scene.solid.creep is None else scene.solid.creep.terms
    return 3 + len(_history(scene)) + depths
