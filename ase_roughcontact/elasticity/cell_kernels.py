r"""Displacement of an isotropic half space by uniform tractions on a square cell.

The Green's functions of Boussinesq and Cerruti, integrated over the cell: pressure
displaces the surface along its normal, and lateral tractions sideways,

.. math:: u_a = \frac{1}{\pi E^* (1 - \nu)} \int \left[(1 - \nu)
          \frac{\delta_{ab}}{r} + \nu \frac{x_a x_b}{r^3}\right] t_b\, dA ,

and each also displaces the surface in the direction of the other, see `cross_kernel`.
The integrals are described in `Harmonics`.
"""

from __future__ import annotations

import numpy as np

from ase_roughcontact._util.validation import positive
from ase_roughcontact.elasticity.greens import Isotropic


def love_kernel(
    i: np.ndarray, j: np.ndarray, spacing: float, contact_modulus: float
) -> np.ndarray:
    r"""Return the depth of an isotropic half space under unit pressure on one cell.

    With :math:`b` half the spacing :math:`a_0` and corners
    :math:`X_\pm = x \pm b`, :math:`Y_\pm = y \pm b`,

    .. math:: G(x, y) = \frac{1}{\pi E^*} \sum_{s,t=\pm} s t \left[
              X_s \operatorname{arsinh}\frac{Y_t}{|X_s|}
              + Y_t \operatorname{arsinh}\frac{X_s}{|Y_t|}\right],

    at the origin :math:`4 \ln(1 + \sqrt 2) a_0/(\pi E^*)`. The relative error is below
    1e-13 at any distance.

    Parameters
    ----------
    i, j : ndarray of int
        Distances in cells along the two directions, broadcast together.
    spacing : float
        Side of the cell (length).
    contact_modulus : float
        E* (pressure).

    Returns
    -------
    ndarray, shape of the broadcast
        Displacement per pressure (length/pressure), positive.

    References
    ----------
    A. E. H. Love, Phil. Trans. R. Soc. A 228, 377 (1929); K. L. Johnson, Contact
    Mechanics (1985), Eq. (3.25).
    """
    positive(spacing=spacing)
    return Isotropic(contact_modulus).cell_compliance(i, j, spacing)


def cerruti_kernel(
    i: np.ndarray, j: np.ndarray, spacing: float, contact_modulus: float, poisson: float
) -> np.ndarray:
    r"""Return the lateral displacement of a half space by unit traction on one cell.

    The relative error is below 1e-12 at any distance.

    Parameters
    ----------
    i, j : ndarray of int
        Lattice vectors from the loaded cell, broadcast together.
    spacing : float
        Side of the cell (length).
    contact_modulus : float
        E* (pressure).
    poisson : float
        Poisson's ratio.

    Returns
    -------
    ndarray, 3 in front of the shape of the broadcast
        Components xx, yy and xy (length/pressure).

    References
    ----------
    V. Cerruti, Atti R. Accad. Lincei 13, 81 (1882); K. L. Johnson, Contact Mechanics
    (1985), Eq. (3.75); J. Li, E. J. Berger, Int. J. Numer. Meth. Eng. 58, 1035 (2003).
    """
    positive(spacing=spacing)
    solid = Isotropic(contact_modulus, poisson)
    return solid.lateral_cell_compliance(i, j, spacing)


def cross_kernel(
    i: np.ndarray, j: np.ndarray, spacing: float, contact_modulus: float, beta: float
) -> np.ndarray:
    r"""Return the lateral displacement of a half space by unit pressure on one cell.

    It is also the upward displacement by unit lateral traction on the cell,

    .. math:: u_a = -\frac{\beta}{\pi E^*} \int \frac{x_a}{r^2} p\, dA, \qquad
              u_z = -\frac{\beta}{\pi E^*} \int \frac{x_a}{r^2} t_a\, dA .

    The relative error is below 1e-12 at any distance.

    Parameters
    ----------
    i, j : ndarray of int
        Lattice vectors from the loaded cell, broadcast together.
    spacing : float
        Side of the cell (length).
    contact_modulus : float
        E* (pressure).
    beta : float
        Coupling, ``(1 - 2 nu)/(2 - 2 nu)`` under a rigid indenter.

    Returns
    -------
    ndarray, 2 in front of the shape of the broadcast
        Components x and y (length/pressure).

    References
    ----------
    K. L. Johnson, Contact Mechanics (1985), Eqs. (3.18) and (3.75).
    """
    positive(spacing=spacing)
    solid = Isotropic(contact_modulus, poisson=0.0, dundurs=beta)
    return solid.cross_cell_compliance(i, j, spacing)
