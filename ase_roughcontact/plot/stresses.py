"""Figures of the stress below a contact."""

from __future__ import annotations

from typing import Any

import numpy as np
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
) -> Any:
    """Draw contours of the von Mises stress on a section, and the pressure above it.

    A cross marks the largest stress of the section.

    Parameters
    ----------
    axes : matplotlib Axes
    section : StressSection
        Section through a contact, see `stress_section`.
    unit : str
        Unit of the stress.
    yield_strength : float, optional
        Yield strength, which is drawn as a dashed line (eV/Å^3).

    Returns
    -------
    matplotlib contour set
        The filled contours, for a colour bar.
    """
    stress = von_mises(section.stress) / UNITS[unit]
    position, depth = section.position / NM, section.depth / NM
    levels = MaxNLocator(_CONTOURS).tick_values(0.0, stress.max() or 1.0)
    filled = axes.contourf(position, -depth, stress, levels, cmap="viridis")
    if yield_strength is not None:
        limit = yield_strength / UNITS[unit]
        line = {"levels": [limit], "colors": "white", "linestyles": "dashed"}
        if stress.min() < limit < stress.max():
            axes.contour(position, -depth, stress, **line)
    row, column = np.unravel_index(stress.argmax(), stress.shape)
    axes.plot(position[column], -depth[row], "wx", ms=6, mew=1.5)
    height = _PRESSURE_HEIGHT * depth[-1]
    pressure = np.maximum(section.pressure, 0.0)
    scaled = height * pressure / (pressure.max() or 1.0)
    axes.fill_between(position, 0.0, scaled, color=GREY, lw=0.0)
    axes.axhline(0.0, color="black", lw=0.8)
    axes.set(xlabel=f"${section.along}$ (nm)", ylabel="$z$ (nm)")
    axes.set_ylim(-depth[-1], 1.2 * height)
    pressed = np.flatnonzero(pressure)
    if pressed.size:
        middle = 0.5 * (position[pressed[0]] + position[pressed[-1]])
        half = 0.5 * (position[pressed[-1]] - position[pressed[0]]) + depth[-1]
        left, right = position[0], position[-1]
        axes.set_xlim(max(middle - half, left), min(middle + half, right))
    # no ticks beside the pressure, which has a scale of its own
    axes.set_yticks([tick for tick in axes.get_yticks() if -depth[-1] <= tick <= 0.0])
    axes.set_aspect("equal")
    return filled


def plot_stress_map(
    axes: Any, plane: StressPlane, contact_map: ContactMap, unit: str = "GPa"
) -> Any:
    """Draw the von Mises stress at a depth, and the outline of the contact above.

    Parameters
    ----------
    axes : matplotlib Axes
    plane : StressPlane
        Stress at a depth, see `stress_planes`.
    contact_map : ContactMap
        Map of the contact.
    unit : str
        Unit of the stress.

    Returns
    -------
    matplotlib image
        Image of the stress, for a colour bar.
    """
    stress = von_mises(plane.stress) / UNITS[unit]
    image = axes.imshow(stress.T, cmap="viridis", vmin=0.0, **pixels_of(contact_map))
    if contact_map.contact.any() and not contact_map.contact.all():
        x, y = contact_map.x / NM, contact_map.y / NM
        outline = {"levels": [0.5], "colors": "white", "linewidths": 0.8}
        axes.contour(x, y, contact_map.contact.T.astype(float), **outline)
    axes.set(xlabel="$x$ (nm)", ylabel="$y$ (nm)")
    axes.set_title(f"depth {plane.depth / NM:.3g} nm")
    return image


def plot_stress_over_depth(
    axes: Any, section: StressSection, unit: str = "GPa", position: float | None = None
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
    axes.set_ylim(depth[-1], 0.0)
    axes.set(xlabel=f"stress ({unit})", ylabel="depth (nm)")
    below = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.2)}
    axes.legend(frameon=False, ncols=2, **below)  # curves are everywhere in the axes
    return axes
