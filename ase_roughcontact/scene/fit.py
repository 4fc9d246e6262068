"""Least-squares fit of a measured force curve by relaxed states of a scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray, lookup
from ase_roughcontact.scene.force_curve import ForceCurve
from ase_roughcontact.scene.parameters import FREE
from ase_roughcontact.scene.residuals import Residuals
from ase_roughcontact.scene.scene import Scene

# Limits of a parameter relative to its first value.
_LEAST, _MOST = 0.05, 20.0
# Relative change of parameters, and of the sum of squares, at which a fit ends.
_CONVERGED = 1e-5


@dataclass(frozen=True, eq=False)
class Fit:
    """Result of `fit_curve`.

    Attributes
    ----------
    names : tuple of str
        Free parameters; the last one is the height z0.
    units : tuple of str
    values, errors : ndarray, shape (p,)
        Values and their standard errors.
    correlation : ndarray, shape (p, p)
        Correlations of the errors.
    distance : ndarray, shape (k,)
        Measured heights of the base, or of the tip without a cantilever (Å).
    force, fitted : ndarray, shape (k,)
        Measured and fitted forces (eV/Å).
    compared : ndarray of bool, shape (k,)
        Points that are compared: not those at a jump.
    noise : float
        Standard deviation of the residuals of the compared points (eV/Å).
    converged : bool
        Whether the least-squares solution has converged.
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

    def __str__(self) -> str:
        """Return parameters with standard errors, correlations and noise."""
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
        return "\n".join(lines if self.converged else [*lines, "NOT CONVERGED"])


def fit_curve(
    scene: Scene, curve: ForceCurve, free: Sequence[str] = ("work_of_adhesion",)
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
        Parameters among `FREE`.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        If a parameter is unknown, or there are too few points.

    Notes
    -----
    Standard errors and correlations are those of the linearised problem, with the
    standard deviation of the residuals as that of the data.
    """
    for name in free:
        lookup(name, FREE, "free parameter")
    if len(curve.depth) < len(free) + 2:
        raise ValueError(
            f"a fit of {len(free) + 1} parameters needs at least {len(free) + 2} "
            f"points, got {len(curve.depth)}"
        )
    problem = Residuals(scene, curve, free)
    solution = least_squares(
        lambda x: problem.of(x)[0],
        np.append(np.ones(len(free)), 0.0),
        jac=lambda x: problem.of(x)[1],
        bounds=([_LEAST] * len(free) + [-np.inf], [_MOST] * len(free) + [np.inf]),
        x_scale="jac",
        xtol=_CONVERGED,
        ftol=_CONVERGED,
    )
    residuals, jacobian, compared = problem.of(solution.x)
    degrees = max(int(compared.sum()) - len(solution.x), 1)
    noise = curve.noise * math.sqrt(np.sum(residuals[compared] ** 2) / degrees)
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * (noise / curve.noise) ** 2
    deviation = np.sqrt(np.diag(covariance))
    return Fit(
        (*free, "height z0"),
        (*(FREE[name][1] for name in free), "Å"),
        problem.values(solution.x),
        deviation * problem.scale,
        covariance / np.outer(deviation, deviation),
        curve.base,
        curve.force,
        problem.forces(solution.x),
        compared[: len(curve.depth)],
        noise,
        bool(solution.success),
    )
