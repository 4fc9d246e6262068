"""Figures of the stress below one state of a run."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from ase_roughcontact import plot
from ase_roughcontact._util.units import UNITS, printed_unit
from ase_roughcontact.analysis import (
    ContactMap,
    StressPlane,
    stress_field,
    stress_planes,
    stress_section,
)
from ase_roughcontact.contact.state import TRACTIONS
from ase_roughcontact.elasticity.largest_stress import (
    LargestStress,
    largest_stress,
    von_mises,
)
from ase_roughcontact.elasticity.window_images import block_means
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import legend_below, letter, style
from ase_roughcontact.scene import Scene

_NM = UNITS["nm"]
# Number of pictures at different depths.
_PICTURES = 10
# Depth of the last one, in radii of a circle of the contact area.
_RELATIVE_DEPTH = 2.0
# Resolution of these pictures (dots per inch), and largest number of their colours.
_DPI, _COLOURS = 130, 64
# Largest number of points along a side of the maps in them.
_MAX_POINTS = 512
# Size of a map relative to the contact.
_MARGIN = 1.6


@dataclass(frozen=True)
class StressView:
    """Section and depth at which stresses are shown.

    Attributes
    ----------
    along : {"x", "y"}
        Horizontal axis of the section.
    at : float, optional
        Position of the section along the other axis (Å); by default the place of the
        largest von Mises stress.
    depth : float, optional
        Depth of the map (Å); by default the depth of the largest von Mises stress.
    """

    along: Literal["x", "y"] = "x"
    at: float | None = None
    depth: float | None = None


@dataclass(frozen=True)
class DepthPicture:
    """Picture of the stress at a depth.

    Attributes
    ----------
    depth : str
        Depth with its unit.
    largest : bool
        Whether the largest stress is at this depth.
    png : bytes
        Picture in the format PNG.
    """

    depth: str
    largest: bool
    png: bytes


def draw_stress(
    scene: Scene, seen: ContactMap, title: str, file: Path, view: StressView
) -> None:
    """Draw a section through the stress, a map at a depth, and stresses on a line.

    Parameters
    ----------
    scene : Scene
        Scene with a solid that has stresses below its surface.
    seen : ContactMap
        Map of the contact.
    title : str
        Load of the contact.
    file : path
        Picture to write.
    view : StressView
        Section and depth.
    """
    largest = _largest(scene, seen)
    along_x = view.along == "x"
    at, depth = view.at, view.depth
    if at is None:
        at = seen.origin[1] + largest.y if along_x else seen.origin[0] + largest.x
    if depth is None:
        depth = largest.depth
    section = stress_section(seen, scene.solid, view.along, at)
    (plane,) = stress_planes(seen, scene.solid, [depth])
    stress = von_mises(section.stress)
    ends = largest.value, stress.max(), von_mises(plane.stress).max()
    scale = _scale(scene, max(ends))
    place = section.position[stress.max(axis=0).argmax()]
    with written(file, 5.2, width=5.6) as figure:
        panels: dict[str, Any] = figure.subplot_mosaic(
            [["section", "section"], ["map", "line"]]
        )
        upper, below, line = (panels[name] for name in ("section", "map", "line"))
        plot.plot_stress_section(upper, section, **scale)
        contours = upper.collections[0]
        across = "y" if along_x else "x"
        whole = f"{title}, section at ${across}$ = {_in_nm(at, seen)}"
        figure.suptitle(whole, fontsize="medium")
        if scene.bodies.scanned == "indenter" and along_x:
            upper.invert_xaxis()
        _draw_map(scene, below, plane, seen, scale)
        mark = below.axhline if along_x else below.axvline
        mark(at / _NM, color="white", lw=0.8, ls=":")
        upper.axhline(-depth / _NM, color="white", lw=0.8, ls=":")
        label = f"von Mises stress ({scale['unit']})"
        figure.colorbar(
            contours, ax=[upper, below], label=label, shrink=0.6, panchor=False
        )
        plot.plot_stress_over_depth(
            line, section, scale["unit"], yield_strength=scale["yield_strength"]
        )
        line.set_title(f"below ${view.along}$ = {_in_nm(place, seen)}")
        letter([upper, below, line])
        legend_below(figure, [line])


def depth_pictures(scene: Scene, seen: ContactMap) -> Iterator[DepthPicture]:
    """Yield pictures of the stress from near the surface to below the contact.

    All have the same scale. They are small, to be part of a page: maps of many points
    show the stress by the mean pressure on blocks of points.

    Parameters
    ----------
    scene, seen
        See `draw_stress`.
    """
    largest = _largest(scene, seen)
    deepest = _RELATIVE_DEPTH * math.sqrt(seen.contact_area / math.pi)
    deepest = max(deepest, 2.0 * seen.spacing)
    depths = np.geomspace(seen.spacing, deepest, _PICTURES)
    nearest = abs(np.log(depths / largest.depth)).argmin()
    depths[nearest] = largest.depth
    scale = _scale(scene, largest.value)
    coarse = _coarse(seen)
    planes = stress_planes(coarse, scene.solid, depths)
    for number, plane in enumerate(planes):
        with style():
            figure = Figure(figsize=(3.4, 2.8))
            figure.set_layout_engine("none")  # axes have one place in all pictures
            axes = figure.subplots()
            image = _draw_map(scene, axes, plane, coarse, scale)
            figure.colorbar(image, label=f"von Mises stress ({scale['unit']})")
            png = _small_png(figure)
        depth = f"{plane.depth / _NM:.3g} nm"
        yield DepthPicture(depth, number == nearest, png)


def _largest(scene: Scene, seen: ContactMap) -> LargestStress:
    """Return the largest von Mises stress, in single precision."""
    return largest_stress(stress_field(seen, scene.solid, dtype=np.float32))


def _coarse(seen: ContactMap) -> ContactMap:
    """Return the map of blocks of points, with at most `_MAX_POINTS` along a side.

    A periodic map consists of whole blocks, or stays as it is.
    """
    block = -(-max(seen.pressure.shape) // _MAX_POINTS)
    if seen.periodic:
        common = math.gcd(*seen.pressure.shape)
        sizes = range(block, common + 1)
        block = next((size for size in sizes if common % size == 0), 1)
    if block == 1:
        return seen
    shift = 0.5 * (block - 1) * seen.spacing
    tractions = {name: seen.lateral[name] for name in TRACTIONS if name in seen.lateral}
    return ContactMap(
        pressure=block_means(seen.pressure, block),
        contact=block_means(seen.contact, block) >= 0.5,
        spacing=block * seen.spacing,
        origin=(seen.origin[0] + shift, seen.origin[1] + shift),
        periodic=seen.periodic,
        lateral={name: block_means(each, block) for name, each in tractions.items()},
    )


def _scale(scene: Scene, largest: float) -> dict[str, Any]:
    """Return unit, yield strength and end of the scale for functions of figures."""
    unit = printed_unit("eV/Å^3", scene.contact_modulus)
    strength = scene.bodies.yield_strength
    return {
        "unit": unit,
        "yield_strength": None if math.isnan(strength) else strength,
        "largest": largest / UNITS[unit],
    }


def _draw_map(
    scene: Scene,
    axes: Any,
    plane: StressPlane,
    seen: ContactMap,
    scale: dict[str, Any],
) -> Any:
    """Draw the stress at a depth around the contact; return the image."""
    image = plot.plot_stress_map(axes, plane, seen, **scale).images[0]
    i, j = seen.contact.nonzero()
    if i.size and not scene.is_flat:
        ends = np.array([(c.min(), c.max()) for c in (seen.x[i], seen.y[j])]) / _NM
        half = 0.5 * _MARGIN * (np.ptp(ends, axis=1).max() + seen.spacing / _NM)
        middle = ends.mean(axis=1)
        left, right, bottom, top = image.get_extent()
        axes.set_xlim(max(middle[0] - half, left), min(middle[0] + half, right))
        axes.set_ylim(max(middle[1] - half, bottom), min(middle[1] + half, top))
    plot.show_as_scanned(axes, scene.bodies.scanned)
    return image


def _in_nm(position: float, seen: ContactMap) -> str:
    """Return a position as mathematical text, without rounding errors of zero."""
    rounded = round(position / seen.spacing, 2) * seen.spacing / _NM + 0.0  # no -0
    return f"${rounded:.3g}$ nm"


def _small_png(figure: Figure) -> bytes:
    """Return a figure as a picture of few colours."""
    drawn, small = io.BytesIO(), io.BytesIO()
    figure.savefig(drawn, dpi=_DPI)
    picture = Image.open(drawn).convert("RGB").quantize(_COLOURS)
    picture.save(small, "PNG", optimize=True)
    return small.getvalue()
