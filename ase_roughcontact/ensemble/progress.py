"""Progress of an ensemble, and an estimate of the time left."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter

import numpy as np

from ase_roughcontact._util.printing import duration
from ase_roughcontact.paths.schedule import Schedule
from ase_roughcontact.scene import Scene

# Cost of a load step without contact, in units of the cost of an atom in contact.
# Measured for copper and a radius of 1000 atoms, from 1 nN to 2 µN.
_BASE_COST = 5000.0
# Duration of a part of a path in time over the duration of its first step.
_DURATION_RATIO = 1024.0
# Fraction of the steps of a part that are evenly spread over the logarithm of time; the
# others are spread over time.
_LOGARITHMIC_FRACTION = 0.6
#: Number that stands for all steps of a path that is calculated as a whole.
WHOLE = -1


@dataclass(frozen=True)
class Progress:
    """Progress of an ensemble.

    Attributes
    ----------
    steps, total : int
        Numbers of finished load steps and of all load steps; a path that is calculated
        as a whole counts as one.
    elapsed : float
        Time since the start of this run (s).
    left : float
        Estimated time left (s), NaN before the first step of this run is finished. The
        cost of a step is taken as a constant plus the contact area of a smooth sphere,
        and scaled to the steps that all workers have finished during this run.
    failures : dict
        Error messages of the cases that failed, by case.
    unit : str
        Unit of the numbers, "steps" or "paths".
    names : dict
        Values by which the cases that failed differ from others, as text, by case.
    """

    steps: int
    total: int
    elapsed: float = field(default=0.0, compare=False)
    left: float = field(default=math.nan, compare=False)
    failures: dict[str, str] = field(default_factory=dict)
    unit: str = "steps"
    names: dict[str, str] = field(default_factory=dict)

    @property
    def named_failures(self) -> dict[str, str]:
        """Error messages of the cases that failed, by their values."""
        return {self.names[case]: text for case, text in self.failures.items()}

    def __str__(self) -> str:
        parts = [f"{self.steps}/{self.total} {self.unit}"]
        if self.failures:
            parts.append(f"{len(self.failures)} failed")
        if math.isfinite(self.left):
            parts.append(f"about {duration(self.left)} left")
        return ", ".join(parts)


class ProgressMeter:
    """Counter of finished load steps and failures, with an estimate of the time left.

    Parameters
    ----------
    costs : mapping
        Expected cost of each load step, by case and number of the step. The cost of a
        whole path has the number `WHOLE`.
    names : mapping, optional
        Names of the cases in `Progress`; by default the cases themselves.

    Attributes
    ----------
    missing : dict
        Costs of the load steps that are not finished, by case and number of the step.
    failures : dict
        Error messages of the cases that failed, by case.
    """

    def __init__(
        self,
        costs: Mapping[str, Mapping[int, float]],
        names: Mapping[str, str] | None = None,
    ) -> None:
        self._names = {case: case for case in costs} if names is None else names
        self.missing = {case: dict(steps) for case, steps in costs.items()}
        self.failures: dict[str, str] = {}
        whole = all(WHOLE in steps for steps in costs.values())
        self._unit = "paths" if whole else "steps"
        self._total = sum(map(len, costs.values()))
        self._start = perf_counter()
        self._initial: float | None = None

    def finish(self, case: str, step: int) -> None:
        """Count a finished load step; steps that are not of this run are ignored."""
        self.missing.get(case, {}).pop(step, None)

    def unfinished(self) -> list[str]:
        """Return the cases that are neither complete nor failed, in their order."""
        return [
            case
            for case, steps in self.missing.items()
            if steps and case not in self.failures
        ]

    def progress(self) -> Progress:
        """Return the progress so far."""
        elapsed = perf_counter() - self._start
        costs = {case: sum(steps.values()) for case, steps in self.missing.items()}
        cost = sum(costs.values())
        if self._initial is None:
            self._initial = cost
        remaining = sum(costs[case] for case in self.unfinished())
        spent, left = self._initial - cost, math.nan
        if not remaining:
            left = 0.0
        elif spent > 0.0:
            left = remaining * elapsed / spent
        return Progress(
            steps=self._total - sum(map(len, self.missing.values())),
            total=self._total,
            elapsed=elapsed,
            left=left,
            failures=dict(self.failures),
            unit=self._unit,
            names={case: self._names[case] for case in self.failures},
        )


class TimeMeter:
    """Estimate of the time left of a path in time.

    Time steps are short at the beginning of a part of the schedule and while the
    contact changes fast, so that neither the simulated time nor the number of steps
    gives the time left. Each part has an expected number of steps. Most of them are
    taken as evenly spread over the logarithm of the simulated time, as steps grow; the
    others, and the steps of oscillations, are spread over the time itself. The second
    half of the steps so far gives the rate: the estimate grows if steps stay short.

    Parameters
    ----------
    schedule : Schedule
        Schedule of the path.
    counts : sequence of float
        Expected number of time steps of each part of the schedule.
    """

    def __init__(self, schedule: Schedule, counts: Sequence[float]) -> None:
        parts = zip(schedule.timed_parts(), counts, strict=True)
        self._parts = [
            (begin, part, count) for (begin, _, part), count in parts if part.duration
        ]
        self._duration, self._time = schedule.duration, 0.0
        self._done: list[tuple[float, float]] = []

    def restart(self, time: float) -> None:
        """Begin to measure at a simulated time, up to which steps were restored."""
        self._done.clear()
        self.finish(time)

    def finish(self, time: float) -> None:
        """Count the step that ends at a simulated time."""
        self._time = time
        self._done.append((perf_counter(), self._part_done(time)))

    def __str__(self) -> str:
        text = f"{self._time:.3g} of {self._duration:.4g} s"
        if math.isfinite(self.left):
            text += f", roughly {duration(self.left)} left"
        return text

    @property
    def left(self) -> float:
        """Estimated time left (s), to a factor of four or so; NaN if unknown."""
        if not self._done:
            return math.nan
        last, done = self._done[-1]
        begin, before = self._done[(len(self._done) - 1) // 2]
        if done == before:
            return math.nan
        return (1.0 - done) * (last - begin) / (done - before)

    def _part_done(self, time: float) -> float:
        """Return the fraction of the expected steps done at a simulated time."""
        done = 0.0
        for begin, part, count in self._parts:
            passed = min(max((time - begin) / part.duration, 0.0), 1.0)
            done += count * (passed if part.amplitude else _fraction_of_steps(passed))
        return done / sum(count for _, _, count in self._parts)


def _fraction_of_steps(passed: float) -> float:
    """Return the fraction of the steps of a part, from the fraction of its time."""
    logarithm = math.log2(1.0 + (_DURATION_RATIO - 1.0) * passed)
    logarithm /= math.log2(_DURATION_RATIO)
    fraction = _LOGARITHMIC_FRACTION
    return fraction * logarithm + (1.0 - fraction) * passed


def is_whole(scene: Scene) -> bool:
    """Return whether the path of a scene is calculated as a whole.

    So are paths that choose their steps as they run, and paths with results of all
    their steps.
    """
    return scene.path.count(scene.bodies) is None or bool(scene.path.results)


def expected_costs(scene: Scene) -> dict[int, float]:
    """Return the expected costs of a case, in arbitrary units; see `step_costs`.

    A path that is calculated as a whole has the number `WHOLE`.

    Raises
    ------
    ValueError
        If the scene is invalid.
    """
    scene.check()
    if is_whole(scene):
        count = scene.path.expected_count(scene.bodies)
        return {WHOLE: count * sum(step_costs(scene.planned).values())}
    return step_costs(scene)


def step_costs(scene: Scene) -> dict[int, float]:
    """Return the expected costs of the steps of known targets, by their numbers."""
    if scene.shape:
        areas = np.full(scene.targets.shape, float(math.prod(scene.shape)))
    else:
        areas = scene.expected_areas / scene.spacing**2
    return dict(enumerate((_BASE_COST + areas).tolist()))
