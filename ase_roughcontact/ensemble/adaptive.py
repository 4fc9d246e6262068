"""Sampling of realisations until the mean areas have a wanted standard error."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, closing
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import chdtri

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.validation import integer, positive
from ase_roughcontact._util.workers import worker_pool
from ase_roughcontact.ensemble.cases import case_of, product
from ase_roughcontact.ensemble.database import EnsembleDatabase, database_address
from ase_roughcontact.ensemble.progress import Progress
from ase_roughcontact.ensemble.run import run_ensemble
from ase_roughcontact.scene import Scene

# Largest factor by which the number of realisations grows before the standard deviation
# is estimated again: from few realisations it is uncertain.
_MAX_GROWTH = 2.0
#: Reason for an unknown error.
TOO_FEW = "fewer than two realisations have converged"
#: Reason for an unknown error.
NO_CONTACT = "no realisation is in contact"
# Probabilities with which the needed number exceeds the ends of its likely range.
_RANGE_PROBABILITIES = np.array([0.05, 0.95])


@dataclass(frozen=True)
class MeanArea:
    """Mean contact area of a load step over realisations of the roughness.

    Attributes
    ----------
    target : float
        Load (eV/Å), penetration or height (Å), or time (s) of a path in time.
    realisations : int
        Number of converged realisations.
    mean : float
        Mean area (Å^2).
    error : float
        Relative standard error of the mean; NaN if it is not known.
    expected : int
        Number of realisations at which the wanted error is expected.
    likely : (int, int)
        Range that contains this number with a probability of 90 %. The variance of
        ``n`` normally distributed areas has a distribution with ``n - 1`` degrees of
        freedom.
    unknown : str
        Reason why the error is not known; empty if it is known.
    """

    target: float
    realisations: int
    mean: float
    error: float
    expected: int
    likely: tuple[int, int]
    unknown: str = ""

    @classmethod
    def of(cls, target: float, areas: np.ndarray, wanted: float) -> MeanArea:
        """Return the mean of areas, and the number of areas that the error needs."""
        mean = float(areas.mean()) if areas.size else math.nan
        unknown = ""
        if areas.size < 2:
            unknown = TOO_FEW
        elif not mean > 0.0:
            unknown = NO_CONTACT
        if unknown:
            return cls(target, areas.size, mean, math.nan, 0, (0, 0), unknown)
        spread = float(areas.std(ddof=1)) / mean
        count, freedom = (spread / wanted) ** 2, areas.size - 1
        quantiles = chdtri(freedom, _RANGE_PROBABILITIES)
        least, most = np.ceil(count * freedom / quantiles).astype(int)
        return cls(
            target,
            areas.size,
            mean,
            spread / math.sqrt(areas.size),
            math.ceil(count),
            (int(least), int(most)),
        )


def mean_areas(scenes: Sequence[Scene], database: PathName) -> tuple[MeanArea, ...]:
    """Return the mean contact areas of realisations of the roughness.

    Parameters
    ----------
    scenes : sequence of Scene
        Scenes that differ only in their seeds.
    database : path
        Database of `run_ensemble`.

    Returns
    -------
    tuple of MeanArea
        Means for each load step, of the converged realisations in the database.
    """
    return _Areas(scenes[0], database).means(list(map(case_of, scenes)), math.inf)


@dataclass(frozen=True)
class Sampling:
    """State of an ensemble that grows to a wanted error.

    Attributes
    ----------
    wanted : float
        Wanted relative standard error of each mean.
    means : tuple of MeanArea
        Means for each load step of the scene, of the steps finished so far.
    progress : Progress
        Progress of the present round of realisations.
    """

    wanted: float
    means: tuple[MeanArea, ...]
    progress: Progress

    @property
    def error(self) -> float:
        """Largest relative standard error of the means; NaN if no error is known."""
        known = (mean.error for mean in self.means if not mean.unknown)
        return max(known, default=math.nan)

    @property
    def done(self) -> bool:
        """Whether the means of all steps with contact have the wanted error."""
        too_few = any(mean.unknown == TOO_FEW for mean in self.means)
        return self.error <= self.wanted and not too_few

    @property
    def missing(self) -> int:
        """Expected number of realisations of steps that are still needed."""
        return self._missing([mean.expected for mean in self.means])

    @property
    def likely_missing(self) -> tuple[int, int]:
        """Sums of the ends of the ranges of the numbers that are still needed."""
        least, most = zip(*(mean.likely for mean in self.means), strict=True)
        return self._missing(least), self._missing(most)

    def _missing(self, needed: Sequence[int]) -> int:
        """Return the number of missing realisations of steps, from those needed."""
        return sum(
            max(number - mean.realisations, 1)
            for number, mean in zip(needed, self.means, strict=True)
            if mean.error > self.wanted
        )


def sample_ensemble(
    scene: Scene,
    database: PathName,
    error: float,
    executor: Executor | None = None,
    workers: int | None = None,
    *,
    pilot: int = 8,
    most: int = 10_000,
    interval: float = 1.0,
) -> Iterator[Sampling]:
    """Add realisations of the roughness until each mean area has a wanted error.

    Each load step has as many realisations as it needs, as small contacts scatter more
    than large ones. A step gets no more realisations if no realisation of the pilot is
    in contact, or fewer than two have converged: its error is then not known. If states
    depend on the states before them, each realisation is calculated up to the last step
    that needs it. Paths in time are calculated as a whole, and averaged at the ends of
    their parts at the deepest target. Seeds count up from the seed of the scene. A run
    that was interrupted, or had another error, is continued, and steps of
    `run_ensemble` in the database are used.

    Parameters
    ----------
    scene : Scene
        Scene with random roughness.
    database, executor, workers, interval
        See `run_ensemble`.
    error : float
        Wanted relative standard error of the mean area of each load step. The area is
        the column `Scene.area_column`.
    pilot : int
        Number of realisations of all steps in the first round, from which the needed
        numbers are predicted.
    most : int
        Largest number of realisations.

    Yields
    ------
    Sampling
        State of the sampling, whenever steps were added. The last one is not `done` if
        cases failed or the largest number of realisations does not suffice.

    Raises
    ------
    ValueError
        If the scene has no random roughness, or a number is out of range.
    """
    positive(error=error)
    integer("pilot", pilot, 2)
    integer("most", most, pilot)
    if scene.roughness is None:
        raise ValueError(
            "realisations need a scene with [roughness]: a measured or smooth surface "
            "has only one"
        )
    pool = worker_pool(executor, workers)
    return _rounds(scene, database, error, (pilot, most), pool, interval)


def _rounds(
    scene: Any,
    database: PathName,
    error: float,
    limits: tuple[int, int],
    pool: AbstractContextManager[Executor],
    interval: float,
) -> Iterator[Sampling]:
    """Calculate rounds of realisations, and estimate the needed number after each."""
    pilot, most = limits
    areas, first = _Areas(scene, database), scene.roughness.seed
    counts = np.full(len(areas.targets), pilot)
    with pool as executor:
        while True:
            seeds = range(first, first + int(counts.max()))
            scenes = product(scene, {"roughness.seed": seeds})
            cases = [case_of(each) for each in scenes]
            wanted = counts > np.arange(len(scenes))[:, None]
            steps = [np.flatnonzero(each).tolist() for each in wanted]
            if scene.is_in_order:  # with the steps before them
                steps = [list(range(each[-1] + 1)) for each in steps]
            run = run_ensemble(
                scenes, database, executor, interval=interval, steps=steps
            )
            with closing(run):
                for progress in run:
                    sampling = Sampling(error, areas.means(cases, error), progress)
                    yield sampling
            missing = np.array([mean.error > error for mean in sampling.means])
            # more are needed if some do not converge
            expected = [
                math.ceil(mean.expected * count / max(mean.realisations, 1))
                for mean, count in zip(sampling.means, counts.tolist(), strict=True)
            ]
            more = np.ceil(_MAX_GROWTH * counts).clip(max=most).astype(int)
            more = np.where(missing, np.clip(expected, counts + 1, more), counts)
            if progress.failures or (more <= counts).all():
                return
            counts = np.maximum(counts, more)


class _Areas:
    """Areas of the converged steps of a database, where each row is read once.

    Paths in time have areas at the ends of their parts at the deepest target.
    """

    def __init__(self, scene: Scene, database: PathName) -> None:
        self._stored = EnsembleDatabase(database_address(database))
        self._area, self._newest = scene.area_column, 0
        self._areas: dict[tuple[str, int], float] = {}  # by case and number of target
        schedule = scene.path.schedule(scene.bodies)
        if schedule is None:
            self._column, self.targets = "step", scene.targets
            self._values = np.arange(len(self.targets))
            return
        parts = list(schedule.timed_parts())
        deepest = scene.path.deepest_of(part.end for _, _, part in parts)
        ends = [t + part.duration for t, _, part in parts if part.end == deepest]
        self._column, self._values = "time", np.unique(ends)
        self.targets = self._values

    def means(self, cases: Sequence[str], error: float) -> tuple[MeanArea, ...]:
        """Return the means of the steps of some cases in the database."""
        for row in self._stored.select(f"id>{self._newest}", converged=True):
            value, area = row.get(self._column, math.nan), row.get(self._area)
            same = np.isclose(self._values, value, rtol=1e-9, atol=0.0)
            if area is not None and same.any():
                self._areas[row["case"], int(same.argmax())] = area
            self._newest = max(self._newest, row.id)
        means = []
        for number, target in enumerate(self.targets):
            found = (self._areas.get((case, number)) for case in cases)
            areas = np.array([area for area in found if area is not None])
            means.append(MeanArea.of(float(target), areas, error))
        return tuple(means)
