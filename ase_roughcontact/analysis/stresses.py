r"""Stresses below the surface of a contact map: planes, sections, first yield.

The stress follows from the pressure and the tractions of the map, see `StressField`. On
a viscoelastic solid with one creep function it is the stress of today. Under a wall
with a hardness it is elastic: the model limits pressures, and has no residual stress.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import finite_array, one_of, positive
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.contact.state import TRACTIONS
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.elasticity.stress_field import StressField
from ase_roughcontact.results.record import LoadStep

# Number of depths of a section, by default.
_DEPTHS = 60
# Largest depth of a section by default, in radii of a circle of the contact area.
_RELATIVE_DEPTH = 2.0
# Part of the window below which a section is made without a contact.
_DEPTH_WITHOUT_CONTACT = 0.25


@dataclass(frozen=True, eq=False)
class StressPlane(Summarized):
    """Stress on the sites of a contact map at a depth.

    Attributes
    ----------
    depth : float
        Depth below the surface (Å).
    stress : ndarray, shape (6, n, m)
        Components xx, yy, zz, yz, xz and xy, tension positive, with z upward (eV/Å^3).
    """

    depth: float
    stress: np.ndarray


@dataclass(frozen=True, eq=False)
class StressSection(Summarized):
    """Stress on a vertical plane through a contact.

    Attributes
    ----------
    along : {"x", "y"}
        Horizontal axis of the plane.
    at : float
        Position of the plane along the other axis, from the indenter's axis (Å).
    position : ndarray, shape (k,)
        Positions along the axis, from the indenter's axis (Å).
    depth : ndarray, shape (d,)
        Depths below the surface (Å).
    stress : ndarray, shape (6, d, k)
        Components, see `StressPlane` (eV/Å^3).
    pressure : ndarray, shape (k,)
        Pressure on the row of sites that is nearest to the plane (eV/Å^3).
    """

    along: str
    at: float
    position: np.ndarray
    depth: np.ndarray
    stress: np.ndarray
    pressure: np.ndarray


@dataclass(frozen=True)
class FirstYield:
    """Load at which a solid yields first, and where; NaN if it does not.

    Attributes
    ----------
    normal_force : float
        Load (eV/Å).
    depth, x, y : float
        Place of the largest von Mises stress, x and y from the indenter's axis (Å).
    """

    normal_force: float = math.nan
    depth: float = math.nan
    x: float = math.nan
    y: float = math.nan


def stress_field(
    contact_map: ContactMap, solid: ElasticSolid, dtype: type | str = np.float64
) -> StressField:
    """Return the stress below a contact map.

    Parameters
    ----------
    contact_map : ContactMap
        Map with the pressure and the tractions of friction.
    solid : ElasticSolid
        The solid: `Isotropic` with Poisson's ratio, `Layer`, `Cubic`, `Crystal`, or one
        of them with creep.
    dtype : dtype, optional
        Precision of the transforms, single or double, see `StressField`.

    Returns
    -------
    StressField

    Raises
    ------
    NotImplementedError
        If the stress in the solid is not known.

    Examples
    --------
    >>> import numpy as np
    >>> from ase_roughcontact.analysis import ContactMap, stress_field
    >>> from ase_roughcontact.elasticity import Isotropic, largest_stress
    >>> x = np.arange(-40.0, 41.0)
    >>> pressure = np.sqrt(np.maximum(1.0 - (x[:, None] ** 2 + x**2) / 900.0, 0.0))
    >>> seen = ContactMap(pressure, pressure > 0, 1.0, (-40.0, -40.0), periodic=False)
    >>> field = stress_field(seen, Isotropic(0.9, poisson=0.3))
    >>> round(largest_stress(field).depth / 30.0, 2)
    0.48
    """
    tractions = None
    if TRACTIONS[0] in contact_map.lateral:
        tractions = np.stack([contact_map.lateral[name] for name in TRACTIONS])
    pressure, spacing = contact_map.pressure, contact_map.spacing
    periodic = contact_map.periodic
    return StressField(solid, spacing, pressure, tractions, periodic, dtype=dtype)


def stress_planes(
    contact_map: ContactMap, solid: ElasticSolid, depths: Iterable[float]
) -> Iterator[StressPlane]:
    """Yield the stress below a contact map at one depth after the other.

    Parameters
    ----------
    contact_map : ContactMap
    solid : ElasticSolid
        See `stress_field`.
    depths : iterable of float
        Depths (Å). From one or two spacings on they have the stress of the continuum.

    Yields
    ------
    StressPlane
        Stress at a depth: six fields of the size of the map at a time.
    """
    field = stress_field(contact_map, solid)
    for depth in depths:
        yield StressPlane(float(depth), field.stress(float(depth)))


def stress_section(
    contact_map: ContactMap,
    solid: ElasticSolid,
    along: Literal["x", "y"] = "x",
    at: float = 0.0,
    depths: Sequence[float] | None = None,
) -> StressSection:
    """Return the stress on a vertical plane through a contact.

    Parameters
    ----------
    contact_map : ContactMap
    solid : ElasticSolid
        See `stress_field`.
    along : {"x", "y"}
        Horizontal axis of the plane.
    at : float
        Position of the plane along the other axis, from the indenter's axis (Å).
    depths : sequence of float, optional
        Depths (Å); by default 60 from one spacing on down to twice the radius of a
        circle with the contact area.

    Returns
    -------
    StressSection

    Raises
    ------
    ValueError
        If the axis is unknown, the plane outside of a map that is not periodic, or a
        depth negative.
    """
    one_of(("x", "y"), along=along)
    across = 1 if along == "x" else 0
    shape = contact_map.pressure.shape
    line = (at - contact_map.origin[across]) / contact_map.spacing
    if not (contact_map.periodic or 0.0 <= line <= shape[across] - 1):
        first = contact_map.origin[across]
        last = first + (shape[across] - 1) * contact_map.spacing
        raise ValueError(
            f"the section must be between {first:g} and {last:g} Å, as the map is, got "
            f"{at:g} Å"
        )
    levels = _section_depths(contact_map) if depths is None else depths
    levels = np.atleast_1d(finite_array("depths", levels))
    if not levels.size:
        raise ValueError("depths must have at least one number")
    field, sites = stress_field(contact_map, solid), np.arange(shape[1 - across])
    x, y = (sites, np.array([line]))[:: 1 if along == "x" else -1]
    stress = [field.stress_at(x, y, float(each)).reshape(6, -1) for each in levels]
    return StressSection(
        along=along,
        at=float(at),
        position=contact_map.x if along == "x" else contact_map.y,
        depth=levels,
        stress=np.stack(stress, axis=1),
        pressure=contact_map.pressure.take(round(line) % shape[across], axis=across),
    )


def _section_depths(contact_map: ContactMap) -> np.ndarray:
    """Return the depths of a section that shows the stress below a contact (Å)."""
    spacing = contact_map.spacing
    deepest = _RELATIVE_DEPTH * math.sqrt(contact_map.contact_area / math.pi)
    if not contact_map.contact.any():
        side = min(contact_map.pressure.shape)
        deepest = _DEPTH_WITHOUT_CONTACT * spacing * side
    return np.linspace(spacing, max(deepest, 2.0 * spacing), _DEPTHS)


def first_yield(steps: Sequence[LoadStep], yield_strength: float) -> FirstYield:
    r"""Return the load of a path at which the solid yields first.

    The largest von Mises stress reaches the yield strength. Between two steps, load and
    stress are interpolated as a power law, which is exact for a smooth sphere,
    :math:`\sigma \propto N^{1/3}`.

    Parameters
    ----------
    steps : sequence of LoadStep
        Steps of a path in order, with the columns ``largest_von_mises``,
        ``von_mises_depth``, ``von_mises_x`` and ``von_mises_y``.
    yield_strength : float
        Yield strength, for metals about a third of the hardness (eV/Å^3).

    Returns
    -------
    FirstYield
        NaN if the solid does not yield, or does so before the first step with a
        repulsive load.

    Raises
    ------
    ValueError
        If the yield strength is not positive, or the steps have no such columns, or
        the stress in the solid is not known.
    """
    positive(yield_strength=yield_strength)
    names = "largest_von_mises", "von_mises_depth", "von_mises_x", "von_mises_y"
    pressed = [step for step in steps if step.normal_force > 0.0]
    missing = [each for each in names if not all(hasattr(s, each) for s in pressed)]
    if missing:
        raise ValueError(
            f"the steps have no column {missing[0]!r}: give Output(columns={names})"
        )
    unknown = [
        step.not_known[names[0]] for step in pressed if names[0] in step.not_known
    ]
    if unknown:
        raise ValueError(f"the largest von Mises stress is not known: {unknown[0]}")
    rows = [[s.normal_force, *(getattr(s, each) for each in names)] for s in pressed]
    table = np.array(rows).reshape(-1, 5)
    stress = table[:, 1]
    over = np.flatnonzero(stress >= yield_strength)
    if not over.size or over[0] == 0:
        return FirstYield()
    low, high = table[over[0] - 1], table[over[0]]
    part = math.log(yield_strength / low[1]) / math.log(high[1] / low[1])
    force = float(low[0] * (high[0] / low[0]) ** part)
    return FirstYield(force, *(low[2:] + part * (high[2:] - low[2:])).tolist())
