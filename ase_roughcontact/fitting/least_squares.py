"""Least-squares solution of a fit: parameters, their errors, and reasons to doubt."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ase_roughcontact._util.printing import Printed, number, table
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.units import PRESSURES, UNITS, pressure_unit
from ase_roughcontact._util.validation import FloatArray

#: Ratio of a difference to the expected error above which there is a warning.
FAR_ABOVE = 3.0
# Relative change of parameters, and of the sum of squares, at which a fit ends.
_RELATIVE_TOLERANCE = 1e-5
# Largest distance to the solution by linear extrapolation, relative to the standard
# errors, at which a fit ends.
_MAX_DISTANCE = 0.1
# Number of trials in a row without a smaller sum of squares after which a fit ends.
_MAX_STALLED = 5
# Smallest relative decrease of the sum of squares that is progress.
_MIN_DECREASE = 1e-3
#: Largest correlation of two parameters that can be distinguished.
MAX_CORRELATION = 0.99
# Largest part of a parameter that the residuals do not determine, with which the
# parameter has an error.
_MAX_UNDETERMINED_PART = 1e-6
# Change of the unknowns for derivatives of the parameters.
_DIFFERENCE_STEP = 1e-6
#: Standard uncertainty of the logarithm of the range of the attraction, which a scene
#: assumes: a factor of two.
RANGE_UNCERTAINTY = math.log(2.0)

#: Called after each trial with the parameters by name, in the units of the fit, and the
#: root mean square of the residuals relative to the noise.
Callback = Callable[[dict[str, float], float], None]


@dataclass(frozen=True, eq=False)
class Fit(Summarized, Printed):
    """Result of `fit_curve` or `fit_in_time`.

    Attributes
    ----------
    names : tuple of str
        Free parameters of the scene and of the baseline, and ``height_offset``, the
        height at which the depth of the curve is zero.
    units : tuple of str
        Units of the parameters.
    values, errors : ndarray, shape (p,)
        Values and their standard errors, to which all `contributions` add; NaN of
        parameters that the points do not determine.
    contributions : dict of ndarray, shape (p,)
        Parts of the errors: by the ``"noise"``, by an uncertainty of a factor of two of
        the ``"range"`` of the attraction, and by the ``"grid"``.
    correlation : ndarray, shape (p, p)
        Correlations of the errors by noise.
    distance : ndarray, shape (k,)
        Measured heights of the base, or of the tip without a cantilever (Å).
    force, fitted : ndarray, shape (k,)
        Measured and fitted forces, with the baseline (eV/Å).
    compared : ndarray of bool, shape (k,)
        Points that are compared: all but the points at a jump.
    noise : float
        Standard deviation of the residuals of the compared points (eV/Å).
    converged : bool
        Whether the least-squares solution has converged, to a tenth of the errors by
        noise.
    far_force : float
        Median of the measured forces furthest from the surface (eV/Å).
    warnings : tuple of str
        Reasons to doubt the fit: residuals far above the noise of neighbouring points,
        or of one sign over a part of the curve, a snap-in or a pull-off elsewhere, a
        free tip with a force that is not fitted, strongly correlated parameters, or a
        curve that seems reversed.
    abscissa, ordinate : (str, str)
        Names and units of the quantities in `distance` and `force`: on a path in time
        the former is the time, under given loads the latter is the penetration.
    line : (ndarray, ndarray) or None
        Heights of the base (Å) and fitted forces (eV/Å) on many points for a figure;
        None on a path in time.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: FloatArray
    errors: FloatArray
    contributions: dict[str, FloatArray]
    correlation: FloatArray
    distance: FloatArray
    force: FloatArray
    fitted: FloatArray
    compared: np.ndarray
    noise: float
    converged: bool
    far_force: float = math.nan
    warnings: tuple[str, ...] = ()
    abscissa: tuple[str, str] = ("distance of the base", "nm")
    ordinate: tuple[str, str] = ("normal force $N$", "nN")
    line: tuple[FloatArray, FloatArray] | None = None

    @property
    def parts(self) -> list[Any]:
        """Parameters with errors, correlations, and warnings, in printed form."""
        heads = ["parameter", "value", "± error", "unit", *self.contributions]
        force = self.ordinate[1]
        noise = ["noise", number(self.noise / UNITS[force], 3), "", force]
        rows = []
        for i, name in enumerate(self.names):
            # moduli of soft solids in kPa or Pa
            unit = self.units[i]
            if unit in PRESSURES:
                unit = pressure_unit(self.values[i] * UNITS[unit])
            scale = UNITS[self.units[i]] / UNITS[unit]
            value, error = scale * self.values[i], scale * self.errors[i]
            row = [name, number(value, 5), number(error, 2), unit]
            for errors in self.contributions.values():
                row.append(number(scale * errors[i], 2))
            rows.append(row)
        rows.append(noise + [""] * len(self.contributions))
        parts: list[Any] = [] if self.converged else ["NOT CONVERGED"]
        parts.append(table(heads, rows, left=1))
        for i, first in enumerate(self.names):
            for j, second in enumerate(self.names[:i]):
                correlation = f"{self.correlation[i, j]:.3f}"
                parts.append(f"correlation of {first} and {second}: {correlation}")
        parts += [f"warning: {warning}" for warning in self.warnings]
        return parts


