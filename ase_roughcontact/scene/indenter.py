"""The indenter of a scene: radius of its sphere, or periodic cell of a rough flat."""

from __future__ import annotations

import math
from dataclasses import replace

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import Shape, positive
from ase_roughcontact.scene.config import DEFAULT_RADIUS, SphereConfig
from ase_roughcontact.scene.file import SceneFile
from ase_roughcontact.scene.scan import TopographyConfig
from ase_roughcontact.scene.section import lengths
from ase_roughcontact.topography import HeightMap, SelfAffine

# Relative tolerance within which the sides of pixels are the same.
_SQUARE = 1e-6


def radius_of(
    sphere: SphereConfig, topography: TopographyConfig | None, spacing: float
) -> float:
    """Return the radius of the sphere, or of curvature of a whole tip.

    Parameters
    ----------
    sphere : SphereConfig
    topography : TopographyConfig or None
    spacing : float
        Atomic spacing a0 (Å).

    Returns
    -------
    float
        Å; infinity for a rough flat.

    Raises
    ------
    ValueError
        If it is out of range, missing for a scanned indenter, or infinite for a scan of
        a hollow.
    """
    given = sphere.radius
    if given == math.inf:
        if topography is None:
            return math.inf
        scan = topography.surface
        if topography.role == "substrate" or scan.periodic:
            return math.inf
        if scan.tip.is_tip:
            return scan.tip.radius
        if scan.turned.tip.is_tip:
            raise ValueError(
                "the scan of a tip is not convex around its highest point: is the "
                "height reversed? Else give the radius of the sphere in place of inf"
            )
        return math.inf
    if given is None:
        if topography is None or topography.role != "indenter":
            return DEFAULT_RADIUS * spacing
        tip = topography.surface.tip
        shape = "the scan does not say whether it is that of a whole tip"
        if tip.is_tip:
            nm = f"{tip.radius / UNITS['nm']:.3g} nm"
            shape = f"the scan itself has a radius of about {nm} at its highest point"
        raise ValueError(
            f"{shape}: give radius = inf if it is the whole tip, or the radius of the "
            "sphere that it is the roughness of"
        )
    radius = sphere.plain(["radius"], lengths(spacing), "a0", sphere.unit).radius
    if not (isinstance(given, str) and 0.0 < radius < math.inf):
        positive(radius=given)
    if radius < 1.0:
        raise ValueError(
            f"radius must be at least the spacing a0 = {spacing:.4g} Å, got {given!r}, "
            f"{radius:.3g} a0"
        )
    return radius * spacing


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
