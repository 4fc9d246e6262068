r"""Electrical or thermal conductance through a region of contact.

The potential in a solid that conducts through a region S of its surface only, and the
normal displacement of a half space under a rigid punch with the footprint S, solve the
same equations. With the stiffness :math:`K_S` of the punch on a half space of the
contact modulus :math:`E^*`, and the resistivities of both bodies, the conductance is

.. math:: C = \frac{2}{E^*} \frac{K_S}{\rho_1 + \rho_2}.

It depends only on the region, not on wall and solid. A flow from the surface into a
solid of uniform resistivity spreads like the stress in an isotropic half space, also if
the solid is elastically a crystal or has layers.

References
----------
J. R. Barber, Proc. R. Soc. A 459, 53 (2003).
"""

from __future__ import annotations

import numpy as np

from ase_roughcontact.elasticity.greens import Isotropic
from ase_roughcontact.elasticity.halfspace import HalfSpace
from ase_roughcontact.solvers.response import punch_response


def region_conductance(halfspace: HalfSpace, region: np.ndarray) -> float:
    """Return the conductance of a region, times the sum of the resistivities.

    Parameters
    ----------
    halfspace : HalfSpace
        Half space with the grid and the boundaries; its solid does not matter.
    region : ndarray of bool, shape (n, m)
        Cells that conduct.

    Returns
    -------
    float
        Conductance (length), 4 a for a circle of radius a on a fine grid, and zero for
        an empty region. On a periodic half space it is the conductance of the region in
        one cell in series with the bulk, infinite if the whole cell conducts.
    """
    conductor = halfspace
    if type(halfspace.solid.elastic) is not Isotropic:
        conductor = halfspace.of(Isotropic(1.0))
    stiffness = 0.0 - punch_response(conductor, region).force
    return 2.0 * stiffness / conductor.contact_modulus
