"""Errors of choices against their times."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from ase_roughcontact.plot.style import COLOURS, GREY

_MARKERS = "osD^v<>P"


def plot_tradeoff(
    axes: Any,
    choices: Sequence[tuple[str, str, float, float]],
    front: Collection[int] = (),
    wanted: float | None = None,
    of: str = "area",
) -> Any:
    """Plot error against time, with the Pareto front as a line.

    Parameters
    ----------
    axes : matplotlib Axes
    choices : sequence of (str, str, float, float)
        Source of the error, label, relative error and time (s). Errors and times of
        zero are drawn at the edge.
    front : collection of int
        Numbers of the choices than which no other is both faster and more accurate.
    wanted : float, optional
        Wanted error, drawn as a horizontal line.
    of : str
        The answer that has the errors.

    Returns
    -------
    matplotlib Axes
    """
    sources = list(dict.fromkeys(source for source, *_ in choices))
    errors, times = (
        _above_zero(np.array([choice[i] for choice in choices])) for i in (2, 3)
    )
    for number, (source, label, *_) in enumerate(choices):
        kind = sources.index(source)
        axes.plot(
            times[number],
            errors[number],
            _MARKERS[kind % len(_MARKERS)],
            color=COLOURS[kind % len(COLOURS)],
            ms=6,
            label=source if source not in axes.get_legend_handles_labels()[1] else None,
        )
        place = {"xytext": (5, 3 - 10 * (number % 2)), "textcoords": "offset points"}
        axes.annotate(label, (times[number], errors[number]), fontsize=7, **place)
    along = sorted(front, key=lambda number: times[number])
    if along:
        axes.plot(times[along], errors[along], "k-", lw=0.8, label="Pareto front")
    if wanted is not None:
        axes.axhline(wanted, color=GREY, ls="--", lw=0.8, label="wanted error")
    axes.set(xscale="log", yscale="log")
    axes.set(xlabel="time (s)", ylabel=f"error of the {of}")
    axes.legend(fontsize=7)
    return axes


def _above_zero(values: np.ndarray) -> np.ndarray:
    """Return values with a third of the smallest positive one in place of zeros."""
    positive = values[values > 0.0]
    return np.where(values > 0.0, values, positive.min(initial=1.0) / 3.0)
