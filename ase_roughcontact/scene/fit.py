"""Least-squares fit of a measured force curve by relaxed states of a scene."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ase_roughcontact._util.printing import Printed, number, table
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, lookup
from ase_roughcontact.scene.fit_parameters import FREE
from ase_roughcontact.scene.force_curve import BASELINE, ForceCurve
from ase_roughcontact.scene.residuals import Residuals
from ase_roughcontact.scene.scene import Scene

#: Part of the expected error from which a difference is far above it.
FAR_ABOVE = 3.0
# Relative change of parameters, and of the sum of squares, at which a fit ends.
_CONVERGED = 1e-5
# A fit ends if the best parameters are this part of their standard errors off, by
# linear extrapolation, or after so many trials without a smaller sum of squares.
_CLOSE = 0.1
_MOST_IN_VAIN = 5
# Relative decrease of the sum of squares that is progress.
_PROGRESS = 1e-3
# Mean of residuals of one sign in a row, relative to its standard error, that is no
# noise.
_SYSTEMATIC = 6.0
# Residual of the height of the base at a jump, less the error by the grid, relative to
# its standard error, that is not that of the scene: 1.7 is half a step of the base.
_OFF_AT_JUMP = 4.0
# Distance of the points at a jump, relative to the others, from which it is a gap.
_GAP = 5.0
# Correlation from which two parameters can't be distinguished.
_CORRELATED = 0.99
#: Standard uncertainty of the logarithm of the range of the attraction, which a scene
#: assumes: a factor of two.
RANGE_UNCERTAINTY = math.log(2.0)


@dataclass(frozen=True, eq=False)
class Fit(Printed):
    """Result of `fit_curve`.

    Attributes
    ----------
    names : tuple of str
        Free parameters: those of the scene, of the baseline, and ``height_offset``, the
        height at which the depth of the curve is zero.
    units : tuple of str
    values, errors : ndarray, shape (p,)
        Values and their standard errors, to which all `contributions` add.
    contributions : dict of ndarray, shape (p,)
        Parts of the errors: of the ``"noise"``, of an uncertainty of a factor
        of two of the ``"range"`` of the attraction, and of the ``"grid"``.
    correlation : ndarray, shape (p, p)
        Correlations of the errors by noise.
    distance : ndarray, shape (k,)
        Measured heights of the base, or of the tip without a cantilever (Å).
    force, fitted : ndarray, shape (k,)
        Measured and fitted forces, with the baseline (eV/Å).
    compared : ndarray of bool, shape (k,)
        Points that are compared: not those at a jump.
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
        free tip with a force that is not fitted, parameters that are nearly one, or a
        curve that seems reversed.
    abscissa, ordinate : (str, str)
        Names and units of what `distance` and `force` are: of a path in time the time,
        and under given loads the penetration.
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
    far_force: float
    warnings: tuple[str, ...] = ()
    abscissa: tuple[str, str] = ("distance of the base", "nm")
    ordinate: tuple[str, str] = ("normal force $N$", "nN")
    line: tuple[FloatArray, FloatArray] | None = None

    @property
    def parts(self) -> list[Any]:
        """Parameters with standard errors, correlations, noise and warnings."""
        heads = ["parameter", "value", "± error", "unit", *self.contributions]
        unit = self.ordinate[1]
        noise = ["noise", number(self.noise / UNITS[unit], 3), "", unit]
        rows = [
            [
                name,
                number(self.values[i], 5),
                number(self.errors[i], 2),
                self.units[i],
                *(number(errors[i], 2) for errors in self.contributions.values()),
            ]
            for i, name in enumerate(self.names)
        ]
        return [
            table(heads, [*rows, [*noise, *("" for _ in self.contributions)]], left=1),
            *(
                f"correlation of {a} and {b}: {self.correlation[i, j]:.3f}"
                for i, a in enumerate(self.names)
                for j, b in enumerate(self.names[:i])
            ),
            *(f"warning: {warning}" for warning in self.warnings),
            *(() if self.converged else ("NOT CONVERGED",)),
        ]


