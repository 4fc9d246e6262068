"""Progress of an ensemble, and an estimate of the time left."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from ase_roughcontact._util.printing import duration
from ase_roughcontact.scene import Scene

# Cost of a load step without contact, in atoms in contact. Measured for copper and a
# radius of 1000 atoms, from 1 nN to 2 µN.
_BASE_COST = 5000.0
#: Number that stands for all steps of a path in time.
WHOLE = -1


@dataclass(frozen=True)
class Progress:
    """Progress of an ensemble.

    Attributes
    ----------
    steps, total : int
        Number of finished load steps, and of all; a path in time counts as one.
    elapsed : float
        Time since the start of this run (s).
    left : float
        Estimated time left (s), NaN before the first step of this run is finished. The
        cost of a step is taken as a constant plus the contact area of a smooth sphere,
        and scaled to the steps that all workers have finished during this run.
    failures : dict
        Error messages of the cases that failed, by case.
    unit : str
        What is counted, "steps" or "paths".
    """

    steps: int
    total: int
    elapsed: float = field(default=0.0, compare=False)
    left: float = field(default=math.nan, compare=False)
    failures: dict[str, str] = field(default_factory=dict)
    unit: str = "steps"

    def __str__(self) -> str:
        parts = [f"{self.steps}/{self.total} {self.unit}"]
        if self.failures:
            parts.append(f"{len(self.failures)} failed")
        if math.isfinite(self.left):
            parts.append(f"about {duration(self.left)} left")
        return ", ".join(parts)


class ProgressMeter:
    """Counts finished load steps and failures, and estimates the time left.

    Parameters
    ----------
    costs : mapping
        Expected cost of each load step, by case and number of the step; that of a path
        in time, as a whole, has the number `WHOLE`.

    Attributes
    ----------
    missing : dict
        The costs of the load steps that are not finished.
    failures : dict
        Error messages of the cases that failed, by case.
    """

    def __init__(self, costs: Mapping[str, Mapping[int, float]]) -> None:
        self.missing = {case: dict(steps) for case, steps in costs.items()}
        self.failures: dict[str, str] = {}
        in_time = all(WHOLE in steps for steps in costs.values())
        self._unit = "paths" if in_time else "steps"
        self._total = sum(map(len, costs.values()))
        self._start = time.perf_counter()
        self._initial: float | None = None

    def finish(self, case: str, step: int) -> None:
        """Count a finished load step; those that are not of this run are ignored."""
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
        elapsed = time.perf_counter() - self._start
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
        )


def expected_costs(scene: Scene) -> dict[int, float]:
    """Return the expected costs of the load steps of a scene, in arbitrary units.

    They have the numbers of the steps; that of a path in time has the number `WHOLE`.

    Raises
    ------
    ValueError
        If the scene is invalid.
    """
    scene.check()
    if scene.path.count(scene.bodies) is None:
        count = scene.path.expected_count(scene.bodies)
        return {WHOLE: count * sum(expected_costs(scene.planned).values())}
    if scene.shape:
        areas = np.full(scene.targets.shape, float(math.prod(scene.shape)))
    else:
        areas = scene.expected_areas / scene.spacing**2
    return dict(enumerate((_BASE_COST + areas).tolist()))
