"""Pressures from which the solvers start."""

from __future__ import annotations

import numpy as np

from ase_roughcontact.contact import Contact
from ase_roughcontact.solvers.bounds import with_sum


def initial_pressure(
    contact: Contact, load: float | None, start: np.ndarray | None
) -> np.ndarray:
    """Return an initial pressure for a hard wall; with a load one that carries it.

    Without a start, it is that of independent springs under the load, and zero if the
    height is given.
    """
    hardness, halfspace = contact.interaction.hardness, contact.halfspace
    compliance = halfspace.self_compliance
    if start is None:
        start = np.zeros(contact.heights.shape)
    if load is None:
        return np.minimum(start, hardness)
    total = load / halfspace.cell_area
    if not start.any():
        above = contact.heights - contact.heights.min()
        depth = winkler_depth(above, total, compliance)
        start = np.maximum(depth - above, 0.0) / compliance
    if not contact.interaction.plastic:
        return start * (total / start.sum())
    push = contact.heights / -compliance
    return with_sum(np.minimum(start, hardness), total, hardness, push)


def winkler_depth(above: np.ndarray, total: float, compliance: float) -> float:
    """Return the depth at which independent springs carry a total pressure.

    At the depth ``d`` the pressures are ``max(d - h, 0)`` over the compliance of a
    spring, with the heights ``h`` above the lowest point. Their sum is convex: Newton's
    method, which begins with all springs in contact, approaches the depth from above.
    """
    depth, new = np.inf, np.finfo(float).max
    while new < depth:
        depth, touching = new, above < new
        needed = total * compliance + float(above.sum(where=touching))
        new = needed / np.count_nonzero(touching)
    return depth
