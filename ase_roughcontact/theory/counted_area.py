"""Contact area of the continuum, from the grid points that are in contact."""

import math

import numpy as np

# Factor of the perimeter times the spacing in `continuum_area`.
_GRID_CORRECTION = (math.pi - 1.0 + math.log(2.0)) / 24.0
# Error of an area on one grid, in units of the correction in `continuum_area`: measured
# on rough spheres and flats, hard and repulsive walls, by
# examples/benchmarks/grid_error.py.
_ERROR_PER_CORRECTION = 0.25
# Area per point, in units of the squared length l of a soft wall, see `grid_error`, at
# which the error is half the correction for a hard wall. At spacings of 1, 2 and 4 l
# the errors were 0.2, 0.3 and 0.5 of the correction on rough spheres, 0.4, 0.7 and 0.9
# on a smooth one.
_HALF_CORRECTION_AREA = 6.0


def open_sides(contact: np.ndarray, periodic: bool) -> np.ndarray:
    """Return the number of sides that each atom in contact shares with open atoms.

    Parameters
    ----------
    contact : ndarray of bool, shape (n, m)
        Whether each atom is in contact.
    periodic : bool
        Whether atoms at opposite edges are neighbours; otherwise all atoms beyond the
        edges are open.

    Returns
    -------
    ndarray of int, shape (n, m)
        Number of sides, from 0 to 4; zero for atoms that are not in contact.
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

    Counting grid points overestimates the contact area of a hard wall, where each open
    point needs a gap. A wall of finite stiffness, with a pressure that falls to zero
    continuously, needs no correction.

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
        Area A_c of the continuum (length^2).

    References
    ----------
    V. A. Yastrebov, G. Anciaux, J.-F. Molinari, Tribol. Int. 114, 161 (2017).
    """
    return area - _GRID_CORRECTION * perimeter * spacing


def grid_error(perimeter: float, cell_area: float, compliance: float = 0.0) -> float:
    r"""Return the estimated error of the contact area of the continuum.

    The error is a quarter of the correction of `continuum_area` plus half a grid point.
    The coarser the grid, the more does a soft wall, with an area that is not corrected,
    act like a hard one. With the length l, the compliance of the wall times the contact
    modulus, the error is the part

    .. math:: \frac{\Delta x^2}{\Delta x^2 + 6 l^2}

    of the correction instead, if this part is larger than a quarter.

    Parameters
    ----------
    perimeter : float
        Length of the boundary of the contact, see `continuum_area` (length).
    cell_area : float
        Area per grid point (length^2).
    compliance : float
        Length l: compliance of the wall at the edge of the contact, times the contact
        modulus (length); zero if the area is corrected.

    Returns
    -------
    float
        Estimated error (length^2).
    """
    spacing = math.sqrt(cell_area)
    factor = _ERROR_PER_CORRECTION
    if compliance:
        half = _HALF_CORRECTION_AREA * compliance * compliance
        factor = max(factor, cell_area / (cell_area + half))
    return factor * _GRID_CORRECTION * perimeter * spacing + 0.5 * cell_area
