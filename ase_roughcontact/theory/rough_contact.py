"""Contact area of a rough sphere, and the load at which it becomes Hertzian.

The rms slope is h' = ``<|grad h|^2>^(1/2)``, the contact modulus E* = E/(1 - nu^2). All
functions broadcast over arrays, accept any consistent system of units, and raise
`ValueError` for an argument that is not finite or of the wrong sign.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import (
    FloatArray,
    nonnegative_array,
    positive_array,
)
from ase_roughcontact.theory.first_asperity import low_load_plateau
from ase_roughcontact.theory.hertz import Hertz
from ase_roughcontact.theory.rough_flats import KAPPA_HARD, contact_fraction


def predicted_area(
    normal_force: ArrayLike,
    radius: float,
    contact_modulus: float,
    flat: ArrayLike | Callable[[FloatArray], FloatArray],
    *,
    asperity_radius: ArrayLike | None = None,
    asperity_area: ArrayLike = 0.0,
) -> FloatArray:
    """Return the contact area of a rough sphere at any load.

    A = max(A_Hertz(rho), A_adh, A_Hertz f(N/A_Hertz)), where A_Hertz(rho) is the area
    of a smooth sphere with the radius rho of the first asperity, at most R. The last
    term alone is Eq. (4), which tends to N/p_rough at small force and to A_Hertz at
    large force.

    Parameters
    ----------
    normal_force : array_like
        N >= 0, force.
    radius : float
        R of the sphere, length.
    contact_modulus : float
        E*, force per area.
    flat : array_like or callable
        Contact of nominally flat surfaces: p_rough of `mean_contact_pressure` for the
        error function, or a function f of the nominal pressure (force per area).
    asperity_radius : array_like, optional
        rho of `asperity_radius`, times `ASPERITY_FACTOR_REPULSIVE` for the repulsive
        wall, length; by default no first asperity is considered.
    asperity_area : array_like
        A_adh >= 0, area of an adhesive first asperity at small load.

    Returns
    -------
    ndarray
        A, area.

    Notes
    -----
    A single asperity carries the load as long as its pressure N/A_Hertz(rho) is below
    p_rough. Beyond the load at which both are equal, `crossover_load` with rho in place
    of R as long as f is linear, more asperities share the load. The transition has a
    kink, unlike that of a simulated sphere. With adhesion, A_adh is fitted to a
    realisation.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eqs. (2), (4) and
    (6), and fig. 2.

    Examples
    --------
    >>> from ase_roughcontact.theory import mean_contact_pressure, predicted_area
    >>> pressure = mean_contact_pressure(0.1, 1.0, kappa=2.0)
    >>> round(float(predicted_area(10.0, 1000.0, 1.0, pressure)))
    199
    """
    a = Hertz(radius, contact_modulus).contact_radius(normal_force)
    # N/A_Hertz, also at N = 0
    pressure = 4 / (3 * np.pi) * (contact_modulus / radius) * a
    fraction = flat(pressure) if callable(flat) else contact_fraction(pressure, flat)
    if asperity_radius is not None:
        plateau = low_load_plateau(asperity_radius, radius)
        fraction = np.maximum(fraction, np.minimum(plateau, 1.0))
    adhesive = nonnegative_array("asperity_area", asperity_area)
    return np.maximum(np.pi * a**2 * fraction, adhesive)


def crossover_load(
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    rms_slope: ArrayLike,
    kappa: ArrayLike = KAPPA_HARD,
) -> FloatArray:
    """Return the load of the crossover from rough to Hertzian contact.

    N_c = (9 pi^3/16) E* R^2 (h'/kappa)^3.

    Parameters
    ----------
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    rms_slope : array_like
        h', dimensionless.
    kappa : array_like
        Dimensionless.

    Returns
    -------
    ndarray
        N_c, force.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), eq. (5).
    """
    radius = positive_array("radius", radius)
    modulus = positive_array("contact_modulus", contact_modulus)
    slope = positive_array("rms_slope", rms_slope)
    # contact radius over R at this load
    ratio = 0.75 * np.pi * slope / positive_array("kappa", kappa)
    return 4 / 3 * modulus * radius**2 * ratio**3
