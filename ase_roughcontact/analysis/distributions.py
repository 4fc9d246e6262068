"""Distributions of the pressure and of the gap, and averages over rings."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import (
    FloatArray,
    increasing_array,
    integer,
    nonnegative_array,
)
from ase_roughcontact.analysis.contact_map import ContactMap


@dataclass(frozen=True, eq=False)
class Distribution(Summarized):
    """Probability density of a quantity.

    Attributes
    ----------
    density : ndarray, shape (k,)
        Probability densities (inverse of the quantity's unit). Their integral is the
        fraction of the atoms within the bins, one by default.
    edges : ndarray, shape (k + 1,)
        Edges of the bins.
    """

    density: FloatArray
    edges: FloatArray

    @property
    def value(self) -> FloatArray:
        """Centres of the bins, shape (k,)."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])


def pressure_distribution(
    contact_map: ContactMap, bins: int | ArrayLike = 50
) -> Distribution:
    """Return the distribution of the pressure on the atoms in contact.

    Parameters
    ----------
    contact_map : ContactMap
        Map of the contact.
    bins : int or array_like
        Number of bins between the smallest and the largest value, or increasing edges
        (eV/Å^3).

    Returns
    -------
    Distribution
        Density over the pressure.

    Raises
    ------
    ValueError
        If no atom is in contact, or the bins are invalid.
    """
    values = contact_map.pressure[contact_map.contact]
    return _distribution(values, bins, "no atom is in contact")


def gap_distribution(
    contact_map: ContactMap, bins: int | ArrayLike = 50
) -> Distribution:
    """Return the distribution of the gaps of the atoms that are not in contact.

    The gap of an atom in contact is zero under a hard wall, and a function of its
    pressure under a soft one.

    Parameters
    ----------
    contact_map : ContactMap
        Map of the contact, with the gap.
    bins : int or array_like
        Number of bins between the smallest and the largest value, or increasing edges
        (Å).

    Returns
    -------
    Distribution
        Density over the gap.

    Raises
    ------
    ValueError
        If the map has no gap, all atoms are in contact, or the bins are invalid.
    """
    if contact_map.gap is None:
        raise ValueError(
            "the map has no gap: create it with ContactMap.from_atoms(atoms) or "
            "from_frame(frame, indenter=...)"
        )
    values = contact_map.gap[~contact_map.contact & ~np.isnan(contact_map.gap)]
    return _distribution(values, bins, "all atoms are in contact")


def _distribution(
    values: np.ndarray, bins: int | ArrayLike, reason: str
) -> Distribution:
    """Return the distribution of values; the reason explains why there may be none."""
    if not len(values):
        raise ValueError(f"the distribution is empty: {reason}")
    if np.ndim(bins):
        bins = increasing_array("bins", bins)
    else:
        integer("bins", bins, 1)
    counts, edges = np.histogram(values, bins)
    return Distribution(counts / len(values) / np.diff(edges), edges)


@dataclass(frozen=True, eq=False)
class RadialAverage(Summarized):
    """Averages over rings around the indenter's axis, each an array of shape (k,).

    Attributes
    ----------
    radius : ndarray
        Mean distance of the ring's sites from the axis (Å).
    pressure, contact_pressure : ndarray
        Mean pressure of all sites, and of the atoms in contact (eV/Å^3); NaN in rings
        without them.
    sites, contacts : ndarray of int
        Numbers of sites and of atoms in contact.
    """

    radius: FloatArray
    pressure: FloatArray
    contact_pressure: FloatArray
    sites: np.ndarray
    contacts: np.ndarray


def radial_average(
    contact_map: ContactMap, bins: int | ArrayLike | None = None
) -> RadialAverage:
    """Return the pressure averaged over rings around the indenter's axis.

    Parameters
    ----------
    contact_map : ContactMap
        Map of the contact.
    bins : int or array_like, optional
        Number of rings up to the farthest site of the map, or increasing edges >= 0
        (Å). By default the edges are 0 and half-integer multiples of the spacing.

    Returns
    -------
    RadialAverage
        Averages for each ring.

    Raises
    ------
    ValueError
        If the bins are invalid.

    Notes
    -----
    Sites beyond the map of a free half space carry no pressure, but are counted, so
    that the average does not depend on the size of the map. In a periodic cell
    distances are from the nearest image of the axis, and rings are limited to the cell.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), fig. 1.
    """
    distance, mask = contact_map.distance, contact_map.contact
    edges = _ring_edges(bins, float(distance.max()), contact_map.spacing)
    every = distance if contact_map.periodic else _distances(contact_map, edges[-1])

    def total(radii: FloatArray, values: FloatArray | None = None) -> np.ndarray:
        return np.histogram(radii, edges, weights=values)[0]

    pressure, sites = contact_map.pressure, total(every)
    contacts = total(distance[mask])
    with np.errstate(invalid="ignore"):  # rings without sites or contacts
        return RadialAverage(
            radius=total(every, every) / sites,
            pressure=total(distance, pressure) / sites,
            contact_pressure=total(distance[mask], pressure[mask]) / contacts,
            sites=sites,
            contacts=contacts,
        )


def _ring_edges(
    bins: int | ArrayLike | None, farthest: float, spacing: float
) -> FloatArray:
    """Return the edges of the rings, from a number, edges, or None for the default."""
    if bins is None:
        rings = int(np.ceil(farthest / spacing + 0.5))
        return spacing * np.append(0.0, np.arange(rings) + 0.5)
    if np.ndim(bins) == 0:
        # one spacing for a single atom on the axis
        return np.linspace(0.0, farthest or spacing, integer("bins", bins, 1) + 1)
    return nonnegative_array("bins", increasing_array("bins", bins))


def _distances(contact_map: ContactMap, farthest: float) -> FloatArray:
    """Return the distances from the axis of all lattice sites up to a largest one."""
    a0 = contact_map.spacing

    def positions(origin: float) -> FloatArray:
        first, last = (-farthest - origin) // a0, (farthest - origin) // a0
        return origin + a0 * np.arange(first, last + 2)  # one more, for rounding

    x, y = positions(contact_map.origin[0]), positions(contact_map.origin[1])
    distance = np.hypot(x[:, None], y)
    return distance[distance <= farthest]
