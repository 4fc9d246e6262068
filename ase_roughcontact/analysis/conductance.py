"""Electrical or thermal conductance of a contact, from its stiffness."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import FloatArray, finite_array, positive


def conductance(
    contact_stiffness: ArrayLike, contact_modulus: float, resistivity: float
) -> FloatArray:
    r"""Return the conductance of a contact.

    .. math:: \frac{2}{\rho E^*} \frac{dN}{d\delta},

    which holds for any shape of the contact: the flow through a contact and the
    displacement by an increment of load solve the same equations. For a circle of
    radius a it is :math:`4a/\rho`.

    Parameters
    ----------
    contact_stiffness : array_like
        Derivative of the force to the penetration, as in `LoadStep` (force per
        length). That of a hard wall is meant: the stiffness of a soft wall acts in
        series, and corresponds to a resistance of the interface.
    contact_modulus : float
        E* (force per area).
    resistivity : float
        Sum of the resistivities of the two bodies.

    Returns
    -------
    ndarray
        Length per resistivity; with Å and Ω m, multiply by 1e-10 to get 1/Ω.

    Raises
    ------
    ValueError
        If a number is not finite, or modulus or resistivity are not positive.

    References
    ----------
    J. R. Barber, Proc. R. Soc. A 459, 53 (2003).

    Examples
    --------
    A circle of radius 10, whose stiffness is 2 E* a:

    >>> from ase_roughcontact.analysis import conductance
    >>> float(conductance(2 * 0.9 * 10.0, contact_modulus=0.9, resistivity=1.0))
    40.0
    """
    positive(contact_modulus=contact_modulus, resistivity=resistivity)
    stiffness = finite_array("contact_stiffness", contact_stiffness)
    return 2.0 * np.asarray(stiffness) / (contact_modulus * resistivity)
