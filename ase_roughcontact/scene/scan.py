"""The section ``[topography]`` of a scene file: a scan as the roughness."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from ase_roughcontact._util.identity import digest_of_file
from ase_roughcontact._util.units import LENGTHS, UNITS
from ase_roughcontact._util.validation import FloatArray, integer
from ase_roughcontact.scene.section import SUBSTRATE_SEED, Section
from ase_roughcontact.topography import HeightMap
from ase_roughcontact.topography.measurement import ScanWarning
from ase_roughcontact.topography.pressed_scan import ROLES
from ase_roughcontact.topography.scan import in_angstrom
from ase_roughcontact.topography.scan_files import TEXT
from ase_roughcontact.topography.spectrum import edge_step, has_edge_step, statistics

# Share of missing points above which a scan is doubtful.
_MAX_MISSING_SHARE = 0.1
# Least rms slope of a scan that is not doubtful.
_MIN_RMS_SLOPE = 1e-4
# Largest rms slope of a scan that is not doubtful.
_MAX_RMS_SLOPE = 1.0
# Share of the noise in the mean square slope above which a scan is doubtful.
_MAX_NOISE_SHARE = 0.1
# Size above which a scan is doubtful (Å).
_MAX_SIZE = 1e3 * UNITS["µm"]
# Size from which the size is printed in micrometres (Å).
_MIN_SIZE_IN_MICROMETRES = 10.0 * UNITS["µm"]
# Rms height below which a scan is constant (Å).
_MIN_RMS_HEIGHT = 1e-9


@dataclass(frozen=True)
class TopographyConfig(Section):
    """``[topography]``: a file, the scanned body, and the place of the tip.

    Attributes
    ----------
    own_role : str
        Scanned body of a section that belongs to one; else empty.
    seed_offset : int
        Number that is added to the seed.
    """

    title = "topography"
    own_role: ClassVar[str] = ""
    seed_offset: ClassVar[int] = 0
    file_keys = ("file",)
    word_keys = ("center",)

    file: str = ""
    role: str = ""
    unit: str | None = None
    spacing: float | str | tuple | None = None
    detrend: str | None = None
    center: str | tuple = "middle"
    margin: float | str | None = None
    periodic: bool | None = None
    channel: int | str | None = None
    transpose: bool = False
    noise: float | str | None = None
    cutoff_wavelength: float | str = 0.0
    remove_outliers: bool = False
    remove_bad_lines: bool = False
    extrude: bool = False
    seed: int | None = None

    @property
    def body(self) -> str:
        """Scanned body: the role, or the body of the section.

        Raises
        ------
        ValueError
            If the role is another body.
        """
        if self.own_role and self.role not in ("", self.own_role):
            raise ValueError(
                f'role must be "{self.own_role}" in this section, got "{self.role}": '
                "omit it"
            )
        return self.own_role or self.role

    @property
    def edge(self) -> float:
        """The margin (Å); by default zero."""
        if self.margin is None:
            return 0.0
        unit = LENGTHS.get(self.unit or "", 0.0)
        if not unit and not isinstance(self.margin, str) and self.margin:
            raise ValueError(f'give the unit of margin: margin = "{self.margin:g} nm"')
        return float(in_angstrom("margin", self.margin, unit))

    @property
    def surface(self) -> HeightMap:
        """The scan as the lower side of an indenter (Å).

        Raises
        ------
        ValueError
            If a key is missing or invalid, or the file cannot be read.
        """
        if not self.file:
            raise ValueError("give file, the name of the scan")
        if not self.body:
            roles = " or ".join(f'"{role}"' for role in ROLES)
            raise ValueError(f"give role, the body that was scanned: {roles}")
        file = Path(self.file)
        contents = digest_of_file(file) if file.is_file() else ""
        if self.seed is not None:
            return _realised(self, contents)
        surface = _read(self, contents)
        if self.center == "highest" and surface.extent == 0.0:
            raise ValueError(
                "the highest point is on the edge of the scan: is the height reversed, "
                "or the role wrong? Else give margin, its least distance from the edges"
            )
        return surface

    @property
    def summary(self) -> str:
        """Size, missing points, statistics and place of the scan as a line."""
        surface, nm = self.surface, UNITS["nm"]
        measured: Any = surface.measurement
        (n, m), size = surface.shape, _size(surface)
        name = "µm" if size.max() >= _MIN_SIZE_IN_MICROMETRES else "nm"
        width, height = size / UNITS[name]
        x, y = surface.center
        if self.body == "indenter":  # it was turned over
            x = (n - 1) * surface.spacing[0] - x
        place = "highest" if self.center == "highest" else "axis"
        pressed = surface.statistics()
        points = statistics(measured.heights, surface.spacing, periodic=False)
        missing, noise = measured.missing, measured.noise
        parts = ["a line profile, extruded along y"] if self.extrude else []
        parts += [
            f"{width:.4g} x {height:.4g} {name}",
            f"{n} x {m} points{self._order}",
            f"{missing} ({100.0 * missing / (n * m):.2g} %) missing",
            f"rms height {pressed.rms_height / nm:.3g} nm",
            f"rms slope {pressed.rms_slope:.3g} as pressed ({points.rms_slope:.3g} "
            "between measured points)",
            f"rms curvature {pressed.rms_curvature * nm:.3g} /nm "
            f"({points.rms_curvature * nm:.3g})",
            f"noise {noise.points / nm:.2g} nm, of lines {noise.lines / nm:.2g} nm",
        ]
        if measured.cutoff:
            parts.append(f"filtered below {measured.cutoff / nm:.3g} nm")
        x, y = x / UNITS[name], y / UNITS[name]
        parts.append(f"{place} at ({x:.4g}, {y:.4g}) {name}")
        if self.seed is not None:
            parts.append(f"realisation with seed {self.seed}, periodic")
        if surface.tip.is_tip:
            parts.append(f"curvature of the scan itself: radius {tip_radius(surface)}")
        return f"{Path(self.file).name}, the {self.body}: {', '.join(parts)}"

    @property
    def _order(self) -> str:
        """Which way x is, for files that do not say it themselves."""
        suffix = Path(self.file).suffix.lower()
        if suffix == ".npy":
            return f" ({'second' if self.transpose else 'first'} index along x)"
        along = "y" if self.transpose else "x"
        return f" (rows of a matrix along {along})" if suffix in TEXT else ""

    def warnings(self, radius: float, whole_tip: bool) -> list[str]:
        """Return warnings about the scan.

        Parameters
        ----------
        radius : float
            Radius of the sphere; infinity for a flat (Å).
        whole_tip : bool
            Whether the scan is the whole indenter.

        Returns
        -------
        list of str
        """
        surface, nm = self.surface, UNITS["nm"]
        measured: Any = surface.measurement
        missing, size = measured.missing / math.prod(surface.shape), max(_size(surface))
        pressed, found = surface.statistics(), []
        if missing > _MAX_MISSING_SHARE:
            found.append(
                f"{100.0 * missing:.0f} % of the points are missing and are "
                "interpolated: is a part of the scan enough, or another channel?"
            )
        if pressed.rms_height < _MIN_RMS_HEIGHT:
            found.append("all heights are the same: is it the channel of the height?")
        elif pressed.rms_height > radius and not whole_tip:
            found.append(
                f"the rms height of {pressed.rms_height / nm:.3g} nm exceeds the "
                f"radius of the sphere, {radius / nm:.3g} nm: are both units right?"
            )
        # the sides of a whole tip are steep
        elif pressed.rms_slope < _MIN_RMS_SLOPE or (
            pressed.rms_slope > _MAX_RMS_SLOPE and not whole_tip
        ):
            found.append(
                f"the rms slope is {pressed.rms_slope:.3g}, usual are "
                f"{_MIN_RMS_SLOPE:g} to {_MAX_RMS_SLOPE:g}: are the units of heights "
                "and of spacing right?"
            )
        if size > _MAX_SIZE:
            found.append(
                f"the scan is {size / UNITS['mm']:.3g} mm wide: is the unit of spacing "
                "right?"
            )
        if self.body == "indenter" and surface.tip.is_tip and not whole_tip:
            found.append(
                f"the scan itself has a radius of about {tip_radius(surface)} at its "
                "highest point, and the sphere is added to it: give radius = inf for a "
                'whole tip, or detrend = "curvature" for roughness'
            )
        found += self._doubts_about_tip(radius, whole_tip)
        found += [*measured.doubts, *self._doubts_about_noise()]
        return [f"{Path(self.file).name}: {each}" for each in found]

    def _doubts_about_tip(self, radius: float, whole_tip: bool) -> Iterator[str]:
        """Yield warnings about an indenter that may be a whole tip, or a flat."""
        surface = self.surface
        if whole_tip and surface.tip.may_be_bow:
            yield (
                f"the scan of the tip rises with a mean slope of {surface.tip.rise:.2g}"
                ", as a flat with the bow of a scanner may: if it is a flat, give "
                'detrend = "curvature"'
            )
        if (
            self.body != "indenter"
            or radius < math.inf
            or whole_tip
            or surface.periodic
        ):
            return
        if surface.tip.at_edge:
            yield (
                "no tip found, as the highest point is on the edge: the scan is taken "
                "as a periodic flat. Give margin, the least distance of a tip from the "
                "edges"
            )
        else:
            yield (
                "no tip found in the scan: it is taken as a periodic flat. Give "
                f"{self._flat_advice}the radius of the sphere for its roughness"
            )

    @property
    def _flat_advice(self) -> str:
        """Advice on a flat; empty in a section that belongs to a body."""
        return "" if self.own_role else 'role = "substrate" for a flat, or '

    def _doubts_about_noise(self) -> Iterator[str]:
        """Yield warnings about outliers, noise and edges, with keys that help."""
        surface, nm = self.surface, UNITS["nm"]
        measured: Any = surface.measurement
        noise, slope = measured.noise, surface.statistics().rms_slope
        if measured.outliers and not self.remove_outliers:
            yield (
                f"{measured.outliers} single points stick out far: if they are not "
                "real, give remove_outliers = true"
            )
        share = (measured.noise_slope / slope) ** 2 if slope else 0.0
        if share > _MAX_NOISE_SHARE:
            cause, advice = "noise makes", "a scan with less noise"
            if 2.0 * noise.lines > noise.points and self.detrend != "lines":
                advice = f'detrend = "lines", or {advice}'
            elif measured.noise_is_distinct:
                least = measured.least_wavelength
                lost = replace(measured, cutoff=least).lost_slope
                # a filter must not change more than the noise does
                if lost < 1.0 - math.sqrt(max(1.0 - share, 0.0)):
                    advice = (
                        f'cutoff_wavelength = "{least / nm:.2g} nm", which also '
                        f"removes about {100.0 * lost:.2g} % of the slope and enlarges "
                        f"areas, or {advice}"
                    )
            else:
                cause = "noise, or waves shorter than two pixels, make"
                advice = "a scan with smaller pixels"
            yield (
                f"{cause} up about {100.0 * min(share, 1.0):.0f} % of the mean square "
                f"slope, which changes areas: give {advice}"
            )
        if surface.periodic and has_edge_step(measured.heights):
            across, beside = (each / nm for each in edge_step(measured.heights))
            yield (
                f"heights differ by {across:.2g} nm from one edge to the opposite, and "
                f"only by {beside:.2g} nm from line to line: is the scan periodic?"
            )


class TipTopographyConfig(TopographyConfig):
    """``[tip.topography]``: a scan of the indenter, as in ``[topography]``."""

    title = "tip.topography"
    own_role = "indenter"


class SubstrateTopographyConfig(TopographyConfig):
    """``[substrate.topography]``: a scan of the substrate, as in ``[topography]``."""

    title = "substrate.topography"
    own_role = "substrate"
    seed_offset = SUBSTRATE_SEED


@lru_cache(maxsize=4)
def _realised(config: TopographyConfig, contents: str) -> HeightMap:
    """Return the realisation of a scan with the seed of a configuration."""
    scan = _read(replace(config, seed=None), contents)
    if scan.tip.is_tip:
        raise ValueError(
            f"the scan is a tip of radius {tip_radius(scan)}, and seed would make it a "
            'random surface: give detrend = "curvature" for its roughness, or omit seed'
        )
    seed = integer("seed", config.seed, 0)
    surface = scan.realisation(seed + config.seed_offset)
    if config.center == "highest":
        surface = surface.centered(surface.lowest_place)
    return surface


@lru_cache(maxsize=4)
def _read(config: TopographyConfig, contents: str) -> HeightMap:
    """Read a scan once for each configuration and contents of the file."""
    options = config.entries() | {"role": config.body, "margin": config.margin or 0.0}
    del options["seed"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ScanWarning)  # `TopographyConfig.warnings`
        return HeightMap.from_topography(options.pop("file"), **options)


def tip_radius(scan: HeightMap) -> str:
    """Return the radius of a scanned tip with its standard error."""
    return f"{scan.tip.radius / UNITS['nm']:.3g} nm ± {100.0 * scan.tip.error:.1f} %"


def _size(surface: HeightMap) -> FloatArray:
    return np.multiply(surface.shape, surface.spacing)
