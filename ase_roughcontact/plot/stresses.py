"""Figures of the stress below a contact."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import BoundaryNorm
from matplotlib.ticker import MaxNLocator

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.analysis import ContactMap, StressPlane, StressSection
from ase_roughcontact.elasticity.largest_stress import tension, tresca, von_mises
from ase_roughcontact.plot.style import BLUE, GREY, ORANGE
from ase_roughcontact.plot.surfaces import pixels_of

NM = UNITS["nm"]
# Largest number of contours from zero to the largest stress.
_CONTOURS = 12
# Height of the pressure above the surface, over the depth of the section.
_PRESSURE_HEIGHT = 0.35


def plot_stress_section(
    axes: Any,
    section: StressSection,
    unit: str = "GPa",
    yield_strength: float | None = None,
    largest: float | None = None,
) -> Any:
    """Draw contours of the von Mises stress on a section, and the pressure above it.

    A cross marks the largest stress of the section, and the largest pressure is written
    beside the pressure, which has another scale.

    Parameters
    ----------
    axes : matplotlib Axes
    section : StressSection
        Section through a contact, see `stress_section`.
    unit : str
        Unit of the stress.
    yield_strength : float, optional
        Yield strength, which is drawn as a dashed line (eV/Å^3).
    largest : float, optional
        Stress at the end of the colour scale (`unit`); by default the largest one.

    Returns
    -------
    matplotlib Axes
        The filled contours, for a colour bar, are ``axes.collections[0]``.
    """
    stress = von_mises(section.stress) / UNITS[unit]
    position, depth = section.position / NM, section.depth / NM
    levels = stress_levels(largest or stress.max())
    axes.contourf(position, -depth, stress, levels, cmap="viridis")
    _draw_limit(axes, position, -depth, stress, yield_strength, unit)
    row, column = np.unravel_index(stress.argmax(), stress.shape)
    cross = {"mfc": "white", "mec": "black", "ms": 7, "mew": 0.8}
    axes.plot(position[column], -depth[row], "X", **cross)
    height = _PRESSURE_HEIGHT * depth[-1]
    pressure = np.maximum(section.pressure, 0.0)
    scaled = height * pressure / (pressure.max() or 1.0)
    axes.fill_between(position, 0.0, scaled, color=GREY, lw=0.0)
    axes.axhline(0.0, color="black", lw=0.8)
    axes.set(xlabel=f"${section.along}$ (nm)", ylabel="$z$ (nm)")
    axes.set_ylim(-depth[-1], 1.5 * height)
    pressed = np.flatnonzero(pressure)
    if pressed.size:
        middle = 0.5 * (position[pressed[0]] + position[pressed[-1]])
        half = 0.5 * (position[pressed[-1]] - position[pressed[0]]) + depth[-1]
        left, right = position[0], position[-1]
        axes.set_xlim(max(middle - half, left), min(middle + half, right))
    if pressed.size:
        text = f"$p$ = {pressure.max() / UNITS[unit]:.3g} {unit}"
        place = position[pressure.argmax()], height
        axes.annotate(text, place, (0, 1), textcoords="offset points", ha="center")
    # no ticks beside the pressure, which has a scale of its own
    axes.set_yticks([tick for tick in axes.get_yticks() if -depth[-1] <= tick <= 0.0])
    axes.set_aspect("equal")
    return axes


def plot_stress_map(
    axes: Any,
    plane: StressPlane,
    contact_map: ContactMap,
    unit: str = "GPa",
    yield_strength: float | None = None,
    largest: float | None = None,
) -> Any:
    """Draw the von Mises stress at a depth, and the outline of the contact above.

    Parameters
    ----------
    axes : matplotlib Axes
    plane : StressPlane
        Stress at a depth, see `stress_planes`.
    contact_map : ContactMap
        Map of the contact.
    unit, yield_strength, largest
        See `plot_stress_section`.

    Returns
    -------
    matplotlib Axes
        The image of the stress, for a colour bar, is ``axes.images[0]``.
    """
    stress = von_mises(plane.stress) / UNITS[unit]
    levels = stress_levels(largest or stress.max())
    colours = BoundaryNorm(levels, colormaps["viridis"].N)
    axes.imshow(stress.T, cmap="viridis", norm=colours, **pixels_of(contact_map))
    x, y = contact_map.x / NM, contact_map.y / NM
    if contact_map.contact.any() and not contact_map.contact.all():
        outline = {"levels": [0.5], "colors": "white", "linewidths": 0.8}
        axes.contour(x, y, contact_map.contact.T.astype(float), **outline)
    _draw_limit(axes, x, y, stress.T, yield_strength, unit)
    axes.set(xlabel="$x$ (nm)", ylabel="$y$ (nm)")
    axes.set_title(f"depth {plane.depth / NM:.3g} nm")
    return axes


def stress_levels(largest: float) -> Sequence[float]:
    """Return round stresses from zero to at least the largest one, for contours."""
    return MaxNLocator(_CONTOURS).tick_values(0.0, largest or 1.0)


def _draw_limit(
    axes: Any,
    x: np.ndarray,
    y: np.ndarray,
    stress: np.ndarray,
    yield_strength: float | None,
    unit: str,
) -> None:
    """Draw the yield strength as a dashed line, where the stress reaches it."""
    if yield_strength is None:
        return
    limit = yield_strength / UNITS[unit]
    if stress.min() < limit < stress.max():
        axes.contour(x, y, stress, levels=[limit], colors="white", linestyles="dashed")


def plot_stress_over_depth(
    axes: Any,
    section: StressSection,
    unit: str = "GPa",
    position: float | None = None,
    yield_strength: float | None = None,
) -> Any:
    """Plot stresses on a vertical line of a section against the depth.

    Parameters
    ----------
    axes : matplotlib Axes
    section : StressSection
        Section through a contact, see `stress_section`.
    unit : str
        Unit of the stress.
    position : float, optional
        Position of the line along the section (Å); by default the position of the
        largest von Mises stress of the section.
    yield_strength : float, optional
        Yield strength, which is drawn as a line (eV/Å^3).

    Returns
    -------
    matplotlib Axes
    """
    column = int(von_mises(section.stress).max(axis=0).argmax())
    if position is not None:
        column = int(abs(section.position - position).argmin())
    stress, depth = section.stress[:, :, column] / UNITS[unit], section.depth / NM
    axes.plot(von_mises(stress), depth, color=BLUE, label="von Mises")
    axes.plot(tresca(stress), depth, "--", color=ORANGE, label="Tresca")
    axes.plot(tension(stress), depth, ":", color="black", label="largest principal")
    axes.plot(-stress[2], depth, "-.", color=GREY, label=r"$-\sigma_{zz}$")
    if yield_strength is not None:
        limit = yield_strength / UNITS[unit]
        axes.axvline(limit, color="black", ls="--", lw=0.8, label="yield strength")
    axes.set_ylim(depth[-1], 0.0)
    axes.set(xlabel=f"stress ({unit})", ylabel="depth (nm)")
    below = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.2)}
    axes.legend(frameon=False, ncols=2, **below)  # curves are everywhere in the axes
    return axes