@dataclass(frozen=True, eq=False)
class Trial:
    """Curve of a model for some values of its p parameters.

    Attributes
    ----------
    unknowns : ndarray, shape (p,)
        Values of the unknowns of the model.
    residuals : ndarray, shape (n,)
        Residuals of the k points and of the jumps, relative to the noise.
    jacobian : ndarray, shape (n, p)
        Derivatives of the residuals to the unknowns.
    compared : ndarray of bool, shape (n,)
        Residuals that count in the sum of squares.
    fitted : ndarray, shape (k,)
        Values of the curve at the measured points.
    """

    unknowns: FloatArray
    residuals: FloatArray
    jacobian: FloatArray
    compared: np.ndarray
    fitted: FloatArray


class _Trials:
    """Trials of a fit; the best trial is the result."""

    best: Trial

    def __init__(self, model: Any, callback: Callback | None) -> None:
        self._model, self._callback = model, callback
        self._least, self._stalled = math.inf, 0
        self.distance, self.doubts = math.inf, list[str]()
        self._last: Trial | None = None

    def residuals(self, x: FloatArray) -> FloatArray:
        """Return the residuals of a trial; StopIteration if it is the last one."""
        try:
            self._last = trial = self._model.trial(x.copy())
        except (ValueError, ArithmeticError, RuntimeError, MemoryError) as error:
            if self._least == math.inf:
                raise
            self.doubts = [
                f"the fit ended at a trial that can't be calculated: {error}"
            ]
            raise StopIteration from error
        residuals = trial.residuals
        if self._callback is not None:
            values = self._model.values(x).tolist()
            named = dict(zip(self._model.names, values, strict=True))
            self._callback(named, math.sqrt(np.mean(residuals**2)))
        squares = float(residuals @ residuals)
        progress = squares < (1.0 - _MIN_DECREASE) * self._least
        self._stalled = 0 if progress else self._stalled + 1
        if squares < self._least:
            change = trial.jacobian @ (np.linalg.pinv(trial.jacobian) @ residuals)
            variance = squares / _degrees(trial)
            self._least, self.best = squares, trial
            self.distance = math.sqrt(change @ change / variance) if variance else 0.0
        if self.distance < _MAX_DISTANCE or self._stalled >= _MAX_STALLED:
            raise StopIteration
        return residuals

    def jacobian(self, x: FloatArray) -> FloatArray:
        """Return the derivatives of the residuals, mostly known from the last trial."""
        last = self._last
        if last is None or not np.array_equal(last.unknowns, x):
            last = self._last = self._model.trial(x.copy())
        return last.jacobian


