"""What a contact looks like: radial averages, first contact, distributions, kappa.

Units are those of the atoms (eV and Å); any consistent ones will do.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact.checks import (
    FloatArray,
    finite_array,
    integer,
    nonnegative_array,
    positive,
    positive_array,
    window,
)
from ase_roughcontact.contactmap import ContactMap
from ase_roughcontact.silhouette import Silhouette
from ase_roughcontact.topography import BoundedSurface, Surface

# A fit with an error bar needs this many points.
_FEWEST = 3


@dataclass(frozen=True)
class RadialAverage:
    """Averages over rings around the indenter's axis, each an array of shape (k,).

    Attributes
    ----------
    radius : ndarray
        Mean distance of the ring's sites from the axis (Å).
    pressure, contact_pressure : ndarray
        Mean over all sites and over atoms in contact; nan where there are none
        (eV/Å^3).
    sites, contacts : ndarray of int
        Number of sites, and of atoms in contact.
    """

    radius: FloatArray
    pressure: FloatArray
    contact_pressure: FloatArray
    sites: np.ndarray
    contacts: np.ndarray


def radial_average(
    contact_map: ContactMap, bins: int | ArrayLike | None = None
) -> RadialAverage:
    """Average the pressure over rings, p(r) of all sites and p_c(r) of contacts.

    Parameters
    ----------
    contact_map : ContactMap
        The contact.
    bins : int or array_like, optional
        Number of rings up to the farthest site of the map, or their edges, rising
        from r >= 0 (Å). By default rings one spacing wide, between half-integer
        multiples of it, the first one the disc of half a spacing.

    Returns
    -------
    RadialAverage

    Raises
    ------
    ValueError
        If the bins are not what they should be.

    Notes
    -----
    The sites beyond the map of a free half space carry no pressure. They are counted,
    so that a small map around a contact far off the axis gives the same average as a
    large one. In a periodic cell a site belongs to the nearest image of the axis, and
    rings wider than the cell are what of them is in it.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), fig. 1.
    """
    distance, mask = contact_map.distance, contact_map.contact
    edges = _ring_edges(bins, float(distance.max()), contact_map.spacing)
    every = distance if contact_map.periodic else _distances(contact_map, edges[-1])
    sites = np.histogram(every, edges)[0]
    contacts = np.histogram(distance[mask], edges)[0]

    def total(places: FloatArray, values: FloatArray) -> FloatArray:
        return np.histogram(places, edges, weights=values)[0]

    pressure = contact_map.pressure
    return RadialAverage(
        radius=_mean(total(every, every), sites),
        pressure=_mean(total(distance, pressure), sites),
        contact_pressure=_mean(total(distance[mask], pressure[mask]), contacts),
        sites=sites,
        contacts=contacts,
    )


@dataclass(frozen=True)
class FirstContact:
    """Where an indenter touches first.

    Attributes
    ----------
    position : (float, float)
        Of the atom below the indenter's lowest point, relative to its axis (Å).
    height : float
        Of the indenter there (Å).
    """

    position: tuple[float, float]
    height: float

    @property
    def distance(self) -> float:
        """Distance from the axis, to compare with `theory.first_contact_radius` (Å)."""
        return float(np.hypot(*self.position))


def first_contact(
    indenter: Surface, spacing: float, offset: tuple[float, float] = (0.0, 0.0)
) -> FirstContact:
    """Find the atom that an indenter touches first on a flat substrate.

    Parameters
    ----------
    indenter : Surface
        A `RoughSphere`, or another one that rises out of reach.
    spacing : float
        Distance of neighbouring atoms (Å).
    offset : (float, float)
        Position of any atom relative to the indenter's axis (Å).

    Returns
    -------
    FirstContact
        Of several atoms that are equally low, the one with the smallest x, then y.

    Raises
    ------
    ValueError
        If the indenter is flat, or an atom where its surface is not known could touch
        first.
    """
    if not isinstance(indenter, BoundedSurface):
        raise ValueError(
            "the first contact is that of an indenter that rises out of reach, such as "
            f"RoughSphere, got {indenter!r}"
        )
    _, spacing, offset = window((1, 1), spacing, offset)
    silhouette = Silhouette(indenter, spacing, offset)
    silhouette.check(silhouette.lowest)
    lowest = silhouette.below(silhouette.lowest)
    heights = silhouette.heights(lowest)
    site = np.unravel_index(heights.argmin(), heights.shape)
    x, y = (
        (start + step) * spacing + rest
        for start, step, rest in zip(lowest.start, site, silhouette.offset, strict=True)
    )
    return FirstContact((float(x), float(y)), float(heights.min()))


@dataclass(frozen=True)
class Distribution:
    """Probability density of a quantity.

    Attributes
    ----------
    density : ndarray, shape (k,)
        Its integral is the part of the atoms that the bins cover, one by default
        (inverse of the quantity's unit).
    edges : ndarray, shape (k + 1,)
        Of the bins.
    """

    density: FloatArray
    edges: FloatArray

    @property
    def value(self) -> FloatArray:
        """Middles of the bins, shape (k,)."""
        return 0.5 * (self.edges[1:] + self.edges[:-1])


def pressure_distribution(
    contact_map: ContactMap, bins: int | ArrayLike = 50
) -> Distribution:
    """Distribution of the pressure on the atoms in contact.

    Parameters
    ----------
    contact_map : ContactMap
        The contact.
    bins : int or array_like
        Number of bins between the least and the largest value, or their edges, rising
        (eV/Å^3).

    Returns
    -------
    Distribution

    Raises
    ------
    ValueError
        If no atom is in contact, or the bins are not what they should be.
    """
    values = contact_map.pressure[contact_map.contact]
    return _distribution(values, bins, "no atom is in contact")


def gap_distribution(
    contact_map: ContactMap, bins: int | ArrayLike = 50
) -> Distribution:
    """Distribution of the gap over the atoms that are not in contact.

    The gap of an atom in contact is zero under a hard wall, and a function of its
    pressure under a soft one.

    Parameters
    ----------
    contact_map : ContactMap
        With the gap.
    bins : int or array_like
        Number of bins between the least and the largest value, or their edges, rising
        (Å).

    Returns
    -------
    Distribution

    Raises
    ------
    ValueError
        If the map has no gap, all atoms are in contact, or the bins are not what they
        should be.
    """
    if contact_map.gap is None:
        raise ValueError(
            "the map has no gap: make it with ContactMap.from_atoms(atoms) or "
            "from_frame(frame, indenter=...)"
        )
    values = contact_map.gap[~contact_map.contact & ~np.isnan(contact_map.gap)]
    return _distribution(values, bins, "all atoms are in contact")


@dataclass(frozen=True)
class KappaFit:
    """Proportionality of contact area and force.

    Attributes
    ----------
    kappa, standard_error : float
        Dimensionless.
    points : int
        Number of points that were fitted.
    """

    kappa: float
    standard_error: float
    points: int


def fit_kappa(
    normal_force: ArrayLike,
    contact_area: ArrayLike,
    rms_slope: float,
    contact_modulus: float,
    limits: tuple[float, float] = (0.0, np.inf),
    area_error: ArrayLike | None = None,
) -> KappaFit:
    r"""Fit kappa to area against force in the linear range.

    .. math:: A_i = \kappa x_i + \epsilon_i, \quad x = \frac{N}{h' E^*}, \qquad
              \kappa = \frac{\sum x_i A_i/\sigma_i^2}{\sum x_i^2/\sigma_i^2}, \quad
              s_\kappa^2 = \frac{\sum (A_i - \kappa x_i)^2/\sigma_i^2}
                                {(n - 1) \sum x_i^2/\sigma_i^2}

    Parameters
    ----------
    normal_force, contact_area : array_like, shape (k,)
        N (eV/Å) and A (Å^2), not negative.
    rms_slope : float
        h', dimensionless.
    contact_modulus : float
        E* (eV/Å^3).
    limits : (float, float)
        Least and largest force of the linear range (eV/Å); see the notes. By default
        all forces above zero.
    area_error : array_like, shape (k,) or a number, optional
        Standard deviation sigma of the areas, up to a common factor (Å^2); by default
        the same for all. With the area itself, as for an error in per cent, kappa is
        the weighted mean of the ratios A/x.

    Returns
    -------
    KappaFit
        The standard error follows from the scatter of the points about the line.

    Raises
    ------
    ValueError
        If an argument is not what it should be, or fewer than three points are within
        the limits.

    Notes
    -----
    The range is chosen by the force, which is given, and not by the area, which
    scatters: a choice by the area would favour areas that came out small. Below the
    range a few asperities carry the load; above it the area saturates. On rough flats
    of area A0, eq. (2) of the reference falls below the line by the part
    ``(pi/12) (kappa N/(A0 h' E*))^2``, 0.3 % at a tenth of full contact. On a sphere
    take the Hertz area for A0, so that the range ends well below
    `theory.crossover_load`. The standard error holds for independent points. Those of
    one realisation under rising load are not: fit each realisation, and take the
    scatter of their kappas.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), before eq. (2).
    """
    positive(rms_slope=rms_slope, contact_modulus=contact_modulus)
    force = nonnegative_array("normal_force", normal_force)
    area = nonnegative_array("contact_area", contact_area)
    if force.ndim != 1 or force.shape != area.shape:
        raise ValueError(
            "normal_force and contact_area must be lists of one length, got shapes "
            f"{force.shape} and {area.shape}"
        )
    sigma = positive_array("area_error", 1.0 if area_error is None else area_error)
    if sigma.shape not in ((), force.shape):
        raise ValueError(
            f"area_error must be a number or have the shape {force.shape} of the "
            f"areas, got {sigma.shape}"
        )
    least, largest = _limits(limits)
    used = (force >= least) & (force <= largest) & (force > 0.0)
    points = int(np.count_nonzero(used))
    if points < _FEWEST:
        raise ValueError(
            f"a fit needs {_FEWEST} points or more with forces > 0 between {least:g} "
            f"and {largest:g}, got {points} of {len(force)}"
        )
    x = (force / (rms_slope * contact_modulus) / sigma)[used]
    y = (area / sigma)[used]
    square = (x**2).sum()
    kappa = (x * y).sum() / square
    variance = ((y - kappa * x) ** 2).sum() / (points - 1) / square
    return KappaFit(float(kappa), float(np.sqrt(variance)), points)


def _ring_edges(
    bins: int | ArrayLike | None, farthest: float, spacing: float
) -> FloatArray:
    if bins is None:
        rings = int(np.ceil(farthest / spacing + 0.5))
        return spacing * np.append(0.0, np.arange(rings) + 0.5)
    if np.ndim(bins) == 0:
        # a lone atom on the axis has a ring of one spacing
        return np.linspace(0.0, farthest or spacing, integer("bins", bins, 1) + 1)
    return nonnegative_array("bins", _rising(bins))


def _rising(bins: ArrayLike) -> FloatArray:
    edges = finite_array("bins", bins)
    if edges.ndim != 1 or len(edges) < 2 or not (np.diff(edges) > 0.0).all():
        raise ValueError(f"edges of bins must be two or more that rise, got {bins!r}")
    return edges


def _distances(contact_map: ContactMap, farthest: float) -> FloatArray:
    """Distances from the axis of all sites of the endless lattice up to one."""
    a0 = contact_map.spacing
    x, y = (
        start
        + a0
        * np.arange(np.ceil((-farthest - start) / a0) - 1, (farthest - start) / a0 + 2)
        for start in contact_map.origin
    )
    distance = np.hypot(x[:, None], y)
    return distance[distance <= farthest]


def _mean(total: FloatArray, count: np.ndarray) -> FloatArray:
    """Ratio, nan where there is nothing."""
    return np.divide(total, count, where=count > 0, out=np.full(total.shape, np.nan))


def _distribution(values: np.ndarray, bins: int | ArrayLike, none: str) -> Distribution:
    if not len(values):
        raise ValueError(f"there is nothing to distribute: {none}")
    edges = integer("bins", bins, 1) if np.ndim(bins) == 0 else _rising(bins)
    counts, edges = np.histogram(values, edges)
    return Distribution(counts / len(values) / np.diff(edges), edges)


def _limits(limits: tuple[float, float]) -> tuple[float, float]:
    try:
        least, largest = (float(limit) for limit in limits)
        if 0.0 <= least < largest:
            return least, largest
    except (TypeError, ValueError):
        pass
    raise ValueError(f"limits must be two forces, 0 <= least < largest, got {limits!r}")
