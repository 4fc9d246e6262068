"""Pressures from which the solvers start."""

from __future__ import annotations

import numpy as np

from ase_roughcontact._util.kernels import dot
from ase_roughcontact.contact import Contact
from ase_roughcontact.solvers.bounds import with_sum

# Growth of the compliance of springs. With twice as much, as many atoms would be in
# contact with a smooth sphere as in that of Hertz; roughness leaves fewer.
_GROWTH = 0.15


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
        depth, stiffness = winkler_foundation(above, total, compliance, _GROWTH)
        start = stiffness * np.maximum(depth - above, 0.0)
    push = contact.heights / -compliance
    return with_sum(np.minimum(start, hardness), total, hardness, push)


def winkler_foundation(
    heights: np.ndarray, total: float, compliance: float, growth: float = 0.0
) -> tuple[float, float]:
    r"""Return depth and stiffness of independent springs that carry a total pressure.

    At the depth :math:`d` the pressure is ``k max(d - (h - min h), 0)``. The compliance
    of a spring may grow with the number N of atoms in contact, which displace each
    other: :math:`k^{-1} = c [1 + \gamma (\sqrt{N} - 2)]`.
    """
    h = np.sort(heights - heights.min(), axis=None)
    count = np.arange(1, h.size + 1)
    springs = compliance * (1.0 + growth * (np.sqrt(count) - 2.0))
    below = np.cumsum(h)
    carried = (count[:-1] * h[1:] - below[:-1]) / springs[:-1]
    i = int(np.searchsorted(np.maximum.accumulate(carried), total))
    depth = (total * springs[i] + below[i]) / count[i]
    return float(depth), 1.0 / float(springs[i])


def start_factor(
    pressure: np.ndarray, opening: np.ndarray, undeformed: np.ndarray, exact: bool
) -> float:
    """Return a factor for a pressure: that of the least energy if it is below 0.5.

    The energy at a given height is ``p . G p / 2 + p . h``, with the opening ``G p``
    and the undeformed gap ``h``. On a soft spring any error of the sum moves the
    indenter far: there the factor is always the exact one.
    """
    curvature, slope = dot(pressure, opening), dot(pressure, undeformed)
    if -slope >= 0.5 * curvature and not (exact and curvature > 0.0):
        return 1.0
    return -slope / curvature if slope < 0.0 else 0.0