def solve(
    model: Any, callback: Callback | None
) -> tuple[Fit, Any, Mapping[str, FloatArray]]:
    """Return the fit with the least sum of squares.

    Parameters
    ----------
    model : Residuals or TimeModel
        Model with `names` and `units` of p parameters, and their `values(x)` for the
        unknowns x; first values `start` and `bounds` of x; the points that were
        `measured`, the names and units `abscissa` and `ordinate` of their coordinates,
        their `noise`, and the `error` of a `trial(x)`; the `changes(trial)` of
        residuals by uncertain assumptions, in m columns that are added without their
        signs; and the `reasons` for residuals far above noise.
    callback : callable or None
        See `Callback`.

    Returns
    -------
    fit : Fit
    trial : Trial
        Trial with the parameters of the fit.
    changes : dict of ndarray, shape (n, m)
        Changes of the residuals of this trial, see `model`.

    Raises
    ------
    ValueError
        If all measured values are equal, or the first trial can't be calculated.
    """
    if not model.noise > 0.0:
        raise ValueError(
            f"the {len(model.measured[1])} measured values are all equal, so that no "
            "parameter follows from them: give the part of the curve in contact"
        )
    trials = _Trials(model, callback)
    try:
        solution = least_squares(
            trials.residuals,
            model.start,
            jac=trials.jacobian,
            bounds=model.bounds,
            x_scale="jac",
            xtol=_RELATIVE_TOLERANCE,
            ftol=_RELATIVE_TOLERANCE,
        )
        converged = bool(solution.success)
    except StopIteration:
        converged = trials.distance < 1.0
    best = trials.best
    scales = _scales(model, best.unknowns)
    inverse = scales @ np.linalg.pinv(best.jacobian)
    squares = np.sum(best.residuals[best.compared] ** 2)
    ratio = math.sqrt(squares / _degrees(best))
    covariance = ratio**2 * inverse @ inverse.T
    undetermined = _undetermined(scales, best.jacobian)
    deviation = np.where(undetermined, math.nan, np.sqrt(np.diag(covariance)))
    changes = model.changes(best)
    contributions = {"noise": deviation} | {
        name: abs(inverse @ change).sum(axis=1) for name, change in changes.items()
    }
    fit = Fit(
        names=model.names,
        units=model.units,
        values=model.values(best.unknowns),
        errors=np.sqrt(sum(part**2 for part in contributions.values())),
        contributions=contributions,
        correlation=_correlation(covariance, deviation),
        distance=model.measured[0],
        force=model.measured[1],
        fitted=best.fitted,
        compared=best.compared[: len(best.fitted)],
        noise=ratio * model.noise,
        converged=converged,
        abscissa=model.abscissa,
        ordinate=model.ordinate,
    )
    return (
        replace(fit, warnings=(*trials.doubts, *_warnings(model, fit))),
        best,
        changes,
    )


def _scales(model: Any, x: FloatArray) -> FloatArray:
    """Return the derivatives of the parameters to the unknowns."""
    steps = _DIFFERENCE_STEP * np.eye(len(x))
    rows = [model.values(x + step) - model.values(x - step) for step in steps]
    return np.transpose(rows) / (2.0 * _DIFFERENCE_STEP)


def _undetermined(scales: FloatArray, jacobian: FloatArray) -> np.ndarray:
    """Return which parameters can change without a change of the residuals."""
    free = np.eye(jacobian.shape[1]) - np.linalg.pinv(jacobian) @ jacobian
    changes: np.ndarray = abs(scales @ free).max(axis=1)
    return changes > _MAX_UNDETERMINED_PART * abs(scales).max(axis=1)


def _correlation(covariance: FloatArray, deviation: FloatArray) -> FloatArray:
    """Return the correlations; NaN where an error is zero or not known."""
    scale = np.outer(deviation, deviation)
    unknown = np.full_like(covariance, np.nan)
    return np.divide(covariance, scale, out=unknown, where=scale > 0.0)


def _degrees(trial: Trial) -> int:
    """Return the number of degrees of freedom."""
    return max(int(trial.compared.sum()) - len(trial.unknowns), 1)


def _warnings(model: Any, fit: Fit) -> Iterator[str]:
    """Yield warnings of systematic residuals, and of undetermined parameters.

    A parameter is undetermined if it does not change the curve, or if it is strongly
    correlated with another one.
    """
    unit = fit.ordinate[1]
    for name, error in zip(fit.names, fit.errors, strict=True):
        if math.isnan(error):
            yield (
                f"the error of {name} is not known, as the compared points do not "
                "determine it: do not fit it, or measure a larger range"
            )
    if fit.noise > FAR_ABOVE * max(model.noise, model.error):
        yield (
            f"the residuals of {fit.noise / UNITS[unit]:.3g} {unit} are far above the "
            f"noise of the curve, {model.noise / UNITS[unit]:.3g} {unit}: "
            f"{model.reasons}; the errors of the parameters are not valid"
        )
    for i, j in zip(*np.tril_indices(len(fit.names), -1), strict=True):
        if abs(fit.correlation[i, j]) > MAX_CORRELATION:
            yield (
                f"{fit.names[i]} and {fit.names[j]} can't both be determined, the "
                f"correlation of their errors is {fit.correlation[i, j]:.4f}: fix one "
                "of them, or measure a larger range"
            )