def fit_curve(
    scene: Scene,
    curve: ForceCurve,
    free: Sequence[str] = ("work_of_adhesion",),
    callback: Callable[[dict[str, float], float], None] | None = None,
) -> Fit:
    """Fit parameters of a scene to a measured force curve.

    Parameters
    ----------
    scene : Scene
        Initial values of the parameters, and all others. Of its path only the
        `tolerance` is used.
    curve : ForceCurve
        Approach, retraction, or both; with the stiffness of the cantilever if the tip
        snaps in or is pulled off.
    free : sequence of str
        Parameters of the scene among `FREE`, and of the measured forces among
        `BASELINE`: ``force_offset``, the force that the instrument shows for a free
        tip with the base at its highest point, and ``force_slope``, the slope of this
        force with the height of the base.
    callback : callable, optional
        Called after each trial with the parameters by name, in the units of the fit,
        and the root mean square of the residuals relative to the noise.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        If a parameter is unknown, there are too few points, or the wall of the scene
        has no work of adhesion that could be fitted.

    Notes
    -----
    Standard errors and correlations are those of the linearised problem, with the
    standard deviation of the residuals as that of the data. What the scene assumes adds
    to them: the range of the attraction, which a force curve hardly shows, with a
    standard uncertainty of a factor of two, whose effects on either branch, the snap-in
    and the pull-off are added without their signs, as they depend on the form of the
    attraction; and the grid, by the change of the forces on one of half the spacing,
    for which the last trial is repeated.
    """
    for name in free:
        lookup(name, {**FREE, **BASELINE}, "free parameter")
    if len(curve.depth) < len(free) + 2:
        raise ValueError(
            f"a fit of {len(free) + 1} parameters needs at least {len(free) + 2} "
            f"points, got {len(curve.depth)}"
        )
    if "work_of_adhesion" in free and not scene.wall.attractive:
        raise ValueError(
            "work_of_adhesion can't be fitted, as the wall of the scene only repels: "
            'give [interaction] kind = "adhesive", or other free parameters'
        )
    for doubt in curve.doubts:
        warnings.warn(doubt, stacklevel=2)
    try:
        return _fitted(Residuals(scene, curve, free), curve, callback)
    except (ValueError, RuntimeError) as error:
        if not curve.doubts:
            raise
        message = f"{curve.doubts[0]} The fit ended with: {error}"
        raise ValueError(message) from error


class _Trials:
    """Residuals of the trials of a fit, the best of which is its result."""

    def __init__(
        self,
        problem: Residuals,
        callback: Callable[[dict[str, float], float], None] | None,
    ) -> None:
        self._problem, self._callback = problem, callback
        self._least, self._in_vain = math.inf, 0
        self.best, self.distance = problem.start, math.inf
        self.doubts: list[str] = []

    def residuals(self, x: FloatArray) -> FloatArray:
        """Return the residuals of a trial; StopIteration if it is the last one."""
        problem = self._problem
        try:
            residuals, jacobian, compared = problem.of(x)
        except (ValueError, RuntimeError, MemoryError) as error:
            if self._least == math.inf:
                raise
            self.doubts = [
                f"the fit ended at a trial that can't be calculated: {error}"
            ]
            raise StopIteration from error
        if self._callback is not None:
            values = dict(zip(problem.names, problem.values(x).tolist(), strict=True))
            self._callback(values, math.sqrt(np.mean(residuals**2)))
        squares = float(residuals @ residuals)
        progress = squares < (1.0 - _PROGRESS) * self._least
        self._in_vain = 0 if progress else self._in_vain + 1
        if squares < self._least:
            change = jacobian @ (np.linalg.pinv(jacobian) @ residuals)
            variance = squares / degrees(compared, x)
            self._least, self.best = squares, x.copy()
            self.distance = math.sqrt(change @ change / variance) if variance else 0.0
        if self.distance < _CLOSE or self._in_vain >= _MOST_IN_VAIN:
            raise StopIteration
        return residuals


def solved(
    problem: Any, callback: Callable[[dict[str, float], float], None] | None
) -> tuple[FloatArray, bool, list[str]]:
    """Return the unknowns with the least sum of squares.

    Parameters
    ----------
    problem : Residuals
        Or another class with `names`, `start`, `bounds`, `values` and `of`.
    callback : callable or None
        See `fit_curve`.

    Returns
    -------
    x : ndarray, shape (p,)
    converged : bool
    doubts : list of str
        Why the fit ended early.
    """
    trials = _Trials(problem, callback)
    try:
        solution = least_squares(
            trials.residuals,
            problem.start,
            jac=lambda x: problem.of(x)[1],
            bounds=problem.bounds,
            x_scale="jac",
            xtol=_CONVERGED,
            ftol=_CONVERGED,
        )
        converged = bool(solution.success)
    except StopIteration:
        converged = trials.distance < 1.0
    return trials.best, converged, trials.doubts


def degrees(compared: np.ndarray, x: FloatArray) -> int:
    """Return the number of degrees of freedom."""
    return max(int(compared.sum()) - len(x), 1)


def _fitted(
    problem: Residuals,
    curve: ForceCurve,
    callback: Callable[[dict[str, float], float], None] | None,
) -> Fit:
    """Return the solution of the least-squares problem."""
    x, converged, ended = solved(problem, callback)
    residuals, jacobian, compared = problem.of(x)
    squares = np.sum(residuals[compared] ** 2)
    noise = curve.noise * math.sqrt(squares / degrees(compared, x))
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * (noise / curve.noise) ** 2
    deviation = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(deviation, deviation)
    to_parameters = np.linalg.pinv(jacobian)
    by_range = to_parameters * RANGE_UNCERTAINTY * problem.change_by_range(x)
    count = len(curve.depth)  # then follow the jumps
    parts = [branch.points for branch in curve.branches]
    parts += [slice(count, count + 1), slice(count + 1, count + 2)]
    by_grid = problem.change_by_grid(x)
    contributions = {
        "noise": deviation * problem.scale,
        "range": sum(abs(by_range[:, part].sum(1)) for part in parts) * problem.scale,
        "grid": abs(to_parameters @ by_grid) * problem.scale,
    }
    at_jumps = np.sign(residuals) * np.maximum(abs(residuals) - abs(by_grid), 0.0)
    errors = np.sqrt(sum(part**2 for part in contributions.values()))
    parameters = problem.names, problem.units, problem.values(x), errors, contributions
    points = curve.base, curve.force, problem.forces(x), compared[:count]
    state = noise, converged, curve.far_force
    found = Fit(*parameters, correlation, *points, *state)
    doubts = _warnings(problem, curve, found)
    doubts += _jump_warnings(curve, at_jumps[count:], compared[count:])
    return replace(found, warnings=(*ended, *doubts), line=problem.line(x))


