"""Radius of the sphere of a scene, or of curvature of a scan that is the whole tip."""

from __future__ import annotations

import math

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import positive
from ase_roughcontact.scene.config import DEFAULT_RADIUS, SphereConfig
from ase_roughcontact.scene.flats import is_flat
from ase_roughcontact.scene.scan import TopographyConfig
from ase_roughcontact.scene.section import lengths
from ase_roughcontact.topography import HeightMap


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
        return math.inf if is_flat(scan, topography.role) else scan.tip.radius
    if given is None:
        if topography is not None and topography.role == "indenter":
            raise ValueError(_missing_radius(topography.surface))
        return DEFAULT_RADIUS * spacing
    radius = sphere.plain(["radius"], lengths(spacing), "a0", sphere.unit).radius
    if not (isinstance(given, str) and 0.0 < radius < math.inf):
        positive(radius=given)
    if radius < 1.0:
        raise ValueError(
            f"radius must be at least the spacing a0 = {spacing:.4g} Å, got {given!r}, "
            f"{radius:.3g} a0"
        )
    return radius * spacing


def _missing_radius(scan: HeightMap) -> str:
    """Return why a scanned indenter needs a radius."""
    shape = "the scan does not say whether it is that of a whole tip"
    if scan.tip.is_tip:
        nm = f"{scan.tip.radius / UNITS['nm']:.3g} nm"
        shape = f"the scan itself has a radius of about {nm} at its highest point"
    return (
        f"{shape}: give radius = inf if it is the whole tip, or the radius of the "
        "sphere that it is the roughness of"
    )
