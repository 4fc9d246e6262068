"""Contact area of the continuum, from the grid points that are in contact."""

import math

import numpy as np

# Factor of the perimeter times the spacing in `continuum_area`.
_GRID_CORRECTION = (math.pi - 1.0 + math.log(2.0)) / 24.0
# Error of an area on one grid, in units of that correction: measured on rough spheres
# and flats, hard and repulsive walls, by examples/benchmarks/grid_error.py.
_ERROR_PER_CORRECTION = 0.25
# Area per point, in units of the squared softness of a wall, above which the area is
# wrong by half the correction for a hard one. At spacings of 1, 2 and 4 times the
# softness it was by 0.2, 0.3 and 0.5 of it on rough spheres, 0.4, 0.7 and 0.9 on a
# smooth one.
_HARD_FROM = 6.0


def open_sides(contact: np.ndarray, periodic: bool) -> np.ndarray:
    """Return the number of sides that each atom in contact shares with open ones.

    Parameters
    ----------
    contact : ndarray of bool, shape (n, m)
    periodic : bool
        Whether atoms at opposite edges are neighbours; otherwise all atoms beyond the
        edges are open.

    Returns
    -------
    ndarray of int, shape (n, m)
        From 0 to 4; zero for atoms that are not in contact.
    """
    open_ = np.full(contact.shape, 4, np.int8)
    for rows, mask in ((open_, contact), (open_.T, contact.T)):
        rows[1:] -= mask[:-1]
        rows[:-1] -= mask[1:]
        if periodic:
            rows[0] -= mask[-1]
            rows[-1] -= mask[0]
    return contact * open_


def continuum_area(area: float, perimeter: float, spacing: float) -> float:
    r"""Return the contact area of the continuum that a grid discretises.

    .. math:: A_c = A - \frac{\pi - 1 + \ln 2}{24} S_d \Delta x

    Counting grid points overestimates the area of a hard wall's contact, in which each
    open point needs a gap. The area of a wall of finite stiffness, whose pressure falls
    to zero continuously, needs no correction.

    Parameters
    ----------
    area : float
        Number of grid points in contact times the area per point, A (length^2).
    perimeter : float
        Length S_d of the boundary between cells in contact and open ones (length).
    spacing : float
        Distance of grid points (length).

    Returns
    -------
    float
        Length^2.

    References
    ----------
    V. A. Yastrebov, G. Anciaux, J.-F. Molinari, Tribol. Int. 114, 161 (2017).
    """
    return area - _GRID_CORRECTION * perimeter * spacing


def grid_error(perimeter: float, cell_area: float, softness: float = 0.0) -> float:
    r"""Return the estimated error of the contact area of the continuum.

    It is a quarter of the correction of `continuum_area` and half a grid point. On a
    coarse grid a soft wall acts more and more like a hard one, whose area would be
    corrected: with the softness l of the wall the error is the part

    .. math:: \frac{\Delta x^2}{\Delta x^2 + 6 l^2}

    of the correction, if that is more.

    Parameters
    ----------
    perimeter : float
        See `continuum_area` (length).
    cell_area : float
        Area per grid point (length^2).
    softness : float
        Contact modulus over stiffness of the wall at the edge of the contact (length);
        zero if the area is corrected.

    Returns
    -------
    float
        Length^2.
    """
    spacing = math.sqrt(cell_area)
    factor = _ERROR_PER_CORRECTION
    if softness:
        factor = max(factor, cell_area / (cell_area + _HARD_FROM * softness * softness))
    return factor * _GRID_CORRECTION * perimeter * spacing + 0.5 * cell_area
