"""Figures of paths in time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import BLUE, GREY, ORANGE, letter

_NN, _NM = UNITS["nN"], UNITS["nm"]


def plot_over_time(axes: Any, steps: Sequence[Any]) -> Any:
    """Plot force and contact area of a path in time.

    Parameters
    ----------
    axes : matplotlib Axes
    steps : sequence of TimeStep

    Returns
    -------
    matplotlib Axes
        The area has an axis on the right.
    """
    times = [step.time for step in steps]
    axes.axhline(0.0, color=GREY, lw=0.8)
    forces = [step.normal_force / _NN for step in steps]
    axes.plot(times, forces, "-", color=BLUE)
    areas = [step.contact_area / _NM**2 for step in steps]
    right = axes.twinx()
    right.plot(times, areas, "--", color=ORANGE)
    right.set_ylabel("contact area (nm$^2$), dashed", color=ORANGE)
    right.set_ylim(bottom=0.0)
    axes.set_xlabel("time (s)")
    axes.set_ylabel("normal force (nN)", color=BLUE)
    return axes


def plot_over_depth(axes: Any, steps: Sequence[Any]) -> Any:
    """Plot the force of a path in time over the penetration.

    Parameters
    ----------
    axes : matplotlib Axes
    steps : sequence of TimeStep

    Returns
    -------
    matplotlib Axes
    """
    axes.axhline(0.0, color=GREY, lw=0.8)
    depths = [step.penetration / _NM for step in steps]
    axes.plot(depths, [step.normal_force / _NN for step in steps], ".-", color=BLUE)
    axes.set(xlabel="penetration (nm)", ylabel="normal force (nN)")
    return axes


def draw_time_path(file: Path, steps: Sequence[Any]) -> None:
    """Write the figure of a path in time: over time, and over depth.

    Parameters
    ----------
    file : path
    steps : sequence of TimeStep
    """
    with written(file, 5.2) as figure:
        panels = upper, lower = figure.subplots(2, 1)
        plot_over_time(upper, steps)
        plot_over_depth(lower, steps)
        letter(panels)
