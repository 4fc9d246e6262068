"""Progress of an ensemble, and an estimate of the time left."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ase_roughcontact._util.printing import duration
from ase_roughcontact.scene import Scene

# Cost of a load step without contact, in atoms in contact. Measured for copper and a
# radius of 1000 atoms, from 1 nN to 2 µN.
_BASE_COST = 5000.0


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
        From `expected_costs`, by case.
    unit : str
        See `Progress`.

    Attributes
    ----------
    finished : dict
        Number of finished load steps, by case.
    failures : dict
        Error messages of the cases that failed, by case.
    """

    def __init__(self, costs: Mapping[str, np.ndarray], unit: str = "steps") -> None:
        self._unit = unit
        self.finished = dict.fromkeys(costs, 0)
        self.failures: dict[str, str] = {}
        self._costs = costs
        self._start = time.perf_counter()
        self._initial: float | None = None

    def add(self, cases: Iterable[str]) -> None:
        """Count finished load steps, given by their cases; others are ignored."""
        for case in cases:
            if case in self.finished:
                self.finished[case] += 1

    def unfinished(self) -> list[str]:
        """Return the cases that are neither complete nor failed, in their order."""
        return [
            case
            for case, cost in self._costs.items()
            if case not in self.failures and self.finished[case] < len(cost) - 1
        ]

    def progress(self) -> Progress:
        """Return the progress so far."""
        elapsed = time.perf_counter() - self._start
        costs, finished = self._costs, self.finished
        spent = sum(cost[finished[case]] for case, cost in costs.items())
        if self._initial is None:
            self._initial = spent
        new = spent - self._initial
        unfinished = self.unfinished()
        remaining = sum(
            costs[case][-1] - costs[case][finished[case]] for case in unfinished
        )
        left = float(remaining * elapsed / new) if new > 0.0 else math.nan
        return Progress(
            steps=sum(finished.values()),
            total=sum(len(cost) - 1 for cost in costs.values()),
            elapsed=elapsed,
            left=left if unfinished else 0.0,
            failures=dict(self.failures),
            unit=self._unit,
        )


def expected_costs(scene: Scene) -> np.ndarray:
    """Return the cumulative expected cost of the load steps of a scene.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    ndarray, shape (steps + 1,)
        Cost before each step and after the last one, in arbitrary units; a path in time
        counts as one step.

    Raises
    ------
    ValueError
        If the scene is invalid.
    """
    scene.check()
    if scene.path.count(scene.bodies) is None:
        whole = scene.path.expected_count(scene.bodies)
        return np.append(0.0, whole * expected_costs(scene.planned)[-1])
    if scene.shape:
        areas = np.full(scene.targets.shape, float(math.prod(scene.shape)))
    else:
        areas = scene.expected_areas / scene.spacing**2
    return np.append(0.0, np.cumsum(_BASE_COST + areas))
