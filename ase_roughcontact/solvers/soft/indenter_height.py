"""Heights of the indenter at which the wall carries the load.

They cost no convolution: the surface is held fixed, or replaced by springs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from ase_roughcontact.solvers.hard.starting_pressure import winkler_depth
from ase_roughcontact.solvers.soft.energy import ContactEnergy, EnergyState

# Search for the height that carries the load: first step in spacings, growth of the
# steps, and their number, which covers any height.
_FIRST_STEP = 0.01
_GROWTH = 1.5
_SEARCH_STEPS = 100
# Relative rounding error of a number.
_EPSILON = float(np.finfo(float).eps)
# Steps of the indenter alone; each squares the relative error of the load.
_LOAD_STEPS = 3


def supports_indenter(state: EnergyState) -> bool:
    """Return whether the wall or a spring resists a change of height."""
    repulsive = bool((state.stiffness > 0.0).any())
    return repulsive or state.function.spring_stiffness(state.height) > 0.0


def carrying_height(
    energy: ContactEnergy,
    opening: np.ndarray | float = 0.0,
    highest: float = np.inf,
) -> float | None:
    """Return the largest height at which the wall carries the load.

    The surface is held fixed.

    Parameters
    ----------
    opening : ndarray, shape (n, m)
        Opening of the gap by the displacement of the surface (length); by default
        the surface is flat.
    highest : float
        Upper bound to the height; by default the one at which the wall is just in
        range.

    Returns
    -------
    float or None
        None if the indenter is not pulled down, or no height carries the load.
    """
    shape = energy.contact.heights + opening

    def force(height: float) -> float:
        return energy.wall_force(shape, height) + energy.external(height)[1]

    high = low = min(float(energy.wall.cutoff - shape.min()), highest)
    if force(high) >= 0.0:
        return None
    spacing = energy.contact.halfspace.spacing
    for k in range(_SEARCH_STEPS):
        high, low = low, low - _FIRST_STEP * spacing * _GROWTH**k
        if force(low) > 0.0:
            least = _EPSILON * spacing
            root = float(brentq(force, low, high, xtol=least, disp=False))
            return _repelled(force, root, low, least)
    return None


def _repelled(
    force: Callable[[float], float], height: float, low: float, step: float
) -> float:
    """Return a height just below a root where the rounded force is positive.

    It is positive at the low height, which growing steps reach.
    """
    while force(height) <= 0.0 and height > low:
        height, step = max(height - step, low), 2.0 * step
    return height


def first_height(energy: ContactEnergy, height: float) -> float:
    """Return a height at which a flat surface, or one of springs, carries the load.

    If the inverse of the wall is known, and no spring holds the indenter, the surface
    is one of the independent springs of `winkler_depth`, in series with the wall at its
    contact distance. If no height carries the load, it is the given one.
    """
    contact, wall = energy.contact, energy.wall
    load = -energy.external(height)[1]
    if wall.invertible and load > 0.0 and not energy.spring_stiffness(height) > 0.0:
        softness = 1.0 / float(wall.inverse(np.zeros(1))[2][0])
        compliance = contact.halfspace.self_compliance + softness
        above = contact.heights - contact.heights.min()
        depth = winkler_depth(above, load / energy.area, compliance)
        return contact.first_contact - depth
    carrying = carrying_height(energy)
    return height if carrying is None else carrying


def balance_load(state: EnergyState, tolerance: float) -> EnergyState:
    """Move the indenter alone where only its force exceeds the tolerance.

    By Newton's method for the height, ``z = F / (a0^2 sum V'' + U'')``, without a
    convolution, as long as the energy falls. It spreads what is missing of the load
    over the atoms in contact. Not for walls with attraction: there a fixed surface may
    hold an indenter that is unstable on an elastic one.
    """
    energy = state.function
    at_gaps = energy
    if energy.inverse and state.exact:  # most states are the last ones
        at_gaps = replace(energy, inverse=False)
    for _ in range(_LOAD_STEPS):
        force = state.load_residual
        only_load = state.surface_error <= tolerance < abs(force)
        if energy.wall.attractive or not only_load:
            break
        # of wall and springs against a change of height, a0^2 sum V'' + U''
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
