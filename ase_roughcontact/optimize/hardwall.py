r"""Contact of a hard wall with the half space: pressures that only push.

Find the pressure :math:`p` on the window and the indenter's height :math:`Z` with

.. math:: g = Z + h + G p \ge 0, \qquad p \ge 0, \qquad g p = 0,

and :math:`Z` or the load :math:`a_0^2 \sum p` given: the minimum of the convex energy
:math:`p \cdot G p/2 + (Z + h) \cdot p` over :math:`p \ge 0`.

*Outer steps*, defect correction. One exact convolution gives the exact gap. Then
:math:`G` is replaced by a `Circulant` on the atoms that may touch, and the contact
problem of this model is solved for the correction of the pressure. The model's gradient
is exact at the present pressure, hence its minimum lies in a direction of descent: a
step that overshoots is cut to the least energy along it, and the energy never rises.

*Inner steps*, inexact active set. With the present set of atoms in contact the model's
linear system is solved by conjugate gradients, preconditioned by the model's inverse,
to a tenth of the present violation only; then atoms under tension leave and atoms that
overlap enter.

On a free half space the window is cut to the atoms that the rigid indenter overlaps,
since no other can touch. Without a start, the problem is solved on every other atom
first, and so on.

References
----------
I. A. Polonsky, L. M. Keer, Wear 231, 206 (1999); M. Hintermüller, K. Ito, K. Kunisch,
SIAM J. Optim. 13, 865 (2002) (active set); E. A. H. Vollebregt, J. Comput. Phys. 257,
332 (2014) (preconditioner).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ase_roughcontact.checks import finite, finite_array, positive
from ase_roughcontact.contact import Contact
from ase_roughcontact.interactions import HardWall
from ase_roughcontact.optimize.circulant import Circulant
from ase_roughcontact.optimize.nested import (
    Box,
    can_coarsen,
    coarsen,
    crop,
    join,
    reachable,
    refine,
    whole,
)
from ase_roughcontact.optimize.problem import Relaxation, dot

External = Callable[[float], tuple[float, float]]

# Largest gap in contact, in spacings: of a result, and on coarser grids.
_GAP = 1e-6
_COARSE_GAP = 0.03
# Part of a violation that the model's solution may leave, and that its linear systems
# may leave before the set of atoms in contact is looked at again.
_CONTRACTION = 0.1
_FORCING = 0.1
# Steps of conjugate gradients for one correction, and outer steps without progress.
_BUDGET = 300
_PATIENCE = 10
# Below this part of the largest one a pressure given as a start is rounding.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class Certificate:
    """How well the conditions of a hard contact hold.

    Attributes
    ----------
    gap_in_contact : float
        Largest gap of an atom under pressure, either way (length).
    penetration : float
        Deepest overlap of an atom without pressure (length).
    tension : float
        Largest negative pressure (pressure).
    load_error : float
        Difference of normal force and load, zero without a load (force).
    """

    gap_in_contact: float
    penetration: float
    tension: float
    load_error: float


def certificate(
    contact: Contact, pressure: np.ndarray, height: float, load: float | None = None
) -> Certificate:
    """Check a solution afresh, by one convolution on the whole window.

    Parameters
    ----------
    contact : Contact
        With any wall; it is taken for hard.
    pressure : ndarray, shape (n, m)
        On the window, its mean included (pressure).
    height : float
        Of the indenter (length).
    load : float, optional
        What the pressure should add up to (force).

    Returns
    -------
    Certificate
    """
    halfspace = contact.halfspace
    gap = height + contact.heights - halfspace.displacement(pressure)
    touching = pressure > 0.0
    force = float(pressure.sum()) * halfspace.cell_area
    return Certificate(
        gap_in_contact=float(abs(gap[touching]).max(initial=0.0)),
        penetration=float(-gap.min(where=~touching, initial=0.0)),
        tension=float(-pressure.min(initial=0.0)),
        load_error=0.0 if load is None else abs(force - load),
    )


def iterate(
    contact: Contact,
    *,
    height: float,
    external: External | None,
    start: np.ndarray | None,
    tolerance: float,
) -> Iterator[Relaxation]:
    """Relax the contact of a hard wall, step by step.

    Parameters
    ----------
    contact : Contact
        With a `HardWall`.
    height : float
        Of the indenter (length): fixed, or where to start from if there is a load.
    external : callable, optional
        Energy and force of the load on the indenter at a height; the force must be
        the same at every height. By default the height is fixed.
    start : ndarray, shape (n, m), optional
        Pressure to start from. By default it comes from coarser grids.
    tolerance : float
        Largest force that is left: that which closes the gap of an atom in contact, or
        pushes one out that overlaps. However large it is, no gap in contact is left
        larger than 1e-6 spacings.

    Yields
    ------
    Relaxation
        The start, and the state after each outer step. The last one is converged, or
        has a message. The load is always carried, to rounding.

    Raises
    ------
    ValueError
        If the wall is not hard, the start does not fit, the load pulls or depends on
        the height, or the height of a periodic surface is one that no load reaches.
    """
    _check(contact, height, external, tolerance)
    halfspace = contact.halfspace
    load = None if external is None else -external(height)[1]
    if external is not None and load == 0.0:
        height, load = contact.first_contact, None
    start = None if start is None else _clean(contact, start)
    force_per_gap = halfspace.cell_area / halfspace.atom_compliance
    gap = min(tolerance / force_per_gap, _GAP * halfspace.spacing)
    for state in _solve(contact, height, load, start, gap):
        energy = -0.5 * halfspace.cell_area * dot(state.pressure, state.displacement)
        if external is not None:
            energy += external(state.height)[0]
        yield _Whole(
            state,
            contact,
            energy=energy,
            error=state.violation * force_per_gap,
            pairs=state.work / math.prod(halfspace.grid),
        )


def _check(
    contact: Contact, height: float, external: External | None, tolerance: float
) -> None:
    """Raise `ValueError` if there is no solution or none that is found here."""
    if not isinstance(contact.interaction, HardWall):
        raise ValueError(f"HardWallCG is for the hard wall, got {contact.interaction}")
    finite(height=height)
    positive(tolerance=tolerance)
    if external is not None:
        _check_load(external, (height, contact.first_contact, contact.lowest))
    elif contact.halfspace.periodic and height <= -contact.heights.mean():
        raise ValueError(
            f"height {height:g} is not above {-contact.heights.mean():g}, where all of "
            "the periodic surface is in contact under any load: give a load instead"
        )


def _check_load(external: External, heights: tuple[float, ...]) -> None:
    """Raise `ValueError` unless the load is the same at the heights, and pushes."""
    loads = [-external(height)[1] for height in heights]
    if not all(math.isclose(load, loads[0], rel_tol=1e-9) for load in loads):
        told = ", ".join(
            f"{a:g} at height {b:g}" for a, b in zip(loads, heights, strict=True)
        )
        raise ValueError(
            "HardWallCG can't honour a spring on the indenter: the load is "
            f"{told}; give a constant load, or fix the height"
        )
    if not 0.0 <= loads[0] < math.inf:
        raise ValueError(
            f"a hard wall carries no tension: the load must be >= 0, got {loads[0]:g}"
        )
