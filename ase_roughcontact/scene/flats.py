"""Nominally flat indenters of a scene: the cell that they repeat, and its area."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import FloatArray, Shape
from ase_roughcontact.scene.file import SceneFile
from ase_roughcontact.topography import HeightMap, SelfAffine

# Relative tolerance within which the sides of pixels are the same.
_SQUARE = 1e-6


@dataclass(frozen=True)
class NominalArea:
    """The nominal contact area, in place of the theory of a smooth sphere.

    Attributes
    ----------
    nominal_area : float
        A0 of the cell (Å^2).
    """

    nominal_area: float
    pull_off_force: ClassVar[float] = 0.0
    name: ClassVar[str] = "nominal area"
    symbol: ClassVar[str] = "0"
    sphere: ClassVar[str] = "that of the cell"
    label: ClassVar[str] = "nominal area"

    def contact_area(self, normal_force: ArrayLike) -> FloatArray:
        """Return the area A0 for each force, shape of the forces (Å^2)."""
        return np.full(np.shape(normal_force), self.nominal_area)


def is_flat(scan: HeightMap, role: str) -> bool:
    """Return whether a scan without a sphere is a rough flat, and no whole tip.

    Raises
    ------
    ValueError
        If the scan is that of a tip with its height reversed.
    """
    if role == "substrate" or scan.periodic or scan.tip.is_tip:
        return role == "substrate" or scan.periodic
    if scan.turned.tip.is_tip:
        raise ValueError(
            "radius = inf means that the scan is the whole tip or a rough flat, but it "
            "is not convex around its highest point: is the height reversed? Else give "
            "the radius of the sphere"
        )
    return True


def flat_cell(
    scene: SceneFile, rough: SelfAffine | HeightMap, spacing: float
) -> tuple[float, Shape, SelfAffine | HeightMap]:
    """Return grid spacing, shape and roughness of the periodic cell of a flat.

    The grid of a scan is that of its pixels, and the cell the scan, which is made
    periodic. A random surface is sampled by atoms.

    Parameters
    ----------
    scene : SceneFile
    rough : SelfAffine or HeightMap
    spacing : float
        Atomic spacing a0 (Å).

    Returns
    -------
    spacing : float
        Å.
    shape : (int, int)
    rough : SelfAffine or HeightMap
        With the middle of the cell on the axis; see `HeightMap.made_periodic`.

    Raises
    ------
    ValueError
        If the pixels are not squares, or a given cell is larger.
    """
    if isinstance(rough, HeightMap):
        x, y = rough.spacing
        if not math.isclose(x, y, rel_tol=_SQUARE):
            raise ValueError(
                f"the pixels of a flat must be squares, got {x / 10:g} x {y / 10:g} nm:"
                " resample the scan, or correct spacing"
            )
        (n, m), spacing, rough = rough.shape, x, rough.made_periodic()
    else:
        n = m = round(rough.side / spacing)
    shape = replace(scene.substrate, periodic=False).window_shape or (n, m)
    if shape[0] > n or shape[1] > m:
        raise ValueError(
            f"shape must be at most {n} x {m}, the points of the flat, got "
            f"{shape[0]} x {shape[1]}: leave it out"
        )
    return spacing, shape, rough
