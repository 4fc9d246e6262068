"""Electrical or thermal conductance of a contact map."""

from __future__ import annotations

from ase_roughcontact._util.validation import positive
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.solvers.conductance import region_conductance


def conductance(contact_map: ContactMap, resistivity: float = 1.0) -> float:
    r"""Return the electrical or thermal conductance of a contact region.

    .. math:: \frac{2 K_S}{\rho E^*}

    is the conductance, with the stiffness :math:`K_S` of a rigid punch with the
    footprint of the region on an isotropic half space, see `solvers.conductance`: the
    flow through the region and the pressure below the punch solve the same equations. A
    circle of radius a has the conductance :math:`4a/\rho`. The column `conductance` of
    `LoadStep` is the conductance at each step.

    Parameters
    ----------
    contact_map : ContactMap
        Map of the contact. For a periodic map the result is the conductance of the
        contact in a cell in series with the bulk, infinite for a full contact.
    resistivity : float
        Sum of the resistivities of the two bodies (for example Ω m).

    Returns
    -------
    float
        Conductance (Å per resistivity); with Ω m, multiply by 1e-10 to get 1/Ω.

    Raises
    ------
    ValueError
        If the resistivity is not positive.

    Notes
    -----
    The region is a union of square cells: the result for a circle is 0.989 times
    :math:`4a/\rho` at a radius of 8 spacings, and 0.9965 times at 30 spacings.

    References
    ----------
    J. R. Barber, Proc. R. Soc. A 459, 53 (2003).

    Examples
    --------
    >>> import numpy as np
    >>> from ase_roughcontact.analysis import ContactMap, conductance
    >>> x = np.arange(-30, 31)
    >>> circle = np.hypot(x[:, None], x) < 30.0
    >>> punch = ContactMap(1.0 * circle, circle, 1.0, (-30.0, -30.0), periodic=False)
    >>> radius = float(np.sqrt(circle.sum() / np.pi))
    >>> round(conductance(punch) / (4.0 * radius), 3)
    0.996
    """
    positive(resistivity=resistivity)
    kind = PeriodicHalfSpace if contact_map.periodic else FreeHalfSpace
    halfspace = kind(contact_map.contact.shape, contact_map.spacing, 1.0)
    return region_conductance(halfspace, contact_map.contact) / resistivity
