r"""Displacement of an isotropic half space by uniform tractions on a square cell.

The Green's functions of Boussinesq and Cerruti, integrated over the cell: pressure
displaces the surface along its normal, and lateral tractions sideways,

.. math:: u_a = \frac{1}{\pi E^* (1 - \nu)} \int \left[(1 - \nu)
          \frac{\delta_{ab}}{r} + \nu \frac{x_a x_b}{r^3}\right] t_b\, dA ,

and each of them also in the direction of the other, see `cross_kernel`.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import product

import numpy as np

from ase_roughcontact._util.validation import positive

# Distance, in cells, below which Love's kernel is tabulated, and beyond which kernels
# are Taylor series; for the cross kernel.
_TABULATED, _NEAR = 160, 8


def love_kernel(
    i: np.ndarray, j: np.ndarray, spacing: float, contact_modulus: float
) -> np.ndarray:
    r"""Return the depth of an isotropic half space under unit pressure on one cell.

    With :math:`b` half the spacing :math:`a_0` and corners
    :math:`X_\pm = x \pm b`, :math:`Y_\pm = y \pm b`,

    .. math:: G(x, y) = \frac{1}{\pi E^*} \sum_{s,t=\pm} s t \left[
              X_s \operatorname{arsinh}\frac{Y_t}{|X_s|}
              + Y_t \operatorname{arsinh}\frac{X_s}{|Y_t|}\right],

    at the origin :math:`4 \ln(1 + \sqrt 2) a_0/(\pi E^*)`. The differences of two
    arsinh are evaluated as a logarithm of their ratio, since they cancel far away. From
    160 cells on the integral of :math:`1/(\pi E^* r)` over the cell is its Taylor
    series about the centre of the cell, lengths in spacings,

    .. math:: \frac{1}{r} + \frac{1}{24 r^3}
              + \frac{7}{1920 r^5}\left(\frac{20 x^2 y^2}{r^4} - 1\right).

    The relative error is below 1e-13 at any distance.

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
    positive(spacing=spacing, contact_modulus=contact_modulus)
    i, j = np.abs(i), np.abs(j)
    table = _near_cells()
    if max(np.max(i), np.max(j)) < len(table):
        kernel = table[i, j]
    else:
        kernel = np.asarray(_cell_series(i.astype(float), j.astype(float)))
        near = (i < len(table)) & (j < len(table))
        i, j = np.broadcast_arrays(i, j)
        kernel[near] = table[i[near], j[near]]
    return kernel * (spacing / (np.pi * contact_modulus))


def cerruti_kernel(
    i: np.ndarray, j: np.ndarray, spacing: float, contact_modulus: float, poisson: float
) -> np.ndarray:
    r"""Return the lateral displacement of a half space by unit traction on one cell.

    The integrals over the cell are sums over its corners, with signs as in
    `love_kernel`,

    .. math:: \int \frac{x^2}{r^3} = \sum \pm y \operatorname{arsinh}\frac{x}{|y|},
              \qquad \int \frac{xy}{r^3} = -\sum \pm r ,

    without cancellation, and from 160 cells on Taylor series of
    :math:`e^{2 i \phi}/r`. The relative error is below 1e-12 at any distance.

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
    positive(spacing=spacing, contact_modulus=contact_modulus)
    i, j = np.broadcast_arrays(np.asarray(i, dtype=float), np.asarray(j, dtype=float))
    x, y = abs(i), abs(j)
    integrals = np.asarray(_lateral_series(x, y))
    near = np.maximum(x, y) < _TABULATED
    integrals[:, near] = _lateral_corners(x[near] - 0.5, y[near] - 0.5)
    along, across, mixed = integrals
    rest = 1.0 - poisson
    kernel = np.stack(
        [
            along + rest * across,
            rest * along + across,
            poisson * np.sign(i) * np.sign(j) * mixed,
        ]
    )
    return kernel * (spacing / (np.pi * contact_modulus * rest))


def cross_kernel(
    i: np.ndarray, j: np.ndarray, spacing: float, contact_modulus: float, beta: float
) -> np.ndarray:
    r"""Return the lateral displacement of a half space by unit pressure on one cell.

    It is also the upward displacement by unit lateral traction on the cell,

    .. math:: u_a = -\frac{\beta}{\pi E^*} \int \frac{x_a}{r^2} p\, dA, \qquad
              u_z = -\frac{\beta}{\pi E^*} \int \frac{x_a}{r^2} t_a\, dA .

    The integral of :math:`1/z`, with :math:`z = x + i y`, over the cell is a sum of
    :math:`-i z \ln z` over its corners, with signs as in `love_kernel`, and from 8
    cells on its Taylor series :math:`1/z - 1/(60 z^5) + 1/(720 z^9)`. The relative
    error is below 1e-12 at any distance.

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
    positive(spacing=spacing, contact_modulus=contact_modulus)
    z = np.asarray(np.add(i, np.multiply(1j, j)))
    inverse = 1.0 / np.where(z == 0.0, np.inf, z)
    fourth = inverse**4
    integral = np.asarray(inverse * (1.0 - fourth * (1.0 / 60.0 - fourth / 720.0)))
    near = abs(z) < _NEAR
    integral[near] = _inverse_integral(z[near])
    kernel = np.stack([integral.real, -integral.imag])
    return kernel * (-beta * spacing / (np.pi * contact_modulus))


