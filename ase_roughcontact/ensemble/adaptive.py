"""Sampling of realisations until means have a wanted standard error."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, closing
from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.lazy import lazy
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import integer, positive
from ase_roughcontact._util.workers import worker_pool
from ase_roughcontact.ensemble.cases import case_of, product
from ase_roughcontact.ensemble.means import TOO_FEW, ColumnValues, MeanValue
from ase_roughcontact.ensemble.progress import Progress, is_whole
from ase_roughcontact.ensemble.run import run_ensemble
from ase_roughcontact.scene import Scene

# Largest factor by which the number of realisations grows before the standard deviation
# is estimated again: from few realisations it is uncertain.
_MAX_GROWTH = 2.0


@dataclass(frozen=True)
class Sampling(Summarized):
    """State of an ensemble that grows to a wanted error.

    Attributes
    ----------
    wanted : float
        Wanted relative standard error of each mean.
    means : tuple of MeanValue
        Means of the column, see `mean_values`, of all that is finished so far.
    progress : Progress
        Progress of the present round of realisations.
    """

    wanted: float
    means: tuple[MeanValue, ...]
    progress: Progress

    @property
    def error(self) -> float:
        """Largest relative standard error of the means; NaN if no error is known."""
        errors = [
            mean.error
            for mean in self.means
            if not (mean.unknown or mean.is_below_errors)
        ]
        return max(errors, default=math.nan)

    @property
    def done(self) -> bool:
        """Whether all means other than zero have the wanted error."""
        too_few = any(mean.unknown == TOO_FEW for mean in self.means)
        return self.error <= self.wanted and not too_few

    @property
    def missing(self) -> int:
        """Expected number of realisations of steps that are still needed."""
        return self._missing([mean.expected for mean in self.means])

    @property
    def likely_missing(self) -> tuple[int, int]:
        """Sums of the ends of the ranges of the numbers that are still needed."""
        least = [mean.likely[0] for mean in self.means]
        largest = [mean.likely[1] for mean in self.means]
        return self._missing(least), self._missing(largest)

    def _missing(self, needed: Sequence[int]) -> int:
        """Return the number of missing realisations, from the numbers needed."""
        return sum(
            max(number - mean.realisations, 1)
            for number, mean in zip(needed, self.means, strict=True)
            if mean.needs_more(self.wanted)
        )


@lazy
def sample_ensemble(
    scene: Scene,
    database: PathName,
    error: float,
    executor: Executor | None = None,
    workers: int | None = None,
    *,
    column: str | None = None,
    pilot: int = 8,
    most: int = 10_000,
    interval: float = 1.0,
) -> Iterator[Sampling]:
    """Add realisations of the roughness until each mean has a wanted error.

    Each load step has as many realisations as it needs, as small contacts scatter more
    than large ones. A step gets no more realisations if its mean is zero within
    rounding or the errors of its values, or fewer than two have converged. If states
    depend on the states before them, each realisation is calculated up to the last step
    that needs it. Loops, sliding paths and paths in time are calculated as a whole.
    Seeds count up from the seed of the scene. A run that was interrupted, or had
    another error, is continued, and steps of `run_ensemble` in the database are used.

    Parameters
    ----------
    scene : Scene
        Scene with random roughness.
    database, executor, workers, interval
        See `run_ensemble`.
    error : float
        Wanted relative standard error of each mean, see `MeanValue`.
    column : str, optional
        Column that is averaged; see `mean_values`.
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
        If the scene has no random roughness, there is no such column, or a number is
        out of range.
    """
    positive(error=error)
    integer("pilot", pilot, 2)
    integer("most", most, pilot)
    if scene.seed is None:
        raise ValueError(
            "realisations need a scene with [roughness], as a measured or smooth "
            "surface has only one: give [roughness], or seed in [topography] for other "
            "surfaces like a scan"
        )
    pool = worker_pool(executor, workers)
    values = ColumnValues(scene, database, column)
    return _rounds(scene, values, error, pool, interval, pilot=pilot, most=most)


def _rounds(
    scene: Any,
    values: ColumnValues,
    error: float,
    pool: AbstractContextManager[Executor],
    interval: float,
    *,
    pilot: int,
    most: int,
) -> Iterator[Sampling]:
    """Calculate rounds of realisations, and estimate the needed number after each."""
    first, counts = scene.seed, np.full(len(values.targets), pilot)
    whole = is_whole(scene)
    with pool as executor:
        while True:
            seeds = range(first, first + int(counts.max()))
            scenes = product(scene, {"roughness.seed": seeds})
            cases = [case_of(each) for each in scenes]
            wanted = counts > np.arange(len(scenes))[:, None]
            steps: Any = [np.flatnonzero(each).tolist() for each in wanted]
            if scene.is_in_order:  # with the steps before them
                steps = [list(range(each[-1] + 1)) for each in steps]
            run = run_ensemble(
                scenes,
                values.database,
                executor,
                interval=interval,
                steps=None if whole else steps,
            )
            with closing(run):
                for progress in run:
                    sampling = Sampling(error, values.means(cases, error), progress)
                    yield sampling
            missing = np.array([mean.needs_more(error) for mean in sampling.means])
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
