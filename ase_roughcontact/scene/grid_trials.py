"""Error and cost of grids for the continuum, measured on a few steps of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.text import cell
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.analysis import extrapolate
from ase_roughcontact.paths.plan import plan_path
from ase_roughcontact.scene.scene import Scene

# Grids of the trials: spacings in units of that of the atoms, the coarsest first.
_GRIDS: dict[float, dict[str, int]] = {
    2.0: {"coarsen": 2},
    1.0: {},
    0.5: {"refine": 2},
    0.25: {"refine": 4},
}


@dataclass(frozen=True)
class GridTrial:
    """Error and cost of a grid.

    Attributes
    ----------
    settings : dict
        Values by key of the scene file, ``{"substrate.refine": 2}``.
    area_error : float
        Largest relative error of the area of any step, against the limit of fine grids.
    limit_error : float
        Largest estimated error of the limit, relative to it.
    seconds : float
        Wall-clock time (s).
    memory : float
        Estimated peak memory (bytes).
    """

    settings: dict[str, Any]
    area_error: float
    limit_error: float
    seconds: float
    memory: float

    @property
    def label(self) -> str:
        """The settings in short."""
        items = self.settings.items()
        return ", ".join(f"{key.split('.')[1]} {value}" for key, value in items)

    @property
    def error(self) -> float:
        """Error of the area, with that of the limit."""
        return self.area_error + self.limit_error


def grid_trials(
    scene: Scene, targets: Sequence[float], seconds: float
) -> tuple[GridTrial, ...]:
    """Calculate steps of a scene on several grids, and compare the areas.

    Parameters
    ----------
    scene : Scene
        Whose question is the continuum.
    targets : sequence of float
        Loads (eV/Å), penetrations or heights (Å).
    seconds : float
        Planned time of a grid above which it and finer ones are omitted (s).

    Returns
    -------
    tuple of GridTrial
        The coarsest first; empty if there are fewer than two grids, or nothing touches.
    """
    steps = {}
    for spacing, change in _GRIDS.items():
        grid = scene.with_values(
            {f"substrate.{key}": change.get(key, 1) for key in ("refine", "coarsen")}
        )
        try:
            plan = plan_path(grid.atoms(), grid.control, targets, grid.window)
        except ValueError:  # the grid does not divide the window or the period
            continue
        if not plan.runs or plan.seconds > seconds:
            continue
        steps[spacing] = list(grid.relax(targets, validity="ignore"))
    finest = sorted(steps)[:3]
    if len(finest) < 2:
        return ()
    counted = [[step.contact_area for step in steps[spacing]] for spacing in finest]
    limit = extrapolate(finest, counted)
    touching = limit.value > 0.0
    if not touching.any():
        return ()
    limit_error = float((limit.error / limit.value)[touching].max())
    trials = []
    for spacing, of_grid in steps.items():
        areas = np.array([getattr(step, scene.area_column) for step in of_grid])
        error = abs(areas / limit.value - 1.0)[touching].max()
        trials.append(
            GridTrial(
                {f"substrate.{key}": n for key, n in _GRIDS[spacing].items()}
                or {"substrate.refine": 1},
                float(error),
                limit_error,
                sum(step.seconds for step in of_grid),
                max(step.memory for step in of_grid),
            )
        )
    return tuple(trials)


def grid_table(trials: Sequence[GridTrial], requested: float) -> str:
    """Return the trials as text, with the cheapest grid for a requested error.

    Parameters
    ----------
    trials : sequence of GridTrial
    requested : float
        Relative error of the area.

    Returns
    -------
    str
    """
    lines = ["grid            area error  time (s)  memory (GB)"]
    lines += [
        f"{trial.label:<12}{trial.area_error:14.1e}{cell(trial.seconds, 10, '.2g')}"
        f"{cell(trial.memory / UNITS['GB'], 13, '.2f')}"
        for trial in trials
    ]
    limit_error = trials[0].limit_error
    lines.append(
        "Errors of the area of the continuum against the limit of fine grids, which is "
        f"known to {limit_error:.1e}."
    )
    enough = [trial for trial in trials if trial.error <= requested]
    best = min(enough, key=lambda trial: trial.seconds, default=None)
    if best is None:
        lines.append(f"No grid is known to have an error of {requested:g} or less.")
    else:
        lines.append(f"Cheapest grid for an error of {requested:g}: {best.label}.")
    return "\n".join(lines)
