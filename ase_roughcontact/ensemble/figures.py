"""Figure of a study: means over a parameter, with standard errors and scatter."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.ensemble.means import MeanValue
from ase_roughcontact.ensemble.study import (
    StudyPoint,
    numeric_values,
    parameter_label,
)
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import COLOURS, legend_below

# Ratio of the largest to the smallest value above which an axis is logarithmic.
_LOGARITHMIC = 9.0
# Largest number of lines of a path with several targets.
_MAX_LINES = 6
# Least number of realisations with a bar: of two, Student's factor is 6.5.
_MIN_BAR = 3


def plot_study(
    axes: Any,
    points: Sequence[StudyPoint],
    over: str,
    unit: str,
    targets: Mapping[float, str] | None = None,
) -> Any:
    """Plot the means of a study over a parameter.

    Bars are standard errors of the means, from three realisations on; bands are the
    standard deviation of one realisation, dashed lines theory. There is a line for each
    combination of the other parameters, and for some of the targets of a path.

    Parameters
    ----------
    axes : matplotlib Axes
    points : sequence of StudyPoint
        Points of one column.
    over : str
        Key of the parameter.
    unit : str
        Unit in which means are drawn.
    targets : mapping of float to str, optional
        Labels of the targets.

    Returns
    -------
    matplotlib Axes
    """
    lines = _lines(points, over)
    theories = dict.fromkeys(p.theory_name for p in points if p.theory_name)
    with_bars = "mean"
    if any(p.mean.realisations >= _MIN_BAR for p in points):
        with_bars = "mean, with standard error"
    for number, (names, members) in enumerate(lines.items()):
        colour = COLOURS[number % len(COLOURS)]
        given = [point.values[over] for point in members]
        numbers, x_unit = numeric_values(over, given)
        order = np.argsort(numbers)
        columns = [
            (p.mean.mean, _bar(p.mean), p.mean.scatter, p.theory) for p in members
        ]
        mean, error, scatter, theory = (np.array(columns).T / UNITS[unit])[:, order]
        x = np.array(numbers)[order]
        label = _label(names, members, targets or {}) or with_bars
        band = {"color": colour, "alpha": 0.2, "lw": 0}
        scatters = "" if number else "scatter of realisations"
        axes.fill_between(x, mean - scatter, mean + scatter, label=scatters, **band)
        axes.errorbar(
            x,
            mean,
            error,
            fmt=".-",
            color=colour,
            capsize=2,
            label=label,
        )
        if np.isfinite(theory).any():
            axes.plot(x, theory, "--", color=colour, lw=0.8)
        if x.min() > 0.0 and x.max() > _LOGARITHMIC * x.min():
            axes.set_xscale("log")
            axes.set_xticks(x, [f"{value:g}" for value in x])
            axes.minorticks_off()
    for name in theories:
        axes.plot([], [], "--", color="0.3", lw=0.8, label=name)
    label = parameter_label(over)
    axes.set_xlabel(f"{label} ({x_unit})" if x_unit else label)
    return axes


def draw_study(
    file: Path,
    panels: Mapping[str, Sequence[StudyPoint]],
    over: str,
    units: Mapping[str, str],
    targets: Mapping[float, str] | None = None,
) -> None:
    """Write the figure of a study, with a panel for each column.

    Parameters
    ----------
    file : path
    panels : mapping of str to sequence of StudyPoint
        Points by the label of the vertical axis.
    over, targets
        See `plot_study`.
    units : mapping of str to str
        Units in which means are drawn, by the same labels.
    """
    with written(file, 2.2 * len(panels) + 0.8, width=4.5) as figure:
        drawn = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (label, points) in zip(drawn, panels.items(), strict=True):
            plot_study(axes, points, over, units[label], targets)
            axes.set_ylabel(label)
            axes.label_outer()
        legend_below(figure, list(drawn))


def _bar(mean: MeanValue) -> float:
    """Return the standard error of a mean; NaN for too few realisations."""
    if mean.realisations < _MIN_BAR:
        return math.nan
    return abs(mean.mean) * mean.error


def _lines(
    points: Sequence[StudyPoint], over: str
) -> dict[tuple[Any, ...], list[StudyPoint]]:
    """Return the points of each line, by the other parameters and the target.

    Points of a line have the same number among the targets of their paths: the targets
    themselves may change with the parameter.
    """
    numbers = _target_numbers(points)
    shown = range(max(numbers) + 1)
    if len(shown) > _MAX_LINES:
        places = np.linspace(0, len(shown) - 1, _MAX_LINES).round().astype(int)
        shown = places.tolist()
    keys = [key for key in points[0].values if key != over]
    varied = [key for key in keys if not _follows(points, key, over)]
    lines: dict[tuple[Any, ...], list[StudyPoint]] = {}
    for point, number in zip(points, numbers, strict=True):
        if number not in shown:
            continue
        names = tuple(f"{parameter_label(k)} = {point.values[k]}" for k in varied)
        target = number if len(shown) > 1 else None
        lines.setdefault((*names, target), []).append(point)
    return lines


def _follows(points: Sequence[StudyPoint], key: str, over: str) -> bool:
    """Return whether a key has one value at each value of the parameter."""
    found: dict[str, Any] = {}
    for point in points:
        first = found.setdefault(str(point.values[over]), point.values[key])
        if point.values[key] != first:
            return False
    return True


def _target_numbers(points: Sequence[StudyPoint]) -> list[int]:
    """Return the number of each point among the targets of its path, from zero."""
    counts: Counter[str] = Counter()
    numbers = []
    for point in points:
        path = str(point.values)
        numbers.append(counts[path])
        counts[path] += 1
    return numbers


def _label(
    names: tuple[Any, ...], members: Sequence[StudyPoint], texts: Mapping[float, str]
) -> str:
    """Return the parameters of a line, and its target or, if it changes, its number."""
    *values, number = names
    if number is not None:
        target = members[0].mean.target
        if all(point.mean.target == target for point in members):
            values.append(texts.get(target, f"{target:.4g}"))
        else:
            values.append(f"target {number + 1}")
    return ", ".join(values)
