"""Numbers that tell which law of adhesion a smooth sphere follows.

Both broadcast over arrays and take any consistent system of units.
"""

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import FloatArray, positive_array


def tabor_parameter(
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    work_of_adhesion: ArrayLike,
    equilibrium_distance: ArrayLike,
) -> FloatArray:
    """Tabor's parameter, mu = (R w^2/(E*^2 z0^3))^(1/3): small for DMT, large for JKR.

    Parameters
    ----------
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    work_of_adhesion : array_like
        w, energy per area.
    equilibrium_distance : array_like
        z0, gap at which the surfaces rest, length.

    Returns
    -------
    ndarray
        mu, dimensionless; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite and positive.

    References
    ----------
    D. Tabor, J. Colloid Interface Sci. 58, 2 (1977).
    """
    work = positive_array("work_of_adhesion", work_of_adhesion)
    modulus = positive_array("contact_modulus", contact_modulus)
    distance = positive_array("equilibrium_distance", equilibrium_distance)
    return np.cbrt(positive_array("radius", radius) * (work / modulus) ** 2) / distance


def maugis_parameter(
    radius: ArrayLike,
    contact_modulus: ArrayLike,
    work_of_adhesion: ArrayLike,
    cohesive_stress: ArrayLike,
) -> FloatArray:
    """Maugis' parameter, lambda = sigma0 (9 R/(2 pi w E*^2))^(1/3).

    Parameters
    ----------
    radius : array_like
        R of the sphere, length.
    contact_modulus : array_like
        E*, force per area.
    work_of_adhesion : array_like
        w, energy per area.
    cohesive_stress : array_like
        sigma0, force per area.

    Returns
    -------
    ndarray
        lambda, dimensionless; shape as the arguments broadcast.

    Raises
    ------
    ValueError
        If an argument is not finite and positive.

    References
    ----------
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992), where it reads
    lambda = 2 sigma0 (R/(pi w K^2))^(1/3) with K = 4 E*/3.
    """
    stress = positive_array("cohesive_stress", cohesive_stress)
    work = positive_array("work_of_adhesion", work_of_adhesion)
    modulus = positive_array("contact_modulus", contact_modulus)
    radius = positive_array("radius", radius)
    return stress * np.cbrt(9 * radius / (2 * np.pi * work * modulus**2))
