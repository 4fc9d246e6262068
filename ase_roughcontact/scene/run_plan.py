r"""Plan of a run: a trial on a coarser grid gives the number and the cost of its steps.

The number of steps of loops and paths in time, the windows and the FFT pairs of each
step are taken from the trial. A step of the run takes longer than the trial's step by

.. math:: \Delta t = (n + 40) (t_\mathrm{pair} - t_\mathrm{pair}')

with the FFT pairs n and the times of a pair on both grids, which are measured. Columns
and files of a step take about 40 times as long as a pair. Conjugate gradients under a
hard wall need more pairs for a finer grid. On a periodic half space the condition of
the compliances is proportional to the number of points along a side, and the number of
pairs to the root of the condition: twice as many for a quarter of the spacing. On a
free half space 1.1 to 1.8 times as many were measured, least for rough surfaces.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.paths.planned_steps import (
    Plan,
    PlannedStep,
    StartCosts,
    pair_timer,
)
from ase_roughcontact.results.record import shape_of, size_of
from ase_roughcontact.scene.path_kind import Steps
from ase_roughcontact.scene.plan import with_files_of
from ase_roughcontact.scene.preview import coarser_scene
from ase_roughcontact.scene.scene import Scene

# Largest number of steps of given targets that a trial relaxes.
_MAX_STEPS = 12
# Largest processor time of a trial (s).
_MAX_SECONDS = 60.0
# Largest number of points of all windows of a trial of given targets.
_MAX_POINTS = 3_000_000
# Exponents of the growth of the number of FFT pairs with the number of points along a
# side, under a hard wall.
_PERIODIC_GROWTH, _FREE_GROWTH = 0.5, 0.25
# Time of columns and files of a step over the time of an FFT pair.
_STEP_PAIRS = 40.0


@dataclass(frozen=True)
class TrialStep:
    """Step of a trial.

    Attributes
    ----------
    number : int
        Number of the planned step for which it stands.
    expected, coarse : PlannedStep
        This step, as planned on the grids of the scene and of the trial.
    record : LoadStep
        What was found.
    seconds : float
        Processor time, with the files (s).
    """

    number: int
    expected: PlannedStep
    coarse: PlannedStep
    record: Any
    seconds: float

    def on_grid_of_run(
        self, pair: Callable[[tuple[int, int]], float], growth: float
    ) -> PlannedStep:
        """Return the step of the run.

        Parameters
        ----------
        pair : callable
            Time of an FFT pair (s), as a function of the shape of the grid.
        growth : float
            FFT pairs of the run over the trial's.
        """
        record = self.record
        ratio = size_of(record.window) / size_of(self.coarse.window)
        step = self.expected.resized(ratio)
        longer = pair(shape_of(step.grid)) - pair(shape_of(record.grid))
        pairs = growth * record.pairs + _STEP_PAIRS
        seconds = self.seconds + pairs * max(longer, 0.0)
        return replace(step, seconds=seconds, count=1)


@dataclass(frozen=True)
class Trial:
    """Steps of a scene on a coarser grid.

    Attributes
    ----------
    ratio : int
        Spacing of its grid over the spacing of the scene's grid.
    steps : tuple of TrialStep
    ended : str
        Why it ended before its last step; empty if it did not.
    """

    ratio: int
    steps: tuple[TrialStep, ...]
    ended: str

    def __str__(self) -> str:
        text = f"a trial on a grid {self.ratio} times as coarse"
        if self.ratio == 1:
            text = "a trial on the same grid"
        if self.ended:
            text += f", which ended after {len(self.steps)} steps: {self.ended}"
        return text


def run_plan(
    scene: Scene, start: StartCosts | None = None, scan_errors: bool = True
) -> Plan:
    """Return the plan of a run, with the costs that a trial shows.

    Parameters
    ----------
    scene : Scene
    start : StartCosts, optional
        Costs of the process before the first step; by default zero.
    scan_errors : bool
        Whether the run estimates the errors by pixels and noise of a scan.

    Returns
    -------
    Plan
    """
    plan = with_files_of(scene, scene.planned.plan())
    plan = replace(plan, start=start or StartCosts())
    trial = trial_of(scene, plan, scan_errors)
    if trial is None:
        return plan.repeated(scene.path.expected_count(scene.bodies))
    pair = pair_timer(scene.problem.halfspace(scene.start.shape))
    exponent = 0.0
    if scene.wall.family == "hard":
        exponent = _PERIODIC_GROWTH if scene.problem.periodic else _FREE_GROWTH
    growth = trial.ratio**exponent
    found = [step.on_grid_of_run(pair, growth) for step in trial.steps]
    count, at_least = scene.path.count(scene.bodies), False
    if not _is_whole(scene):
        found = _all_steps(plan, trial, found)
        plan = replace(plan, steps=tuple(found))
    elif count is None:
        at_least = bool(trial.ended)
    elif count > len(found):
        found.append(replace(found[-1], count=count - len(found)))
    if schedule := scene.path.schedule(scene.bodies):
        times = [step.record.time for step in trial.steps]
        plan = replace(plan, views=len(schedule.sampled_steps(times)))
    basis = str(trial)
    return replace(plan, run_steps=tuple(found), basis=basis, at_least=at_least)


def trial_of(scene: Scene, plan: Plan, scan_errors: bool = True) -> Trial | None:
    """Relax the path of a scene, or some of its steps, on a coarser grid.

    Parameters
    ----------
    scene : Scene
    plan : Plan
        Plan of the scene.
    scan_errors : bool
        See `run_plan`.

    Returns
    -------
    Trial or None
        None if a step can't be planned, the first step of the trial fails, or the
        trial would take too long.
    """
    if any(step.problem for step in plan.steps):
        return None
    coarse, ratio = coarser_scene(scene)
    numbers = np.arange(len(plan.steps))
    if not _is_whole(scene):
        kept = np.linspace(0, numbers[-1], min(len(numbers), _MAX_STEPS))
        numbers = np.unique(kept.round().astype(int))
        targets = [plan.steps[number].target for number in numbers]
        values = [target / UNITS[scene.path.unit] for target in targets]
        coarse = coarse.with_values({"path": Steps.at(scene.control, values)})
    planned = coarse.planned.plan().steps
    points = sum(size_of(step.window) for step in planned if step.window)
    if any(step.problem for step in planned) or points > _MAX_POINTS:
        return None
    tried = [
        (number, plan.steps[number], step)
        for number, step in zip(numbers.tolist(), planned, strict=True)
    ]
    if _is_whole(scene):  # all its steps are compared with the largest one
        tried = [max(tried, key=lambda each: size_of(each[1].window))]
    steps: list[TrialStep] = []
    ended, last = "", process_time()
    end = last + _MAX_SECONDS
    with tempfile.TemporaryDirectory() as folder:
        try:
            if scan_errors:
                records = coarse.run(Path(folder) / "trial", validity="ignore")
            else:
                records = coarse.relax(validity="ignore", scan_errors=False)
            for record in records:
                now = process_time()
                like = tried[min(len(steps), len(tried) - 1)]
                steps.append(TrialStep(*like, record, now - last))
                last = now
                if now > end:
                    ended = f"it took {_MAX_SECONDS:g} s"
                    break
        except (ValueError, RuntimeError, MemoryError) as error:
            ended = str(error)
    return Trial(ratio, tuple(steps), ended) if steps else None


def _is_whole(scene: Scene) -> bool:
    """Return whether a path is tried as a whole."""
    return scene.path.count(scene.bodies) is None or scene.path.in_order


def _all_steps(plan: Plan, trial: Trial, found: list[PlannedStep]) -> list[PlannedStep]:
    """Return all steps of given targets, by the nearest steps of a trial."""
    numbers = np.array([step.number for step in trial.steps])
    steps = []
    for number, step in enumerate(plan.steps):
        nearest = int(abs(numbers - number).argmin())
        expected, like = trial.steps[nearest].expected, found[nearest]
        ratio = size_of(like.window) / size_of(expected.window)
        seconds = like.seconds * step.seconds / expected.seconds
        steps.append(replace(step.resized(ratio), seconds=seconds))
    return steps
