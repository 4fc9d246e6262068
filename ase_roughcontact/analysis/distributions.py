"""Distributions of the pressure and of the gap."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import FloatArray, increasing_array, integer
from ase_roughcontact.analysis.contact_map import ContactMap


@dataclass(frozen=True, eq=False)
class Distribution:
    """Probability density of a quantity.

    Attributes
    ----------
    density : ndarray, shape (k,)
        Its integral is the fraction of the atoms covered by the bins, one by default
        (inverse of the quantity's unit).
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
    bins : int or array_like
        Number of bins between the smallest and the largest value, or increasing edges
        (eV/Å^3).

    Returns
    -------
    Distribution

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
    """Return the distribution of the gap of the atoms that are not in contact.

    The gap of an atom in contact is zero under a hard wall, and a function of its
    pressure under a soft one.

    Parameters
    ----------
    contact_map : ContactMap
        With the gap.
    bins : int or array_like
        Number of bins between the smallest and the largest value, or increasing edges
        (Å).

    Returns
    -------
    Distribution

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


def _distribution(values: np.ndarray, bins: int | ArrayLike, none: str) -> Distribution:
    if not len(values):
        raise ValueError(f"the distribution is empty: {none}")
    known = increasing_array if np.ndim(bins) else partial(integer, least=1)
    counts, edges = np.histogram(values, known("bins", bins))
    return Distribution(counts / len(values) / np.diff(edges), edges)