def _jump_warnings(
    curve: ForceCurve, residuals: FloatArray, compared: np.ndarray
) -> Iterator[str]:
    """Yield warnings of jumps that are in a gap, or not where they were measured."""
    for branch, residual, known in zip(
        curve.branches, residuals, compared, strict=False
    ):
        name = "snap-in" if branch.direction < 0.0 else "pull-off"
        base = curve.base[branch.points] / UNITS["nm"]
        steps = abs(np.diff(base))
        if known and steps[branch.jump] > _GAP * np.median(steps):
            first, last = sorted(base[branch.jump :][:2])
            yield (
                f"the {name} is in a gap of the measured points, with the base at "
                f"{first:.4g} to {last:.4g} nm: the fit, and that of a smooth sphere, "
                "know it no better than that"
            )
        if abs(residual) > _OFF_AT_JUMP:
            yield (
                f"the {name} of the fit is {abs(residual):.1f} standard errors "
                f"{'above' if residual > 0.0 else 'below'} the measured one: the range "
                "of the attraction is another one (--free attraction_range, or a wall "
                "of another kind), or another force acts in contact, such as a "
                "capillary one, which the work of adhesion then contains; the errors "
                "do not contain this"
            )


def _systematic(
    curve: ForceCurve, residual: FloatArray, kept: np.ndarray
) -> Iterator[tuple[float, np.ndarray, float]]:
    """Yield mean, points and significance of residuals of one sign in a row."""
    for branch in curve.branches:
        points = np.arange(len(residual))[branch.points][kept[branch.points]]
        changes = np.flatnonzero(np.diff(np.sign(residual[points])))
        for part in np.split(points, changes + 1):
            mean = float(residual[part].mean()) if part.size else 0.0
            yield mean, part, abs(mean) * math.sqrt(part.size) / curve.noise


def _warnings(problem: Residuals, curve: ForceCurve, fit: Fit) -> list[str]:
    """Return reasons to doubt a fit by its residuals."""
    found, names, noise = list(curve.doubts), fit.names, fit.noise
    error_of_force = problem.tolerance * float(abs(curve.force).max())
    if noise > FAR_ABOVE * max(curve.noise, error_of_force):
        found.append(
            f"the residuals of {noise / UNITS['nN']:.3g} nN are far above the noise of "
            f"the curve, {curve.noise / UNITS['nN']:.3g} nN: the scene does not "
            "describe it, or a column is another quantity (depth = -(distance + "
            "deflection)), and the errors of the parameters are not valid"
        )
    runs = _systematic(curve, fit.fitted - curve.force, fit.compared)
    mean, points, sigmas = max(runs, key=lambda each: each[2])
    if sigmas > _SYSTEMATIC and abs(mean) > error_of_force:
        first, last = sorted(curve.base[points[[0, -1]]] / UNITS["nm"])
        found.append(
            f"the fit is {mean / UNITS['nN']:+.3g} nN off on {len(points)} points in a "
            f"row, with the base at {first:.4g} to {last:.4g} nm: there the curve is "
            "not that of the scene. Fit a baseline (force_offset, force_slope), choose "
            "a wall of another range or kind, or leave out forces that are not in the "
            "model, such as capillary ones; the errors do not contain this"
        )
    found += correlated(names, fit.correlation, "depths")
    is_free = abs(fit.fitted[curve.far]).max() < curve.noise
    if "force_offset" not in names and is_free:
        error = noise / math.sqrt(len(curve.far))
        if abs(curve.far_force) > FAR_ABOVE * error:
            found.append(
                f"the free part of the curve is at {curve.far_force / UNITS['nN']:.3g} "
                "nN, not zero: give force_offset in --free, too"
            )
    return found


def correlated(names: Sequence[str], correlation: FloatArray, along: str) -> list[str]:
    """Return warnings of parameters that a curve can't distinguish."""
    return [
        f"{a} and {b} can't both be determined, the correlation of their errors is "
        f"{correlation[i, j]:.4f}: fix one of them, or measure a larger range of "
        f"{along}"
        for i, a in enumerate(names)
        for j, b in enumerate(names[:i])
        if abs(correlation[i, j]) > _CORRELATED
    ]
