"""The same contact on coarser grids and on a part of its window."""

from __future__ import annotations

import numpy as np

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.lattice import Box

# Windows are not coarsened below this number of atoms along their shorter side.
COARSEST = 32


def can_coarsen(contact: Contact) -> bool:
    """Whether a grid of twice the spacing still says something of the contact."""
    shape = contact.halfspace.shape
    whole = not contact.halfspace.periodic or all(n % 2 == 0 for n in shape)
    return whole and min(shape) >= 2 * COARSEST


def coarsen(contact: Contact) -> Contact:
    """Return the contact on every other atom, at twice the spacing.

    The wall's energy per area stays the same, and with it pressure and stiffness.

    Parameters
    ----------
    contact : Contact
        With a window of ``(n, m)`` atoms.

    Returns
    -------
    Contact
        With a window of ``((n + 1)//2, (m + 1)//2)`` atoms.
    """
    heights = np.ascontiguousarray(contact.heights[::2, ::2])
    halfspace = contact.halfspace.resized(
        heights.shape, 2.0 * contact.halfspace.spacing
    )
    return Contact(halfspace, heights, contact.interaction)


def refine(values: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Interpolate linearly from every other point to all points of a grid.

    Parameters
    ----------
    values : ndarray, shape ((n + 1)//2, (m + 1)//2)
        On the grid of `coarsen`.
    shape : (int, int)
        ``(n, m)``.

    Returns
    -------
    ndarray, shape (n, m)
        Constant beyond the last point.
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
    return Contact(halfspace, heights, contact.interaction)


def reachable(
    contact: Contact, height: float, pressure: np.ndarray | None = None
) -> Box:
    """Smallest window of a repulsive wall's contact at a height of the indenter.

    A surface that is only pushed lies nowhere above its plane, so that an atom can
    touch only where the undeformed gap is within the range of the wall. On a free half
    space the window can be cut to these atoms, which changes nothing.

    Parameters
    ----------
    contact : Contact
        With a wall that does not attract, on a free half space.
    height : float
        Of the indenter, or a lower bound (length).
    pressure : ndarray, shape (n, m), optional
        The atoms that it pushes are within the window, too.

    Returns
    -------
    Box
        At least the atom below the lowest point.
    """
    near = contact.heights + height < contact.interaction.cutoff
    if pressure is not None:
        near |= pressure > 0.0
    i, j = divmod(int(contact.heights.argmin()), near.shape[1])
    return Box((i, j), (1, 1)).union(Box.bounding(near, (0, 0)))


def whole(contact: Contact) -> Box:
    """Window of all atoms."""
    return Box((0, 0), contact.halfspace.shape)
