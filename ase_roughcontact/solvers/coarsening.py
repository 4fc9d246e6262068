"""Contacts on coarser grids, and on parts of a window."""

from __future__ import annotations

import numpy as np

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.lattice import Box


def can_coarsen(contact: Contact, coarsest: int) -> bool:
    """Return whether a grid of twice the spacing has at least `coarsest` atoms a side.

    A periodic grid must also have even numbers of atoms.
    """
    shape = contact.halfspace.shape
    divisible = not contact.halfspace.periodic or all(n % 2 == 0 for n in shape)
    return divisible and min(shape) >= 2 * coarsest


def coarsen(contact: Contact) -> Contact:
    """Return the contact on every other atom, at twice the spacing.

    Energy per area, pressure and stiffness of the wall stay the same.

    Parameters
    ----------
    contact : Contact
        Contact on a window of ``(n, m)`` atoms.

    Returns
    -------
    Contact
        Contact on a window of ``((n + 1)//2, (m + 1)//2)`` atoms.
    """
    heights = np.ascontiguousarray(contact.heights[::2, ::2])
    halfspace = contact.halfspace
    coarse = halfspace.resized(heights.shape, 2.0 * halfspace.spacing)
    adhesion = contact.adhesion
    if adhesion is not None:
        adhesion = np.ascontiguousarray(adhesion[::2, ::2])
    return Contact(coarse, heights, contact.wall, adhesion)


def refine(values: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Interpolate linearly from every other point to all points of a grid.

    Parameters
    ----------
    values : ndarray, shape ((n + 1)//2, (m + 1)//2)
        Values on the grid of `coarsen`.
    shape : (int, int)
        Shape ``(n, m)`` of the fine grid.

    Returns
    -------
    ndarray, shape (n, m)
        Values on the fine grid, constant beyond the last coarse point.
    """
    for axis in (0, 1):
        coarse = np.moveaxis(values, axis, 0)
        fine = np.repeat(coarse, 2, axis=0)
        fine[1:-1:2] = (coarse[:-1] + coarse[1:]) / 2.0
        values = np.moveaxis(fine[: shape[axis]], 0, axis)
    return np.ascontiguousarray(values)


def crop(contact: Contact, box: Box) -> Contact:
    """Return the contact on a part of its window."""
    heights = np.ascontiguousarray(contact.heights[box.slices])
    halfspace = contact.halfspace
    if heights.shape != halfspace.shape:
        halfspace = halfspace.resized(heights.shape, halfspace.spacing)
    return Contact(halfspace, heights, contact.wall)


def reachable(
    contact: Contact, height: float, pressure: np.ndarray | None = None
) -> Box:
    """Return the smallest window of a contact with a repulsive wall.

    A surface under pressure is nowhere above its plane, so that an atom can touch only
    if its undeformed gap is within the range of the wall. On a free half space,
    cropping the window to these atoms does not change the result.

    Parameters
    ----------
    contact : Contact
        Contact with a repulsive wall on a free half space.
    height : float
        Height of the indenter, or a lower bound (length).
    pressure : ndarray, shape (n, m), optional
        Pressure; the window also contains the atoms under this pressure.

    Returns
    -------
    Box
        The window, with at least the atom below the lowest point of the indenter.
    """
    near = contact.heights + height < contact.wall.cutoff
    if pressure is not None:
        near |= pressure > 0.0
    i, j = divmod(int(contact.heights.argmin()), near.shape[1])
    return Box((i, j), (1, 1)).union(Box.bounding(near))
