"""Means of a column over realisations of the roughness, with standard errors."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.special import chdtri, ndtri, stdtrit

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import lookup
from ase_roughcontact.ensemble.cases import case_of
from ase_roughcontact.ensemble.columns import step_types
from ase_roughcontact.ensemble.database import EnsembleDatabase, database_address
from ase_roughcontact.results.limits import failed_checks
from ase_roughcontact.results.record import columns_of
from ase_roughcontact.scene import Scene

#: Reason for an unknown error.
TOO_FEW = "fewer than two realisations have a converged value"
#: Reason for an unknown error.
ZERO = "the mean is zero within rounding"
# Probability with which a normally distributed mean is within 1.96 standard errors.
_CONFIDENCE = 0.95
# Probabilities with which the needed number exceeds the ends of its likely range.
_RANGE_PROBABILITIES = np.array([0.05, 0.95])
# Columns of the estimated errors of columns of steps.
_ERROR_OF_COLUMN = {
    "continuum_area": "continuum_area_error",
    "normal_force": "force_error",
    "height": "height_error",
    "penetration": "penetration_error",
}
# Separator of limits, and of lower bounds, in the row of a case.
_LIST_SEPARATOR = "; "


class _Value(NamedTuple):
    """Value of a realisation, its error, exceeded limits, and if it is a bound."""

    value: float
    error: float
    limits: tuple[str, ...]
    is_lower_bound: bool


@dataclass(frozen=True)
class MeanValue(Summarized):
    r"""Mean of a column over realisations of the roughness.

    Attributes
    ----------
    target : float
        Load (eV/Å), penetration or height (Å) of a step, or time (s) of a path in time;
        NaN for a result of the whole path.
    realisations : int
        Number of realisations with a converged value.
    mean : float
        Mean of the values, in the unit of the column.
    error : float
        Standard error of the mean, relative to its magnitude; NaN if it is not known.
        For few realisations it is larger than :math:`s/\sqrt n` by Student's factor
        :math:`t_{n-1}/1.96`, so that 95 % of means are within 1.96 errors.
    expected : int
        Number of realisations at which the wanted error is expected.
    likely : (int, int)
        Range that contains this number with a probability of 90 %. The variance of
        ``n`` normally distributed values has a distribution with ``n - 1`` degrees of
        freedom.
    unknown : str
        Reason why the error is not known; empty if it is known.
    column : str
        Name of the column.
    scatter : float
        Standard deviation :math:`s` of a realisation, in the unit of the column.
    failed : int
        Number of realisations that have failed, not converged or no value, such as a
        static friction that is not reached; they are not in the mean.
    value_error : float
        Mean of the estimated errors of the values, relative to the mean; NaN if they
        are not known. It does not decrease with the number of realisations.
    validity : str
        Limits of the model that realisations exceed, with their numbers; empty if none.
    lower_bounds : int
        Number of realisations with a value that is a lower bound, such as the pull-off
        force of a tip that is still pulled where it turns.
    """

    target: float
    realisations: int
    mean: float
    error: float
    expected: int
    likely: tuple[int, int]
    unknown: str = ""
    column: str = ""
    scatter: float = math.nan
    failed: int = 0
    value_error: float = math.nan
    validity: str = ""
    lower_bounds: int = 0

    @property
    def is_below_errors(self) -> bool:
        """Whether the mean is zero within the estimated errors of the values."""
        return self.value_error >= 1.0

    def needs_more(self, wanted: float) -> bool:
        """Return whether more realisations are needed for a relative error.

        They can't help if the mean is zero within rounding or the errors of the values.
        """
        return self.error > wanted and not self.is_below_errors

    @classmethod
    def of(
        cls, target: float, values: np.ndarray, wanted: float, **more: Any
    ) -> MeanValue:
        """Return the mean of values, and the number of values that the error needs.

        Parameters
        ----------
        target : float
        values : ndarray
            Values of the realisations.
        wanted : float
            Wanted relative error.
        **more
            Further attributes.
        """
        count = values.size
        mean = float(values.mean()) if count else math.nan
        scatter = float(values.std(ddof=1)) if count > 1 else math.nan
        rounding = count * np.finfo(float).eps * scatter
        if count < 2 or abs(mean) <= rounding:
            more["unknown"] = TOO_FEW if count < 2 else ZERO
            return cls(
                target, count, mean, math.nan, 0, (0, 0), scatter=scatter, **more
            )
        spread = scatter / abs(mean)
        quantiles = chdtri(count - 1, _RANGE_PROBABILITIES)
        least, most = np.sqrt((count - 1) / quantiles) * spread
        return cls(
            target,
            count,
            mean,
            standard_error(spread, count),
            realisations_needed(spread, wanted),
            (realisations_needed(least, wanted), realisations_needed(most, wanted)),
            scatter=scatter,
            **more,
        )


#: Name of `MeanValue` for areas.
MeanArea = MeanValue


def standard_error(scatter: float, count: int) -> float:
    r"""Return the standard error of the mean of a few values, by Student's t.

    .. math:: \frac{t_{n-1}}{1.96} \frac{s}{\sqrt n},

    with the two-sided quantiles :math:`t_{n-1}` and 1.96 for 95 % of Student's and the
    normal distribution: the interval of 1.96 errors contains 95 % of the means.

    Parameters
    ----------
    scatter : float
        Standard deviation s of the values.
    count : int
        Number n of values, at least two.

    Returns
    -------
    float

    References
    ----------
    Student, Biometrika 6, 1 (1908).
    """
    upper = 0.5 * (1.0 + _CONFIDENCE)
    factor = stdtrit(count - 1, upper) / ndtri(upper)
    return float(factor * scatter / math.sqrt(count))


def realisations_needed(scatter: float, wanted: float) -> int:
    """Return the least number of values with a standard error, see `standard_error`.

    Parameters
    ----------
    scatter : float
        Standard deviation of the values.
    wanted : float
        Wanted error; infinity needs none.

    Returns
    -------
    int
    """
    if wanted == math.inf:
        return 0
    count = max(2, math.ceil((scatter / wanted) ** 2))
    while standard_error(scatter, count) > wanted:
        count += 1
    return count


def mean_values(
    scenes: Sequence[Scene], database: PathName, column: str | None = None
) -> tuple[MeanValue, ...]:
    """Return means of a column over realisations of the roughness.

    Parameters
    ----------
    scenes : sequence of Scene
        Scenes that differ only in their seeds.
    database : path
        Database of `run_ensemble`.
    column : str, optional
        Result of the kind of path, such as ``"pull_off_force"``, or a column of its
        steps. By default the main result of the kind, or the contact area.

    Returns
    -------
    tuple of MeanValue
        One mean for a result. For a column of steps a mean for each step; of paths in
        time for the ends of their parts at the deepest target.

    Raises
    ------
    ValueError
        If there is no such column of numbers.
    """
    values = ColumnValues(scenes[0], database, column)
    return values.means(list(map(case_of, scenes)), math.inf)


def mean_areas(scenes: Sequence[Scene], database: PathName) -> tuple[MeanValue, ...]:
    """Return mean contact areas; see `mean_values`."""
    return mean_values(scenes, database, scenes[0].area_column)


def default_column(scene: Scene) -> str:
    """Return the column that is averaged by default: a result, or the contact area."""
    return scene.path.main_result or scene.area_column


def check_column(scene: Scene, column: str) -> None:
    """Raise `ValueError` unless a column of numbers has means; see `mean_values`."""
    lookup(column, {**scene.path.results, **_columns_of_steps(scene)}, "column")


class ColumnValues:
    """Values of a column in a database, where each row of a step is read once.

    Parameters
    ----------
    scene : Scene
        One of the scenes.
    database : path
        Database of `run_ensemble`.
    column : str, optional
        See `mean_values`.

    Attributes
    ----------
    database : str
        Address of the database.
    column : str
        Name of the column.
    targets : ndarray
        Targets at which there are means; one NaN for a result of the whole path.
    """

    def __init__(
        self, scene: Scene, database: PathName, column: str | None = None
    ) -> None:
        self.database = database_address(database)
        self._stored = EnsembleDatabase(self.database)
        self.column = default_column(scene) if column is None else column
        check_column(scene, self.column)
        results = scene.path.results
        self._of_cases = self.column in results
        self._values: dict[tuple[str, int], _Value] = {}  # by case, number of target
        self._failed: set[tuple[str, int]] = set()
        self._newest = 0
        if self._of_cases:
            self._error = results[self.column].error
            self.targets = np.array([math.nan])
            return
        errors = {**_ERROR_OF_COLUMN, scene.area_column: "area_error"}
        self._error = errors.get(self.column, "")
        self._key, self._at, self.targets = _targets(scene)

    def means(self, cases: Sequence[str], wanted: float) -> tuple[MeanValue, ...]:
        """Return the means over some cases, and the numbers that an error needs.

        Parameters
        ----------
        cases : sequence of str
            Names of the cases; one that is named several times counts once.
        wanted : float
            Wanted relative error; infinity for none.
        """
        ended = self._read_cases()
        if not self._of_cases:
            self._read_steps()
        means = []
        for number, target in enumerate(self.targets.tolist()):
            stored, failed = [], 0
            for case in dict.fromkeys(cases):  # each realisation counts once
                key = case, number
                if key in self._values:
                    stored.append(self._values[key])
                if key in self._failed or (case in ended and key not in self._values):
                    failed += 1
            means.append(self._mean(target, stored, wanted, failed))
        return tuple(means)

    def _mean(
        self, target: float, stored: Sequence[_Value], wanted: float, failed: int
    ) -> MeanValue:
        values = np.array([each.value for each in stored])
        errors = np.array([each.error for each in stored])
        limits: Counter[str] = Counter()
        for each in stored:
            limits.update(each.limits)
        mean = abs(values.mean()) if stored else 0.0
        return MeanValue.of(
            target,
            values,
            wanted,
            column=self.column,
            failed=failed,
            value_error=float(errors.mean()) / mean if mean else math.nan,
            validity=_LIST_SEPARATOR.join(
                f"{limit} in {count} of {len(stored)}"
                for limit, count in limits.items()
            ),
            lower_bounds=sum(each.is_lower_bound for each in stored),
        )

    def _read_cases(self) -> set[str]:
        """Return the cases that have failed; keep the results of the others."""
        failed = set()
        for row in self._stored.select(record="case"):
            key = row.case, 0
            if row.get("state") != "done":
                failed.add(row.case)
            elif self._of_cases:
                self._keep(key, row, not row.get("unconverged", 0))
        return failed

    def _read_steps(self) -> None:
        """Keep the values of steps that were added since the last call."""
        for row in self._stored.select(f"id>{self._newest}"):
            self._newest = max(self._newest, row.id)
            same = np.isclose(
                self._at, row.get(self._key, math.nan), rtol=1e-9, atol=0.0
            )
            if same.any():
                self._keep((row.case, int(same.argmax())), row, row.converged)

    def _keep(self, key: tuple[str, int], row: Any, converged: bool) -> None:
        """Keep the value of a row, or that it has none."""
        value = row.get(self.column, math.nan)
        if not converged or math.isnan(value):
            self._failed.add(key)
            self._values.pop(key, None)
            return
        self._failed.discard(key)
        error = row.get(self._error, math.nan) if self._error else math.nan
        bounds = row.get("lower_bounds", "").split(_LIST_SEPARATOR)
        limits = tuple(_limits(row))
        self._values[key] = _Value(value, error, limits, self.column in bounds)


def _columns_of_steps(scene: Scene) -> dict[str, Any]:
    """Return the columns of numbers that have means: none if targets are not given."""
    path = scene.path
    if path.count(scene.bodies) is None and path.schedule(scene.bodies) is None:
        return {}
    types = step_types()
    columns = columns_of(scene.record).items()
    return {k: each for k, each in columns if types.get(k, float) in (int, float)}


def _targets(scene: Scene) -> tuple[str, np.ndarray, np.ndarray]:
    """Return the column that selects the rows, its values, and the targets there.

    Paths in time have means at the ends of their parts at the deepest target.
    """
    schedule = scene.path.schedule(scene.bodies)
    if schedule is None:
        return "step", np.arange(len(scene.targets)), scene.targets
    parts = list(schedule.timed_parts())
    deepest = scene.path.deepest_of(part.end for _, _, part in parts)
    ends = [t + part.duration for t, _, part in parts if part.end == deepest]
    times = np.unique(ends)
    return "time", times, times


def _limits(row: Any) -> Iterator[str]:
    """Yield the names of the limits in the row of a step or a case."""
    text = row.get("validity", "")
    if row.record == "case":
        yield from filter(None, text.split(_LIST_SEPARATOR))
    else:
        yield from (check.name for check in failed_checks(text).values())