@lru_cache(maxsize=1)
def _near_cells() -> np.ndarray:
    """Return the integral of 1/r over the unit cells at distances below `_TABULATED`.

    Small contacts would otherwise spend a sixth of their time on it.
    """
    x, y = np.indices((_TABULATED, _TABULATED)) - 0.5  # lower corners of the cells
    return (
        _edge_integral(x + 1.0, y)
        - _edge_integral(x, y)
        + _edge_integral(y + 1.0, x)
        - _edge_integral(y, x)
    )


def _edge_integral(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return ``x [arsinh((y + 1)/|x|) - arsinh(y/|x|)]`` without cancellation."""
    lower, upper = np.hypot(x, y), np.hypot(x, y + 1.0)
    ratio = (1.0 + (2.0 * y + 1.0) / (lower + upper)) / (y + lower)
    return x * np.log1p(ratio)


def _cell_series(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Integrate 1/r over the unit cell at (x, y) by its Taylor series about (x, y)."""
    x2, y2 = x * x, y * y
    inverse = 1.0 / np.maximum(x2 + y2, 1.0)  # avoids division by zero at the origin
    mixed = x2 * y2 * inverse * inverse
    series = 1.0 + inverse * (
        1.0 / 24.0 + inverse * (7.0 / 1920.0) * (20.0 * mixed - 1.0)
    )
    return np.sqrt(inverse) * series


def _lateral_corners(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Integrate x^2/r^3, y^2/r^3 and xy/r^3 over unit cells with lower corners (x, y).

    The last one is the difference of the distances of the corners.
    """
    along = _edge_integral(y + 1.0, x) - _edge_integral(y, x)
    across = _edge_integral(x + 1.0, y) - _edge_integral(x, y)
    left, right = (np.hypot(x + k, y) + np.hypot(x + k, y + 1.0) for k in (0, 1))
    lower, upper = (np.hypot(x, y + k) + np.hypot(x + 1.0, y + k) for k in (0, 1))
    mixed = (2.0 * x + 1.0) * (2.0 * y + 1.0) / (lower * upper)
    return np.stack([along, across, mixed * (1.0 / left + 1.0 / right)])


def _lateral_series(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Integrate x^2/r^3, y^2/r^3 and xy/r^3 over unit cells by their Taylor series.

    They are half of the sum and of the difference of 1/r and the real part of
    ``exp(2 i phi)/r``, and half of its imaginary part.
    """
    inverse = 1.0 / np.maximum(x * x + y * y, 1.0)
    turn = (x + 1j * y) ** 2 * inverse  # exp(2 i phi)
    fourth = (-210.0 * turn + 15.0 * turn.conj() - 945.0 * turn**3) / 23040.0
    series = turn + inverse * (-turn / 8.0 + inverse * fourth)
    series *= np.sqrt(inverse)
    total = _cell_series(x, y)
    return 0.5 * np.stack([total + series.real, total - series.real, series.imag])


def _inverse_integral(z: np.ndarray) -> np.ndarray:
    """Integrate 1/z over unit cells around integer z; zero at the origin."""
    turn = np.where(z.real == 0.0, 1j * np.sign(z.imag), np.sign(z.real))
    turn[z == 0.0] = 1.0
    turned, total = z / turn, np.zeros(z.shape, complex)
    for x, y in product((0.5, -0.5), repeat=2):
        corner = turned + x + 1j * y  # right of the cut of the logarithm
        total += np.sign(x * y) * corner * np.log(corner)
    return np.where(z == 0.0, 0.0, -1j * total / turn)
