"""Roughness of tip and substrate of a scene, and the periodic cell of a flat."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ase_roughcontact._util.rounding import RATIO_ROUNDING
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import Shape
from ase_roughcontact.scene.file import SceneFile
from ase_roughcontact.scene.random_fields import RoughnessConfig
from ase_roughcontact.scene.scan import TopographyConfig
from ase_roughcontact.scene.section import Problems
from ase_roughcontact.topography import CompositeRoughness, HeightMap, Inverted
from ase_roughcontact.topography.square_grid import SquareGrid

# Sections of the roughness of one body, which can't be given together.
_ALTERNATIVES = [
    ("roughness", "topography"),
    ("tip.roughness", "tip.topography"),
    ("substrate.roughness", "substrate.topography"),
]


@dataclass(frozen=True, eq=False)
class RoughBody:
    """Roughness of one body as the lower side of an indenter.

    Attributes
    ----------
    section : RoughnessConfig or TopographyConfig
        Section that describes it.
    surface : Topography
        Heights (Å).
    """

    section: RoughnessConfig | TopographyConfig
    surface: Any

    @property
    def is_scan(self) -> bool:
        """Whether the roughness is a scan."""
        return isinstance(self.surface, HeightMap)

    def with_period(self, side: float) -> RoughBody:
        """Return the body with another period (Å).

        Raises
        ------
        ValueError
            If another period is given, or the roughness has no free one.
        """
        surface = self.surface
        if math.isclose(surface.side, side, rel_tol=RATIO_ROUNDING):
            return self
        inner = surface.surface if isinstance(surface, Inverted) else surface
        domain = getattr(self.section, "domain", None)
        if domain is not None or not hasattr(inner, "domain"):
            nm = UNITS["nm"]
            raise ValueError(
                f"domain is {surface.side / nm:.6g} nm, and the periodic cell of both "
                f"bodies {side / nm:.6g} nm: omit it, or give both the same"
            )
        inner = replace(inner, domain=side)
        changed = Inverted(inner) if isinstance(surface, Inverted) else inner
        return replace(self, surface=changed)


def rough_bodies(scene: SceneFile, spacing: float) -> list[RoughBody]:
    """Return the roughness of the bodies that are rough, the tip first.

    Parameters
    ----------
    scene : SceneFile
    spacing : float
        Atomic spacing a0 (Å).

    Raises
    ------
    ValueError
        If sections contradict each other, or a value is not valid: with all errors.
    """
    problems, found = Problems(), []
    sections: dict[str, Any] = {**scene.roughnesses, **scene.scans}
    for title, other in _ALTERNATIVES:
        with problems.of(title):
            if title in sections and other in sections:
                raise ValueError(f"give [{title}] or [{other}], not both")
    of_bodies = [title for title in sections if "." in title]
    for title in ("roughness", "topography"):
        with problems.of(title):
            if title in sections and of_bodies:
                raise ValueError(
                    f"beside [{'], ['.join(of_bodies)}] give [tip.{title}] or "
                    f"[substrate.{title}]"
                )
    problems.check()
    for title, section in sorted(sections.items(), reverse=True):
        with problems.of(title):
            if isinstance(section, TopographyConfig):
                found.append(RoughBody(section, section.surface))
            else:
                found.append(RoughBody(section, section.surface(spacing)))
    problems.check()
    return found


def combined(bodies: Sequence[RoughBody]) -> Any:
    """Return the sum of the roughness of all bodies; None if all are smooth."""
    surfaces = [body.surface for body in bodies]
    if len(surfaces) < 2:
        return surfaces[0] if surfaces else None
    return CompositeRoughness(surfaces)


def flat_cell(
    bodies: Sequence[RoughBody], spacing: float, given: Shape | None
) -> tuple[float, Shape, list[RoughBody]]:
    """Return grid spacing (Å), shape and roughness of the periodic cell of a flat.

    The grid of a scan consists of its pixels, or of squares about as large as the
    smaller side of a pixel. The cell is the scan, made periodic, with its middle on the
    axis. Of two scans that differ in size or pixels the common middle part is sampled
    with the smaller pixels. Random roughness has the period of the cell, or, without a
    scan, all bodies have the longest of their periods.

    Parameters
    ----------
    bodies : sequence of RoughBody
    spacing : float
        Atomic spacing a0 (Å).
    given : (int, int) or None
        Number of points along x and y; None for the whole cell.

    Raises
    ------
    ValueError
        If the cell is smaller than the given shape, or a random roughness can't have
        its period.
    """
    scans = [body for body in bodies if body.is_scan]
    others = [body for body in bodies if not body.is_scan]
    if scans:
        (n, m), spacing, scans = _scans_on_cell(scans)
        side = max(n, m) * spacing
    else:
        side = max(body.surface.side for body in bodies)
        n = m = round(side / spacing)
    problems = Problems()
    for number, body in enumerate(others):
        with problems.of(body.section.title):
            others[number] = body.with_period(side)
    problems.check()
    shape = given or (n, m)
    if shape[0] > n or shape[1] > m:
        raise ValueError(
            f"shape must be at most {n} x {m}, the points of the flat, got "
            f"{shape[0]} x {shape[1]}: leave it out"
        )
    by_title = {body.section.title: body for body in (*scans, *others)}
    return spacing, shape, [by_title[body.section.title] for body in bodies]


def _scans_on_cell(
    scans: Sequence[RoughBody],
) -> tuple[Shape, float, list[RoughBody]]:
    """Return shape and spacing (Å) of the cell of scans, and the scans on it."""
    maps = [body.surface for body in scans]
    grids = [SquareGrid.of(each.shape, each.spacing) for each in maps]
    first = grids[0]
    if all(
        (each.shape, each.spacing) == (maps[0].shape, maps[0].spacing) for each in maps
    ):
        shape, spacing = first.shape, first.spacing
        periodic = [each.made_periodic(first.strain) for each in maps]
    else:
        spacing = min(grid.spacing for grid in grids)
        x, y = (_half_points(maps, axis, spacing) for axis in (0, 1))
        shape, corner = (2 * x, 2 * y), (-x * spacing, -y * spacing)
        periodic = []
        for each in maps:
            heights = _from_middle(each).heights(shape, spacing, corner)
            periodic.append(HeightMap(heights, spacing).made_periodic())
    placed = zip(scans, periodic, strict=True)
    return shape, spacing, [replace(body, surface=each) for body, each in placed]


def _half_points(maps: Sequence[HeightMap], axis: int, spacing: float) -> int:
    """Return the number of points from the middle to the nearest edge of all maps."""
    halves = [(each.shape[axis] - 1) // 2 * each.spacing[axis] for each in maps]
    return int(np.floor(min(halves) / spacing + RATIO_ROUNDING))


def _from_middle(scan: HeightMap) -> HeightMap:
    """Return a scan with its middle on the axis."""
    x, y = (n // 2 * step for n, step in zip(scan.shape, scan.spacing, strict=True))
    return scan.centered((x, y))
