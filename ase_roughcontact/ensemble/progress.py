"""How far an ensemble is, and how long it will take."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import timedelta

import numpy as np

from ase_roughcontact.ensemble.ledger import Standing
from ase_roughcontact.scene import Scene

# A step of a small window takes as long as this many atoms in contact of a large one.
_LEAST_COST = 5000.0


@dataclass(frozen=True)
class Progress:
    """How far an ensemble is.

    Attributes
    ----------
    steps, total : int
        Steps that are done, and all of them.
    elapsed : float
        Time since the start of this run (s).
    left : float
        Time left (s); NaN before the first step. A step is taken to cost as much as
        5000 atoms (measured: copper, from 1 nN to 2 µN on a radius of 1000 atoms) and
        the atoms in the contact of a smooth sphere; the time of such a unit is measured
        on all steps of this run, by all workers.
    failures : dict
        Messages of cases that ended with an error, by case.
    """

    steps: int
    total: int
    elapsed: float = field(default=0.0, compare=False)
    left: float = field(default=math.nan, compare=False)
    failures: dict[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        parts = [f"{self.steps}/{self.total} steps"]
        if self.failures:
            parts.append(f"{len(self.failures)} failed")
        if math.isfinite(self.left):
            parts.append(f"about {timedelta(seconds=round(self.left))} left")
        return ", ".join(parts)


class Meter:
    """Tells progress by the expected costs of the cases; see `costs_of`.

    Parameters
    ----------
    costs : mapping
        By case.
    since : float
        When the run began, as `time.time` tells it.
    """

    def __init__(self, costs: Mapping[str, np.ndarray], since: float) -> None:
        self._costs = costs
        self._since = since
        self._start = time.perf_counter()
        self._before: float | None = None

    def read(self, standings: Mapping[str, Standing]) -> Progress:
        """Read the progress off how far the cases are."""
        elapsed = time.perf_counter() - self._start
        spent = ahead = 0.0
        for case, standing in standings.items():
            cost = self._costs[case]
            spent += cost[standing.finished]
            if not standing.settled(self._since):
                ahead += cost[-1] - cost[standing.finished]
        if self._before is None:
            self._before = spent
        new = spent - self._before
        left = float(ahead * elapsed / new) if new > 0.0 else math.nan
        return Progress(
            steps=sum(standing.finished for standing in standings.values()),
            total=sum(len(cost) - 1 for cost in self._costs.values()),
            elapsed=elapsed,
            left=left if ahead > 0.0 else 0.0,
            failures={
                case: standing.message
                for case, standing in standings.items()
                if standing.state == "failed" and standing.settled(self._since)
            },
        )


def costs_of(scene: Scene) -> np.ndarray:
    """Return the expected cost before each step of a scene, and after the last.

    Raises
    ------
    ValueError
        If something in the scene is not what it should be.
    """
    scene.check()
    steps = scene.steps
    if scene.shape:
        areas = np.full(steps.shape, float(math.prod(scene.shape)))
    elif scene.path.control == "load":
        areas = scene.hertz_area(np.maximum(steps, 0.0)) / scene.spacing**2
    else:
        from_top = steps.max() - steps
        depths = steps if scene.path.control == "penetration" else from_top
        areas = np.pi * scene.radius * np.maximum(depths, 0.0) / scene.spacing**2
    return np.append(0.0, np.cumsum(_LEAST_COST + areas))
