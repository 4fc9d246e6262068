"""Heights of the indenter at which the wall carries the load.

The surface is fixed, or replaced by springs, so that no convolution is needed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from ase_roughcontact.solvers.hard.starting_pressure import winkler_depth
from ase_roughcontact.solvers.soft.energy import ContactEnergy, EnergyState

# First step of the search for the height that carries the load, in spacings.
_FIRST_STEP = 0.01
# Ratio of two steps of the search.
_STEP_RATIO = 1.5
# Largest number of steps of the search, which reaches any height.
_MAX_SEARCH_STEPS = 100
# Relative rounding error of a number.
_EPSILON = float(np.finfo(float).eps)
# Largest number of steps of the indenter alone. Each squares the relative error of the
# load.
_MAX_LOAD_STEPS = 3


def supports_indenter(state: EnergyState) -> bool:
    """Return whether the wall or a spring resists a change of height."""
    repulsive = bool((state.stiffness > 0.0).any())
    return repulsive or state.function.spring_stiffness(state.height) > 0.0


def carrying_height(
    energy: ContactEnergy,
    opening: np.ndarray | float = 0.0,
    highest: float = np.inf,
) -> float | None:
    """Return the largest height at which the wall carries the load on a fixed surface.

    Parameters
    ----------
    energy : ContactEnergy
        Energy of the contact.
    opening : ndarray, shape (n, m)
        Opening of the gap by the displacement of the surface (length); by default
        the surface is flat.
    highest : float
        Upper bound to the height (length); by default the height at which the wall is
        just in range.

    Returns
    -------
    float or None
        Height (length); None if the indenter is not pulled down, or no height carries
        the load.
    """
    shape = energy.contact.heights + opening

    def force(height: float) -> float:
        return energy.wall_force(shape, height) + energy.external(height)[1]

    high = low = min(float(energy.wall.cutoff - shape.min()), highest)
    if force(high) >= 0.0:
        return None
    spacing = energy.contact.halfspace.spacing
    for k in range(_MAX_SEARCH_STEPS):
        high, low = low, low - _FIRST_STEP * spacing * _STEP_RATIO**k
        if force(low) > 0.0:
            least = _EPSILON * spacing
            root = float(brentq(force, low, high, xtol=least, disp=False))
            return _repelled(force, root, low, least)
    return None


def _repelled(
    force: Callable[[float], float], height: float, low: float, step: float
) -> float:
    """Return a height just below a root where the rounded force is positive.

    Growing steps lead down to the low height, where the force is positive.
    """
    while force(height) <= 0.0 and height > low:
        height, step = max(height - step, low), 2.0 * step
    return height


def first_height(energy: ContactEnergy, height: float) -> float:
    """Return a height at which a surface of springs, or a flat one, carries the load.

    If the inverse of the wall is known, and no spring holds the indenter, the surface
    consists of the independent springs of `winkler_depth`, in series with the wall at
    its contact distance; otherwise it is flat. If no height carries the load, the given
    height is returned.
    """
    contact, wall = energy.contact, energy.wall
    load = -energy.external(height)[1]
    if wall.invertible and load > 0.0 and not energy.spring_stiffness(height) > 0.0:
        wall_compliance = 1.0 / float(wall.inverse(np.zeros(1))[2][0])
        compliance = contact.halfspace.self_compliance + wall_compliance
        above = contact.heights - contact.heights.min()
        depth = winkler_depth(above, load / energy.area, compliance)
        return contact.first_contact - depth
    carrying = carrying_height(energy)
    return height if carrying is None else carrying


def balance_load(state: EnergyState, tolerance: float) -> EnergyState:
    """Move the indenter alone if only its force exceeds the tolerance.

    Newton's method for the height, ``z = F / (a0^2 sum V'' + U'')``, needs no
    convolution, and is used as long as the energy falls. It distributes the missing
    load among the atoms in contact. Walls with attraction are left out: a fixed surface
    may hold an indenter that is unstable on an elastic one.
    """
    energy = state.function
    at_gaps = energy
    if energy.inverse and state.exact:
        # most often the last state, without another step
        at_gaps = replace(energy, inverse=False)
    for _ in range(_MAX_LOAD_STEPS):
        force = state.load_residual
        only_load = state.surface_error <= tolerance < abs(force)
        if energy.wall.attractive or not only_load:
            break
        # stiffness of wall and springs against a change of height, a0^2 sum V'' + U''
        stiffness = energy.area * float(state.stiffness.sum())
        stiffness += energy.spring_stiffness(state.height)
        if not stiffness > 0.0:
            break
        moved = state.again(at_gaps, state.height + force / stiffness)
        rises = moved.energy > state.energy + state.rounding
        if rises or not moved.error < state.error:
            break
        state = moved
    if state.function is not energy and state.error > tolerance:
        state = state.again(energy)
    return state
