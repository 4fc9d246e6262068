"""Least-squares fit of a measured force curve by relaxed states of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, lookup
from ase_roughcontact.scene.force_curve import BASELINE, ForceCurve
from ase_roughcontact.scene.parameters import FREE
from ase_roughcontact.scene.residuals import Residuals
from ase_roughcontact.scene.scene import Scene

# Part of the expected error from which a difference is far above it.
_FAR_ABOVE = 3.0
# Relative change of parameters, and of the sum of squares, at which a fit ends.
_CONVERGED = 1e-5


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of `fit_curve`.

    Attributes
    ----------
    names : tuple of str
        Free parameters: those of the scene, of the baseline, and ``height_offset``, the
        height at which the depth of the curve is zero.
    units : tuple of str
    values, errors : ndarray, shape (p,)
        Values and their standard errors.
    correlation : ndarray, shape (p, p)
        Correlations of the errors.
    distance : ndarray, shape (k,)
        Measured heights of the base, or of the tip without a cantilever (Å).
    force, fitted : ndarray, shape (k,)
        Measured and fitted forces, with the baseline (eV/Å).
    compared : ndarray of bool, shape (k,)
        Points that are compared: not those at a jump.
    noise : float
        Standard deviation of the residuals of the compared points (eV/Å).
    converged : bool
        Whether the least-squares solution has converged.
    far_force : float
        Median of the measured forces furthest from the surface (eV/Å).
    warnings : tuple of str
        Reasons to doubt the fit: residuals far above the noise of neighbouring points,
        or a free tip with a force that is not fitted.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    values: FloatArray
    errors: FloatArray
    correlation: FloatArray
    distance: FloatArray
    force: FloatArray
    fitted: FloatArray
    compared: np.ndarray
    noise: float
    converged: bool
    far_force: float
    warnings: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Return parameters with standard errors, correlations, noise and warnings."""
        lines = [
            f"{name:<18}{value:12.5g} ± {error:.2g} {unit}"
            for name, value, error, unit in zip(
                self.names, self.values, self.errors, self.units, strict=True
            )
        ]
        lines.append(f"{'noise':<18}{self.noise / UNITS['nN']:12.3g} nN")
        lines += [
            f"correlation of {a} and {b}: {self.correlation[i, j]:.3f}"
            for i, a in enumerate(self.names)
            for j, b in enumerate(self.names[:i])
        ]
        lines += [f"warning: {warning}" for warning in self.warnings]
        return "\n".join(lines if self.converged else [*lines, "NOT CONVERGED"])


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
    standard deviation of the residuals as that of the data.
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
    try:
        return _fitted(Residuals(scene, curve, free), curve, callback)
    except (ValueError, RuntimeError) as error:
        if not curve.doubts:
            raise
        message = f"{curve.doubts[0]} The fit ended with: {error}"
        raise ValueError(message) from error


def _fitted(
    problem: Residuals,
    curve: ForceCurve,
    callback: Callable[[dict[str, float], float], None] | None,
) -> Fit:
    """Return the solution of the least-squares problem."""

    def residuals_of(x: FloatArray) -> FloatArray:
        residuals = problem.of(x)[0]
        if callback is not None:
            values = dict(zip(problem.names, problem.values(x).tolist(), strict=True))
            callback(values, math.sqrt(np.mean(residuals**2)))
        return residuals

    solution = least_squares(
        residuals_of,
        problem.start,
        jac=lambda x: problem.of(x)[1],
        bounds=problem.bounds,
        x_scale="jac",
        xtol=_CONVERGED,
        ftol=_CONVERGED,
    )
    residuals, jacobian, compared = problem.of(solution.x)
    degrees = max(int(compared.sum()) - len(solution.x), 1)
    noise = curve.noise * math.sqrt(np.sum(residuals[compared] ** 2) / degrees)
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * (noise / curve.noise) ** 2
    deviation = np.sqrt(np.diag(covariance))
    fitted, kept = problem.forces(solution.x), compared[: len(curve.depth)]
    return Fit(
        problem.names,
        problem.units,
        problem.values(solution.x),
        deviation * problem.scale,
        covariance / np.outer(deviation, deviation),
        curve.base,
        curve.force,
        fitted,
        kept,
        noise,
        bool(solution.success),
        curve.far_force,
        tuple(_warnings(problem, curve, fitted, noise)),
    )


def _warnings(
    problem: Residuals, curve: ForceCurve, fitted: FloatArray, noise: float
) -> list[str]:
    """Return reasons to doubt a fit with the given forces and residuals."""
    found = []
    expected = max(curve.noise, problem.tolerance * float(abs(curve.force).max()))
    if noise > _FAR_ABOVE * expected:
        found += curve.doubts
        found.append(
            f"the residuals of {noise / UNITS['nN']:.3g} nN are far above the noise of "
            f"the curve, {curve.noise / UNITS['nN']:.3g} nN: the scene does not "
            "describe it, or a column is not what it should be (depth = -(distance + "
            "deflection)), and the errors of the parameters are not valid"
        )
    is_free = abs(fitted[curve.far]).max() < curve.noise
    if "force_offset" not in problem.names and is_free:
        error = noise / math.sqrt(len(curve.far))
        if abs(curve.far_force) > _FAR_ABOVE * error:
            found.append(
                f"the free part of the curve is at {curve.far_force / UNITS['nN']:.3g} "
                "nN, not zero: give force_offset in --free, too"
            )
    return found
