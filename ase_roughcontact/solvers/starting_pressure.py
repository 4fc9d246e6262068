"""Pressures from which the solvers start."""

from __future__ import annotations

import math

import numpy as np

from ase_roughcontact._util.kernels import dot
from ase_roughcontact.contact import Contact
from ase_roughcontact.solvers.bounds import clip_to_sum, with_sum


def initial_pressure(
    contact: Contact, load: float | None, start: np.ndarray | None
) -> np.ndarray:
    """Return an initial pressure for a hard wall; with a load one that carries it.

    Without a start, it is that of independent springs under the load, each with the
    compliance of an atom, and zero if the height is given.
    """
    hardness = contact.interaction.hardness
    if start is not None and hardness < math.inf:
        start = np.minimum(start, hardness)
    if load is None:
        return np.zeros(contact.heights.shape) if start is None else start
    halfspace = contact.halfspace
    total, stiffness = load / halfspace.cell_area, 1.0 / halfspace.self_compliance
    if hardness < math.inf:
        push = -stiffness * contact.heights
        if start is None or not start.any():
            return clip_to_sum(push, total, hardness)
        return with_sum(start, total, hardness, push)
    if start is None or not start.any():
        start = winkler_pressure(contact.heights, total, stiffness)
    return start * (total / start.sum())


def winkler_pressure(heights: np.ndarray, total: float, stiffness: float) -> np.ndarray:
    """Return the pressure of independent springs (Winkler foundation) by its sum.

    ``p = k max(level - h, 0)``, where the level follows from ``sum p = total``.
    """
    above = heights - heights.min()
    h = np.sort(above, axis=None)
    carried = stiffness * (np.arange(1, h.size) * h[1:] - np.cumsum(h[:-1]))
    count = int(np.searchsorted(carried, total)) + 1
    level = (total / stiffness + h[:count].sum()) / count
    return stiffness * np.maximum(level - above, 0.0)


def start_factor(
    pressure: np.ndarray, opening: np.ndarray, undeformed: np.ndarray
) -> float:
    """Return a factor for a pressure: that of the least energy if it is below 0.5.

    The energy at a given height is ``p . G p / 2 + p . h``, with the opening ``G p``
    and the undeformed gap ``h``.
    """
    curvature, slope = dot(pressure, opening), dot(pressure, undeformed)
    if -slope >= 0.5 * curvature:
        return 1.0
    return -slope / curvature if slope < 0.0 else 0.0
