"""Figures of sliding paths in time: friction and slip rate over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.analysis.path_values import friction_coefficients
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import BLUE, ORANGE, letter

# Smallest slip rate that is drawn, relative to the largest one.
_MIN_RELATIVE_RATE = 1e-12


def plot_friction_over_time(
    axes: Any, steps: Sequence[Any], color: str = BLUE, label: str | None = None
) -> Any:
    """Plot the ratio of lateral and normal force over the time.

    Parameters
    ----------
    axes : matplotlib Axes
    steps : sequence of TimedSlidingStep
    color, label : str
        Colour and label of the line.

    Returns
    -------
    matplotlib Axes
    """
    times = [step.time for step in steps]
    axes.plot(times, friction_coefficients(steps), "-", color=color, label=label)
    axes.set(xlabel="time (s)", ylabel="friction coefficient")
    return axes


def plot_slip_rate(
    axes: Any, steps: Sequence[Any], color: str = ORANGE, label: str | None = None
) -> Any:
    """Plot the mean slip rate over the time, on a logarithmic scale.

    Parameters
    ----------
    axes, steps, color, label
        See `plot_friction_over_time`.

    Returns
    -------
    matplotlib Axes
    """
    rates = np.array([step.slip_rate for step in steps]) / UNITS["nm/s"]
    rates[rates <= _MIN_RELATIVE_RATE * rates.max(initial=0.0)] = np.nan
    axes.plot([step.time for step in steps], rates, "-", color=color, label=label)
    axes.set(xlabel="time (s)", ylabel="slip rate (nm/s)", yscale="log")
    return axes


def draw_sliding_in_time(file: Path, steps: Sequence[Any]) -> None:
    """Write the figure of a sliding path in time: friction and slip rate.

    Parameters
    ----------
    file : path
    steps
        See `plot_friction_over_time`.
    """
    with written(file, 4.2) as figure:
        upper, lower = figure.subplots(2, 1, sharex=True)
        plot_friction_over_time(upper, steps)
        plot_slip_rate(lower, steps)
        upper.label_outer()
        letter((upper, lower))
