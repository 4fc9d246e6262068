"""Figures of paths in time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import (
    BLUE,
    COLOURS,
    GREY,
    LINES,
    ORANGE,
    add_arrow,
    legend_below,
    letter,
    limit_to,
)

_NN, _NM = UNITS["nN"], UNITS["nm"]
# Units and labels of the columns that are drawn.
_COLUMNS = {
    "time": (1.0, "time (s)"),
    "penetration": (_NM, "penetration (nm)"),
    "base": (_NM, "distance of the base $D$ (nm)"),
    "normal_force": (_NN, "normal force $N$ (nN)"),
    "contact_area": (_NM**2, "contact area (nm$^2$)"),
    "continuum_area": (_NM**2, "contact area (nm$^2$)"),
}
# Colours of the branches.
_COLOURS = {
    "approach": BLUE,
    "dwell": COLOURS[2],
    "retraction": ORANGE,
    "oscillation": COLOURS[3],
}
# Margin of axes beside the states in which a force acts, relative to their range.
_MARGIN = 0.12


def plot_over_time(
    axes: Any,
    steps: Sequence[Any],
    column: str = "normal_force",
    branches: Sequence[str] = (),
    theory: Mapping[str, ArrayLike] | None = None,
) -> Any:
    """Plot a column of a path in time over the time.

    Parameters
    ----------
    axes : matplotlib Axes
    steps : sequence of TimeStep
    column : {"normal_force", "contact_area", "continuum_area"}
        Name of the column.
    branches : sequence of str, optional
        Name of the branch at each step, "approach", "dwell", "retraction" or
        "oscillation"; it sets the colour and the label of a line.
    theory : mapping of str to array_like, optional
        Values of the column by theories at each step (eV/Å or Å^2), by label.

    Returns
    -------
    matplotlib Axes
    """
    _plot_branches(axes, steps, ("time", column), branches)
    times, (unit, _) = [step.time for step in steps], _COLUMNS[column]
    for i, (label, values) in enumerate((theory or {}).items()):
        drawn = np.asarray(values) / unit
        axes.plot(times, drawn, f"k{LINES[i % 4]}", lw=0.8, label=label, zorder=0)
    return axes


def plot_over_depth(
    axes: Any,
    steps: Sequence[Any],
    column: str = "normal_force",
    branches: Sequence[str] = (),
    theory: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    along: str = "penetration",
) -> Any:
    """Plot a column of a path in time over the penetration, with arrows along the path.

    The axes are limited to the states in which a force acts.

    Parameters
    ----------
    axes : matplotlib Axes
    steps, column, branches
        See `plot_over_time`.
    theory : mapping of str to (array_like, array_like), optional
        Penetrations (Å) and values of the column (eV/Å or Å^2) of theories, by label.
    along : {"penetration", "base"}
        Column along the other axis.

    Returns
    -------
    matplotlib Axes
    """
    x, y = _plot_branches(axes, steps, (along, column), branches, arrows=True)
    limit_to(axes, x, y, _MARGIN)
    unit, _ = _COLUMNS[column]
    for i, (label, (depth, values)) in enumerate((theory or {}).items()):
        line = np.asarray(depth) / _NM, np.asarray(values) / unit
        axes.plot(*line, f"k{LINES[i % 4]}", lw=0.8, label=label, zorder=0)
    return axes


def draw_time_path(
    file: Path,
    steps: Sequence[Any],
    branches: Sequence[str] = (),
    theory: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    areas_over_depth: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    areas_over_time: Mapping[str, ArrayLike] | None = None,
) -> None:
    """Write the figure of a path in time: force and area over time, and over depth.

    Parameters
    ----------
    file : path
    steps, branches
        See `plot_over_depth`.
    theory, areas_over_depth : mapping of str to (array_like, array_like), optional
        Penetrations (Å) with forces (eV/Å), and with areas (Å^2), of theories by label.
    areas_over_time : mapping of str to array_like, optional
        Areas of theories at each step (Å^2), by label.
    """
    area = steps[0].area_column
    with written(file, 4.6, width=6.0) as figure:
        panels = figure.subplots(2, 2, sharex="col", sharey="row")
        plot_over_depth(panels[0, 1], steps, "normal_force", branches, theory)
        plot_over_depth(panels[1, 1], steps, area, branches, areas_over_depth)
        plot_over_time(panels[0, 0], steps, "normal_force", branches)
        plot_over_time(panels[1, 0], steps, area, branches, areas_over_time)
        for panel in panels.flat:
            panel.label_outer()
        letter(list(panels.flat))
        legend_below(figure, list(panels.flat))


def draw_cantilever_path(
    file: Path, steps: Sequence[Any], branches: Sequence[str]
) -> None:
    """Write the figure of the force of a cantilever over the distance of its base.

    Parameters
    ----------
    file : path
    steps, branches
        See `plot_over_depth`.
    """
    with written(file, 2.8) as figure:
        axes = figure.subplots()
        plot_over_depth(axes, steps, branches=branches, along="base")
        legend_below(figure, [axes])


def _plot_branches(
    axes: Any,
    steps: Sequence[Any],
    columns: tuple[str, str],
    branches: Sequence[str],
    arrows: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """Plot one column over another; return the points at which a force acts."""
    (x_unit, x_label), (y_unit, y_label) = (_COLUMNS[name] for name in columns)
    x = np.array([getattr(step, columns[0]) for step in steps]) / x_unit
    y = np.array([getattr(step, columns[1]) for step in steps]) / y_unit
    acts = np.array([step.normal_force != 0.0 for step in steps])
    axes.axhline(0.0, color=GREY, lw=0.6)
    for branch, part in _runs(branches or [""] * len(steps)):
        colour = _COLOURS.get(branch, BLUE)
        axes.plot(x[part], y[part], "-", color=colour, label=branch or None)
        inside = acts[part]
        if arrows and branch in ("approach", "retraction") and inside.any():
            add_arrow(axes, x[part][inside], y[part][inside], colour)
    axes.set(xlabel=x_label, ylabel=y_label)
    if not acts.any():
        return x, y
    acts[1:] |= acts[:-1]  # with the state after a jump
    return x[acts], y[acts]


def _runs(branches: Sequence[str]) -> Iterator[tuple[str, slice]]:
    """Yield the branches, each with its steps and the last step of the one before."""
    begin = 0
    for branch, members in groupby(branches):
        end = begin + len(list(members))
        yield branch, slice(max(begin - 1, 0), end)
        begin = end
