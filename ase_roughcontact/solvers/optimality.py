r"""Conditions of contact with a hard wall, and the residuals of a pressure.

With the gap :math:`g = Z + h + G p`,

.. math:: g \ge 0, \qquad p \ge 0, \qquad g p = 0,

are the conditions. A hardness :math:`H` of the wall adds :math:`p \le H`, and
:math:`g \le 0` where :math:`p = H`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact.contact import Contact


@dataclass(frozen=True)
class OptimalityResiduals:
    """Residuals of the optimality (KKT) conditions of a hard contact.

    Attributes
    ----------
    gap_in_contact : float
        Largest magnitude of the gap of an atom under a pressure below the hardness
        (length).
    penetration : float
        Largest overlap of an atom without pressure (length).
    tension : float
        Largest negative pressure (pressure).
    opening_at_hardness : float
        Largest gap of an atom under the hardness (length); zero without a hardness.
    excess : float
        Largest pressure above the hardness (pressure).
    load_error : float
        Difference of normal force and load, zero without a load (force).
    """

    gap_in_contact: float
    penetration: float
    tension: float
    opening_at_hardness: float
    excess: float
    load_error: float


def optimality_residuals(
    contact: Contact, pressure: np.ndarray, height: float, load: float | None = None
) -> OptimalityResiduals:
    """Return the residuals of a solution, by one convolution on the whole window.

    Parameters
    ----------
    contact : Contact
        Contact; the wall counts as hard.
    pressure : ndarray, shape (n, m)
        Pressure on the window, including its mean.
    height : float
        Height of the indenter (length).
    load : float, optional
        Load that the pressure should carry (force).

    Returns
    -------
    OptimalityResiduals
        Residuals of the conditions.
    """
    halfspace = contact.halfspace
    gap = height + contact.heights - halfspace.displacement(pressure)
    hardness = contact.wall.hardness
    in_contact, plastic = pressure > 0.0, pressure >= hardness
    force = float(pressure.sum()) * halfspace.cell_area
    return OptimalityResiduals(
        gap_in_contact=float(abs(gap[in_contact & ~plastic]).max(initial=0.0)),
        penetration=abs(float(gap.min(where=~in_contact, initial=0.0))),
        tension=abs(float(pressure.min(initial=0.0))),
        opening_at_hardness=float(gap.max(where=plastic, initial=0.0)),
        excess=max(float(pressure.max()) - hardness, 0.0),
        load_error=0.0 if load is None else abs(force - load),
    )
