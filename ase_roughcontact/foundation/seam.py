"""Stress on the plane between a slab of atoms and the crystal below it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class SeamStress:
    """Stress on the plane below the lowest layer of a slab.

    Attributes
    ----------
    depth : float
        Depth of the plane below the surface layer at rest: the middle between the
        lowest layer and the next one (Å).
    positions : ndarray, shape (n, m, 2)
        Positions x and y of the atoms of the lowest layer at rest (Å).
    stress : ndarray, shape (3, n, m)
        Components xz, yz and zz for each cell, tension positive (eV/Å^3).
    """

    depth: float
    positions: np.ndarray
    stress: np.ndarray
