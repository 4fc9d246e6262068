r"""Displacement of an isotropic half space by uniform pressure on a square cell.

With lengths in units of the cell's side, the surface sinks by :math:`I(x, y)/\pi E^*`,
where :math:`I` is the integral of :math:`1/r` over the cell. As
:math:`\nabla \cdot (\mathbf r/r) = 1/r`, it is an integral along the edges of the cell,
in closed form. Far from the cell, where the edges nearly cancel, the Taylor series of
:math:`1/r` about the centre is summed up to the fourth order,

.. math:: I = \left[1 + \frac{\nabla^2}{24} + \frac{\nabla^4}{1920}
          + \frac{\partial_x^2 \partial_y^2}{1440}\right] \frac{1}{r} .

References
----------
A. E. H. Love, Phil. Trans. R. Soc. A 228, 377 (1929); K. L. Johnson, Contact Mechanics
(1985), Eq. (3.25).
"""

from __future__ import annotations

import numpy as np

from ase_roughcontact._util.validation import positive

# Distance, in cells, from which the series has the smaller error, below 1e-13.
_SERIES_CELLS = 64


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
    positive(spacing=spacing, contact_modulus=contact_modulus)
    x, y = np.broadcast_arrays(np.abs(i).astype(float), np.abs(j).astype(float))
    near = (x < _SERIES_CELLS) & (y < _SERIES_CELLS)
    if near.all():
        integral = _from_edges(x, y)
    else:
        integral = _from_series(x, y)
        integral[near] = _from_edges(x[near], y[near])
    return spacing / (np.pi * contact_modulus) * integral


def _from_edges(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the integral of 1/r over cells at (x, y) by integrals along edges."""
    return _between_edges(x, y) + _between_edges(y, x)


def _between_edges(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the share of the two edges along y, at the distances x +- 1/2."""
    outer, inner = x + 0.5, x - 0.5
    return outer * _along_edge(outer, y) - inner * _along_edge(inner, y)


def _along_edge(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    r"""Return the integral of 1/r along an edge of unit length, centred at (x, y).

    It is :math:`\operatorname{arsinh}(Y_+/x) - \operatorname{arsinh}(Y_-/x)` with
    :math:`Y_\pm = y \pm 1/2`, written without cancellation for :math:`y \ge 1`.
    """
    upper, lower = y + 0.5, y - 0.5
    across = upper * np.hypot(x, lower) + lower * np.hypot(x, upper)
    centred = 2.0 * np.arcsinh(0.5 / abs(x))
    ratio = np.divide(2.0 * y, across, out=np.zeros_like(across), where=y > 0.0)
    return np.where(y > 0.0, np.arcsinh(ratio), centred)


def _from_series(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Return the integral of 1/r over cells at (x, y), far from the origin."""
    inverse = 1.0 / np.maximum(x * x + y * y, 1.0)
    cosine = 1.0 - 8.0 * (x * y * inverse) ** 2  # of four times the angle
    fourth = 9.0 / 1920.0 + (9.0 - 105.0 * cosine) / (8.0 * 1440.0)
    return np.sqrt(inverse) * (1.0 + inverse * (1.0 / 24.0 + inverse * fourth))
