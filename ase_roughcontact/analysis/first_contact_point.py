"""The atom that an indenter touches first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import window
from ase_roughcontact.topography import Surface
from ase_roughcontact.windows.footprint import Footprint


@dataclass(frozen=True)
class FirstContact:
    """Point at which an indenter touches first.

    Attributes
    ----------
    position : (float, float)
        Position of the atom below the indenter's lowest point, relative to the axis
        (Å).
    height : float
        Height of the indenter above this atom (Å).
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
        Shape of the indenter, `RoughSphere` or another bounded surface.
    spacing : float
        Distance of neighbouring atoms (Å).
    offset : (float, float)
        Position of any atom relative to the indenter's axis (Å).

    Returns
    -------
    FirstContact
        Point of first contact. If several atoms touch at the same height, it is the one
        with the smallest x, and then the smallest y.

    Raises
    ------
    ValueError
        If the indenter is not bounded, or an atom where its surface is undefined could
        touch first.
    """
    _, spacing, offset = window((1, 1), spacing, offset)
    footprint = Footprint(indenter, spacing, offset)
    footprint.check(footprint.lowest)
    lowest = footprint.box_below(footprint.lowest)
    heights = footprint.heights(lowest)
    site = np.unravel_index(heights.argmin(), heights.shape)
    x = (lowest.start[0] + site[0]) * spacing + footprint.offset[0]
    y = (lowest.start[1] + site[1]) * spacing + footprint.offset[1]
    return FirstContact((float(x), float(y)), float(heights.min()))
