"""Summary of a scan in one line, and warnings about it."""

from __future__ import annotations

from pathlib import Path

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.scene.scan import TopographyConfig
from ase_roughcontact.topography import HeightMap
from ase_roughcontact.topography.scan_files import TEXT

# Limits beyond which a scan is doubtful: share of missing points, rms slopes, and size.
_MOST_MISSING = 0.1
_SLOPES = 1e-4, 1.0
_LARGEST = 1e3 * UNITS["µm"]
# Size from which it is printed in micrometres.
_IN_MICROMETRES = 10.0 * UNITS["µm"]
# Rms height below which a scan is constant (Å).
_CONSTANT = 1e-9


def scan_line(config: TopographyConfig) -> str:
    """Return size, missing points, statistics and place of a scan as a line.

    Parameters
    ----------
    config : TopographyConfig

    Returns
    -------
    str
        The statistics are those after detrending.
    """
    surface, nm = config.surface, UNITS["nm"]
    (n, m), (width, height) = surface.shape, _size(surface)
    name = "µm" if max(width, height) >= _IN_MICROMETRES else "nm"
    unit = UNITS[name]
    statistics = surface.statistics()
    x, y = surface.center
    if config.role == "indenter":  # it was turned over
        x = (n - 1) * surface.spacing[0] - x
    place = "highest" if config.center == "highest" else "axis"
    parts = [
        f"{width / unit:.4g} x {height / unit:.4g} {name}",
        f"{n} x {m} points{_order(config.file)}",
        f"{surface.missing} ({100.0 * surface.missing / (n * m):.2g} %) missing",
        f"rms height {statistics.rms_height / nm:.3g} nm",
        f"rms slope {statistics.rms_slope:.3g}",
        f"{place} at ({x / unit:.4g}, {y / unit:.4g}) {name}",
    ]
    if surface.tip.is_tip:
        parts.append(
            f"curvature of the scan itself: radius {surface.tip.radius / nm:.3g} nm"
        )
    return f"{Path(config.file).name}: {', '.join(parts)}"


def scan_warnings(
    config: TopographyConfig, radius: float, whole_tip: bool
) -> list[str]:
    """Return warnings about a scan.

    Parameters
    ----------
    config : TopographyConfig
    radius : float
        Of the sphere (Å).
    whole_tip : bool
        Whether the scan is the whole indenter, without a sphere.

    Returns
    -------
    list of str
        Sentences; empty if there is nothing.
    """
    surface = config.surface
    n, m = surface.shape
    missing, size = surface.missing / (n * m), max(_size(surface))
    statistics, found = surface.statistics(), []
    low, high = _SLOPES
    if missing > _MOST_MISSING:
        found.append(
            f"{100.0 * missing:.0f} % of the points are missing and are interpolated: "
            "is a part of the scan enough, or another channel?"
        )
    if statistics.rms_height < _CONSTANT:
        found.append("all heights are the same: is it the channel of the height?")
    elif statistics.rms_height > radius:
        found.append(
            f"the rms height of {statistics.rms_height / UNITS['nm']:.3g} nm exceeds "
            f"the radius of the sphere, {radius / UNITS['nm']:.3g} nm: are both units "
            "right?"
        )
    # the sides of a whole tip are steep
    elif statistics.rms_slope < low or (statistics.rms_slope > high and not whole_tip):
        found.append(
            f"the rms slope is {statistics.rms_slope:.3g}, usual are {low:g} to "
            f"{high:g}: are the units of heights and of spacing right?"
        )
    if size > _LARGEST:
        found.append(
            f"the scan is {size / _LARGEST:.3g} mm wide: is the unit of spacing right?"
        )
    if config.role == "indenter" and surface.tip.is_tip and not whole_tip:
        found.append(
            "the scan itself has a radius of about "
            f"{surface.tip.radius / UNITS['nm']:.3g} nm at its highest point, and the "
            "curvature of the sphere is added to it: give radius = inf if it is the "
            'whole tip, or detrend = "curvature" if it is roughness of the sphere'
        )
    return [f"{Path(config.file).name}: {each}" for each in found]


def _order(file: str) -> str:
    """Return which way x is, for files that do not say it themselves."""
    suffix = Path(file).suffix.lower()
    if suffix == ".npy":
        return " (first index along x)"
    return " (rows of a matrix along x)" if suffix in TEXT else ""


def _size(surface: HeightMap) -> tuple[float, float]:
    (n, m), (x, y) = surface.shape, surface.spacing
    return n * x, m * y
