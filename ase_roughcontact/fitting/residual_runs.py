"""Residuals of one sign in a row: warnings, and the number of independent points."""

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
