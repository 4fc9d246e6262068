"""Residuals of one sign in a row: warnings, and standard errors that count them."""

from __future__ import annotations

import math

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray

#: Smallest mean of residuals of one sign in a row, relative to its standard error, that
#: is not noise.
MIN_SIGNIFICANCE = 6.0
# Smallest reported mean of such residuals, relative to the largest force.
_MIN_RELATIVE_MEAN = 0.01


def points_per_value(residual: FloatArray) -> float:
    """Return how many neighbouring residuals count as one, at least 1.

    White noise changes its sign at every second point, correlated residuals less often.

    Parameters
    ----------
    residual : ndarray, shape (k,)
        Residuals in the order of the points, in any unit.

    Returns
    -------
    float
    """
    changes = int(np.sum(np.diff(np.sign(residual)) != 0.0))
    return max(len(residual) / (2.0 * (changes + 1)), 1.0)


def standard_errors(slopes: FloatArray, residual: FloatArray) -> FloatArray:
    """Return the standard errors of fitted parameters by the linearised problem.

    Parameters
    ----------
    slopes : ndarray, shape (k, n)
        Derivatives of the fitted values by the parameters.
    residual : ndarray, shape (k,)
        Residuals in the order of the points.

    Returns
    -------
    ndarray, shape (n,)
        Standard errors; neighbouring residuals count as by `points_per_value`.
    """
    degrees = max(len(residual) - slopes.shape[1], 1)
    variance = points_per_value(residual) * float(residual @ residual) / degrees
    inverse = np.linalg.pinv(slopes)
    return np.sqrt(variance * np.sum(inverse**2, axis=1))


def systematic_residuals(
    residual: FloatArray, noise: float, largest: float
) -> list[str]:
    """Return a warning of residuals of one sign in a row; empty without.

    Parameters
    ----------
    residual : ndarray, shape (k,)
        Fitted less measured forces (eV/Å).
    noise : float
        Standard deviation of the noise of the force (eV/Å).
    largest : float
        Largest force (eV/Å).

    Returns
    -------
    list of str
    """
    changes = np.flatnonzero(np.diff(np.sign(residual)))
    runs = np.split(residual, changes + 1)
    run = max(runs, key=lambda each: abs(each.mean()) * math.sqrt(len(each)))
    mean = float(run.mean())
    is_noise = abs(mean) * math.sqrt(len(run)) < MIN_SIGNIFICANCE * noise
    if is_noise or abs(mean) < _MIN_RELATIVE_MEAN * largest:
        return []
    return [
        f"the fit is {mean / UNITS['nN']:+.3g} nN off on {len(run)} points in a row: "
        "this is not the indenter on such a solid (adhesion, another shape, a layer, "
        "drag), and the error does not contain it"
    ]
