"""The atom that an indenter touches first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import window
from ase_roughcontact.topography import Surface
from ase_roughcontact.windows.footprint import Footprint


@dataclass(frozen=True)
class FirstContact:
    """Where an indenter touches first.

    Attributes
    ----------
    position : (float, float)
        Of the atom below the indenter's lowest point, relative to its axis (Å).
    height : float
        Of the indenter there (Å).
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
        `RoughSphere` or another bounded surface.
    spacing : float
        Distance of neighbouring atoms (Å).
    offset : (float, float)
        Position of any atom relative to the indenter's axis (Å).

    Returns
    -------
    FirstContact
        Of several atoms that are equally low, the one with the smallest x, then y.

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
    x, y = (
        (start + step) * spacing + rest
        for start, step, rest in zip(lowest.start, site, footprint.offset, strict=True)
    )
    return FirstContact((float(x), float(y)), float(heights.min()))
