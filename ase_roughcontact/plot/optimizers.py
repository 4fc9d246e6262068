"""Errors of optimizers against their costs."""

from __future__ import annotations

from typing import Any

import numpy as np

from ase_roughcontact.optimize.comparison_result import OptimizerComparison
from ase_roughcontact.plot.style import COLOURS, GREY, LINES

# Smallest error that is drawn.
_MIN_ERROR = 1e-9


def plot_optimizers(axes: Any, comparison: OptimizerComparison) -> Any:
    """Plot the error of each optimizer against the FFT pairs that it took.

    An evaluation of energy and forces of all atoms costs one pair. Circles mark the
    last states of converged optimizers, crosses the last states of other optimizers.

    Parameters
    ----------
    axes : matplotlib Axes
    comparison : OptimizerComparison
        Errors and costs of the optimizers.

    Returns
    -------
    matplotlib Axes
    """
    followed = [result for result in comparison.results if result.history]
    for number, result in enumerate(followed):
        pairs = np.maximum([each.pairs for each in result.history], 1.0)
        errors = np.maximum([each.error for each in result.history], _MIN_ERROR)
        colour = COLOURS[number % len(COLOURS)]
        line = LINES[number // len(COLOURS) % len(LINES)]
        axes.plot(pairs, errors, ls=line, color=colour, label=result.optimizer)
        mark = "o" if result.converged else "x"
        axes.plot(pairs[-1], errors[-1], mark, color=colour, ms=4.0, clip_on=False)
    wanted = {"color": GREY, "ls": ":", "lw": 0.8, "label": "wanted error"}
    axes.axhline(comparison.accuracy, zorder=0, **wanted)
    axes.set(xscale="log", yscale="log")
    axes.set_xlabel("evaluations of energy and forces (FFT pairs)")
    axes.set_ylabel("relative error of force and area")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    return axes
