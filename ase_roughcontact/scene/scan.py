"""The section ``[topography]`` of a scene file: a scan as the roughness."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from ase_roughcontact._util.units import LENGTHS
from ase_roughcontact.scene.section import Section
from ase_roughcontact.topography import HeightMap
from ase_roughcontact.topography.scan import ROLES, in_angstrom


@dataclass(frozen=True)
class TopographyConfig(Section):
    """``[topography]``: a file, the scanned body, and the place of the tip."""

    title = "topography"
    file_keys = ("file",)

    file: str = ""
    role: str = ""
    unit: str | None = None
    spacing: float | str | tuple | None = None
    detrend: str | None = None
    center: str | tuple = "middle"
    margin: float | str = 0.0
    periodic: bool | None = None
    channel: int | str | None = None

    @property
    def edge(self) -> float:
        """The margin (Å)."""
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
        if not self.role:
            known = " or ".join(f'"{role}"' for role in ROLES)
            raise ValueError(f"give role, the body that was scanned: {known}")
        try:
            changed = Path(self.file).stat().st_mtime_ns
        except OSError as error:
            message = f"cannot read a scan from {self.file!r}: {error}"
            raise ValueError(message) from error
        surface = _read(self, changed)
        if self.center == "highest" and surface.extent == 0.0:
            raise ValueError(
                "the highest point is on the edge of the scan: is the height reversed, "
                "or the role wrong? Else give a margin, the distance from the edges at "
                "which the highest point is sought"
            )
        return surface


@lru_cache(maxsize=4)
def _read(config: TopographyConfig, changed: int) -> HeightMap:
    """Read a scan, unless it was read before and the file has not changed."""
    options = config.entries()
    return HeightMap.from_topography(options.pop("file"), **options)
