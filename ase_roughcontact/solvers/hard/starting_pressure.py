"""Initial pressures of the solvers."""

from __future__ import annotations

import numpy as np

from ase_roughcontact.contact import Contact
from ase_roughcontact.solvers.hard.bounds import with_sum

# Increase of the compliance of springs per square root of the number of atoms in
# contact, which displace each other. It is 0.85 for a smooth circle, and smaller for
# rough contacts.
_COMPLIANCE_GROWTH = 0.3


def initial_pressure(
    contact: Contact, load: float | None, start: np.ndarray | None
) -> np.ndarray:
    """Return an initial pressure for a hard wall, which carries the load if given.

    Without a start, it is the pressure of independent springs under the load, or zero
    if the height is given.
    """
    hardness, halfspace = contact.wall.hardness, contact.halfspace
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
    if not contact.wall.plastic:
        return start * (total / start.sum())
    push = contact.heights / -compliance
    return with_sum(np.minimum(start, hardness), total, hardness, push)


def winkler_depth(above: np.ndarray, total: float, compliance: float) -> float:
    """Return the depth at which springs carry a total pressure.

    At the depth ``d`` the pressures are ``max(d - h, 0)`` over the compliance of a
    spring, with the heights ``h`` above the lowest point. Springs have the given
    compliance if few atoms are in contact, and a larger one otherwise. Newton's method
    begins with all springs in contact and approaches the depth from above: each step
    ends with fewer springs in contact, or is the last one.
    """
    depth, new = np.inf, np.finfo(float).max
    while new < depth:
        depth, touching = new, above < new
        count = np.count_nonzero(touching)
        factor = max(1.0 + _COMPLIANCE_GROWTH * (count**0.5 - 2.0), 1.0)
        needed = total * factor * compliance + float(above.sum(where=touching))
        new = needed / count
    return depth
