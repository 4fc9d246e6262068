"""Fit of kappa to area against force."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import (
    nonnegative_array,
    positive,
    positive_array,
)

# Least number of points of a fit with a standard error.
_FEWEST = 3


@dataclass(frozen=True)
class KappaFit:
    """Proportionality of contact area and force.

    Attributes
    ----------
    kappa, standard_error : float
        Dimensionless.
    points : int
        Number of points that were fitted.
    """

    kappa: float
    standard_error: float
    points: int


def fit_kappa(
    normal_force: ArrayLike,
    contact_area: ArrayLike,
    rms_slope: float,
    contact_modulus: float,
    limits: tuple[float, float] = (0.0, np.inf),
    area_error: ArrayLike | None = None,
) -> KappaFit:
    r"""Fit kappa to area against force in the linear range.

    .. math:: A_i = \kappa x_i + \epsilon_i, \quad x = \frac{N}{h' E^*}, \qquad
              \kappa = \frac{\sum x_i A_i/\sigma_i^2}{\sum x_i^2/\sigma_i^2}, \quad
              s_\kappa^2 = \frac{\sum (A_i - \kappa x_i)^2/\sigma_i^2}
                                {(n - 1) \sum x_i^2/\sigma_i^2}

    Parameters
    ----------
    normal_force, contact_area : array_like, shape (k,)
        N (eV/Å) and A (Å^2), not negative.
    rms_slope : float
        h', dimensionless.
    contact_modulus : float
        E* (eV/Å^3).
    limits : (float, float)
        Smallest and largest force of the linear range (eV/Å), see the notes. Default:
        all positive forces.
    area_error : array_like, shape (k,) or a number, optional
        Standard deviation sigma of the areas, up to a common factor (Å^2); by default
        the same for all. With the area itself, as for an error in per cent, kappa is
        the weighted mean of the ratios A/x.

    Returns
    -------
    KappaFit
        The standard error follows from the scatter of the points about the line.

    Raises
    ------
    ValueError
        If an argument is invalid, or fewer than three points are within the limits.

    Notes
    -----
    The range is selected by the force, which is controlled: selection by the area,
    which scatters, would be biased towards small areas. Below the range a few
    asperities carry the load; above it the area saturates. On rough flats
    of area A0, eq. (2) of the reference falls below the line by the fraction
    ``(pi/12) (kappa N/(A0 h' E*))^2``, 0.3 % at a tenth of full contact. On a sphere
    A0 is the Hertz area, so that the range ends well below
    `theory.crossover_load`. The standard error is that of independent points. Points of
    one realisation at increasing load are correlated: fit each realisation, and use
    the scatter of their kappas.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), before eq. (2).
    """
    positive(rms_slope=rms_slope, contact_modulus=contact_modulus)
    force = nonnegative_array("normal_force", normal_force)
    area = nonnegative_array("contact_area", contact_area)
    if force.ndim != 1 or force.shape != area.shape:
        raise ValueError(
            "normal_force and contact_area must be one-dimensional and of the same "
            "length, got shapes "
            f"{force.shape} and {area.shape}"
        )
    sigma = positive_array("area_error", 1.0 if area_error is None else area_error)
    if sigma.shape not in ((), force.shape):
        raise ValueError(
            f"area_error must be a number or have the shape {force.shape} of the "
            f"areas, got {sigma.shape}"
        )
    least, largest = limits
    if not 0.0 <= least < largest:
        raise ValueError(f"limits must be forces, 0 <= least < largest, got {limits}")
    used = (force >= least) & (force <= largest) & (force > 0.0)
    points = int(np.count_nonzero(used))
    if points < _FEWEST:
        raise ValueError(
            f"a fit needs {_FEWEST} points or more with forces > 0 between {least:g} "
            f"and {largest:g}, got {points} of {len(force)}"
        )
    x = (force / (rms_slope * contact_modulus) / sigma)[used]
    y = (area / sigma)[used]
    square = (x**2).sum()
    kappa = (x * y).sum() / square
    variance = ((y - kappa * x) ** 2).sum() / (points - 1) / square
    return KappaFit(float(kappa), float(np.sqrt(variance)), points)
