"""Plan of an ensemble or of places: cases, time, memory of a worker, and files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ase_roughcontact._util.printing import duration, entries
from ase_roughcontact._util.tables import Table
from ase_roughcontact._util.workers import number_of_workers, processors
from ase_roughcontact.ensemble.progress import expected_costs
from ase_roughcontact.paths.planned_steps import Plan, StartCosts
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.run_plan import run_plan
from ase_roughcontact.windows.memory import DRAWING_BYTES

# Size of a row of a database (bytes).
_ROW_SIZE = 10_000
# Size of a row of places, with what is written beside them (bytes).
_PLACE_SIZE = 300
# Size of the figure of places with a scan, and of each of its maps (bytes).
_FIGURE_SIZE, _MAP_SIZE = 96_000, 28_000
# Processor time of start and end of a process, of the checks of a case, and of writing
# a row of a database, over the time of the start of the program.
_PROCESS_TIME, _CASE_TIME, _ROW_TIME = 1.4, 0.05, 0.0025


@dataclass(frozen=True)
class EnsemblePlan:
    """Cost of many cases, from the plan of one.

    Attributes
    ----------
    cases : int
        Number of cases.
    plan : Plan
        Plan of the case of median cost, without figures.
    costs : float
        Costs of all cases over the cost of this one.
    workers : int
        Number of processes.
    rows : int
        Number of rows of the database; zero for places.
    maps : int
        Number of maps of places; zero for a database.
    """

    cases: int
    plan: Plan
    costs: float
    workers: int
    rows: int
    maps: int = 0

    @classmethod
    def of(
        cls,
        scenes: Sequence[Scene],
        workers: int | None,
        start: StartCosts | None = None,
        places: bool = False,
    ) -> EnsemblePlan:
        """Return the plan of scenes.

        Parameters
        ----------
        scenes : sequence of Scene
            All cases; for places the scene at each place.
        workers : int, optional
            Number of processes; by default as for `run_ensemble`.
        start : StartCosts, optional
            Costs of the process when the command began; by default zero.
        places : bool
            Whether the results are places of a scan.
        """
        costs = [sum(expected_costs(scene).values()) for scene in scenes]
        if start is not None:  # the solids are made for this
            start = start.with_scene()
        middle = int(np.argsort(costs)[len(costs) // 2])
        plan = run_plan(scenes[middle], start, scan_errors=not places)
        count = len(scenes)
        return cls(
            cases=count,
            plan=replace(plan, figures=0),
            costs=sum(costs) / costs[middle],
            workers=min(number_of_workers(workers), count),
            rows=0 if places else count * (plan.count + 1),
            maps=_number_of_maps(scenes[middle]) if places else 0,
        )

    @property
    def steps(self) -> int:
        """Number of steps of all cases."""
        return self.cases * self.plan.count

    @property
    def seconds(self) -> float:
        """Processor time of all cases and processes (s)."""
        start, processes = self.plan.start, 1 + self.workers
        relative = _PROCESS_TIME * processes
        relative += _CASE_TIME * self.cases + _ROW_TIME * self.rows
        begun = relative * start.program_seconds + processes * start.scene
        return begun + self.costs * self.plan.step_seconds

    @property
    def files(self) -> float:
        """Size of the files (bytes)."""
        if self.rows:
            return self.rows * _ROW_SIZE
        figure = _FIGURE_SIZE + _MAP_SIZE * self.maps
        return self.cases * _PLACE_SIZE + figure + self.plan.inputs

    @property
    def memory(self) -> float:
        """Peak memory of a worker (bytes)."""
        return max(self.plan.memory - DRAWING_BYTES, self.plan.start.memory)

    @property
    def fits(self) -> bool:
        """Whether the free memory suffices for all workers."""
        return self.workers * self.memory < self.plan.available

    @property
    def totals(self) -> dict[str, Any]:
        """Numbers of all cases; see `Plan.totals`. The memory is a worker's."""
        return {
            **self.plan.totals,
            "cases": self.cases,
            "workers": self.workers,
            "steps": self.steps,
            "seconds": self.seconds,
            "memory": self.memory,
            "files": self.files,
        }

    def printed(self) -> Table:
        """Return the plan as names and values, for a terminal."""
        at_once = min(self.workers, processors())
        passed = self.plan.printed_time(self.seconds / at_once)
        enough = "" if self.fits else ": NOT ENOUGH"
        basis = self.plan.basis or "times of transforms"
        return entries(
            [
                ("cases", f"{self.cases}, with about {self.steps} steps in all"),
                (
                    "time",
                    f"{passed} with {self.workers} workers on {at_once} "
                    f"processors, {duration(max(self.seconds, 1.0))} of processor time",
                ),
                (
                    "memory",
                    f"{self.memory / 1e9:.2g} GB for each of {self.workers} workers, "
                    f"{self.plan.available / 1e9:.2g} GB are free{enough}",
                ),
                ("files", f"{self.files / 1e6:.2g} MB"),
                ("basis", f"{basis}, of the case of median cost"),
            ]
        )


def _number_of_maps(scene: Scene) -> int:
    """Return the number of maps of places: area, pull-off force, dissipated energy."""
    return 1 + scene.wall.attractive + ("dissipated_energy" in scene.path.results)
