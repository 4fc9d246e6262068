"""Preview of a scene: a few of its steps on a much coarser grid."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.results.record import size_of
from ase_roughcontact.scene.path_kind import Steps
from ase_roughcontact.scene.plan import range_warnings
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.windows.regrid import GridChange

# Ratios of the spacings, tried in this order; the first one costs a sixteenth.
_SPACING_RATIOS = (4, 2, 1)
# Share of the points times the steps that is calculated. The time of small windows
# does not decrease with their points, and a step far from the step before it takes
# about twice the iterations.
_SHARE_OF_STEPS = 1 / 256
# Number of steps of a preview on a coarser grid, if the path has more.
_MIN_STEPS = 3
# Number of steps below which a run takes less than ten times as long as one step.
_MAX_FEW_STEPS = 10
# Number of points in all windows below which a run takes tenths of a second.
_MAX_FEW_POINTS = 100_000
# Number of points in all windows below which a path in time takes some seconds: its
# steps begin close to their results.
_MAX_FEW_POINTS_IN_TIME = 2_000_000
# Share of the rms slope that a grid may lose.
_MAX_LOST_SLOPE = 0.5
# Wave number times the spacing of waves of a continuum.
_LONG_WAVE_NUMBER = 1e-3


def preview(scene: Scene) -> Scene:
    """Return a scene that shows the results of another one in a part of its time.

    The preview asks for the continuum on a grid of up to four times the spacing,
    without the waves that this grid can't resolve. It has a sixteenth of the steps or
    fewer, but at least three on a coarser grid: the last step and some before it, but
    not the first, which is the least accurate on such a grid. With a wall that depends
    on history it also has the steps at which the path turns. The preview of a loop
    is its deepest state, as the contact jumps at other depths on a coarse grid. A
    crystal of atoms becomes an isotropic solid of the same contact modulus. A path in
    time, or of sliding, is previewed as a whole. The errors are estimated as in any
    scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Scene
        The same one, or the deepest state of a loop, if its steps are so few and small
        that a single step would take more than a tenth of the time of the run.
    """
    path = scene.path
    whole = path.in_order
    if whole:
        points = path.expected_count(scene.bodies) * _points(scene.planned)
        if points < _MAX_FEW_POINTS_IN_TIME:
            return scene
    else:
        scene = scene.planned
        # the solid of a crystal takes longer than the steps
        is_short = len(scene.targets) < _MAX_FEW_STEPS and not scene.substrate.of_atoms
        if is_short and _points(scene) < _MAX_FEW_POINTS:
            return scene
    coarse, ratio = coarser_scene(scene)
    if whole:
        return coarse
    steps = scene.targets / UNITS[scene.path.unit]
    least = 1 if ratio == 1 else min(max(len(steps) - 1, 1), _MIN_STEPS)
    count = max(least, math.floor(_SHARE_OF_STEPS * ratio**2 * len(steps)))
    kept = np.linspace(0, len(steps) - 1, count + 1)[1:].round().astype(int)
    if scene.wall.depends_on_history:  # not without the steps at which the path turns
        turns = np.flatnonzero(np.diff(np.sign(np.diff(steps)))) + 1
        kept = np.union1d(kept, turns)
    path = Steps.at(scene.control, steps[kept].tolist())
    return coarse.with_values({"path": path})


def coarser_scene(scene: Scene) -> tuple[Scene, int]:
    """Return the continuum of a scene on a grid of up to four times the spacing.

    It resolves at least half of the rms slope, and a quarter of the necessary points on
    the range of an attraction.

    Returns
    -------
    Scene
    int
        Ratio of the spacings.
    """
    continuum = _continuum(scene)
    for ratio in _SPACING_RATIOS:
        coarse = continuum.with_grid(_coarser(scene.grid_change, ratio))
        if ratio == 1 or _is_possible(coarse):
            break
    return coarse, ratio


def _points(scene: Scene) -> float:
    """Return the points of all windows; infinity if a step can't be calculated."""
    steps = scene.plan().steps
    if any(step.problem for step in steps):
        return math.inf
    return sum(step.count * size_of(step.window) for step in steps)


def _continuum(scene: Scene) -> Scene:
    """Return the scene that asks for the continuum, and has a solid without atoms."""
    solid = scene.substrate
    if solid.of_atoms:
        solid = replace(
            solid,
            calculator="",
            potential="",
            crystal="",
            spacing=scene.spacing,
            contact_modulus=scene.contact_modulus / UNITS["GPa"],
            poisson=_poisson(scene) if scene.friction else None,
        )
    return scene.with_values(
        {
            "substrate": replace(solid, model="continuum"),
            "solver.accuracy": "fast",
            "solver.fmax": None,
        }
    )


def _poisson(scene: Scene) -> float:
    """Return Poisson's ratio of an isotropic solid as compliant as a scene's solid.

    Both have the same mean lateral compliance for long waves.
    """
    q, angles = _LONG_WAVE_NUMBER / scene.spacing, np.pi / 8.0 * np.arange(8)
    xx, yy, _ = scene.solid.lateral_wave_compliance(
        q * np.cos(angles), q * np.sin(angles)
    )
    relative = 0.5 * q * scene.contact_modulus * float(np.mean(xx + yy))
    return min(1.0 - 1.0 / (relative - 1.0), 0.5)  # relative = 1 + 1/(1 - nu)


def _coarser(change: GridChange, ratio: int) -> GridChange:
    """Return the grid of a multiple of the spacing."""
    common = math.gcd(change.refine, ratio)
    return GridChange(change.refine // common, change.coarsen * ratio // common)


def _is_possible(scene: Scene) -> bool:
    """Return whether a grid fits window and surface, and resolves slope and range."""
    try:
        lost = scene.lost_slope
        return lost <= _MAX_LOST_SLOPE and not range_warnings(scene.problem)
    except ValueError:
        return False
