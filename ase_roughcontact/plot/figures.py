"""Figures of columns of results."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from ase_roughcontact.plot.style import BLUE, GREY, LINES, WIDTH, style

# Height of a figure (inches).
_HEIGHT = 3.0


def column_figure(
    columns: tuple[np.ndarray, np.ndarray],
    labels: tuple[str, str],
    error: np.ndarray | None,
    points: np.ndarray,
    theory: Mapping[str, np.ndarray],
    *,
    joined: bool = True,
) -> Figure:
    """Draw a column against another one, beside curves of theory.

    Parameters
    ----------
    columns : (ndarray, ndarray), shapes (k,)
        The columns on the horizontal and the vertical axis.
    labels : (str, str)
        Labels of the axes, with units.
    error : ndarray, shape (k,), optional
        Estimated errors on the vertical axis; bars show twice the estimate.
    points : ndarray, shape (n,)
        Values on the horizontal axis of the curves of theory.
    theory : mapping of str to ndarray, shape (n,)
        Values by theory, by label.
    joined : bool
        Whether a line joins the points.

    Returns
    -------
    matplotlib.figure.Figure
    """
    x, y = columns
    with style():
        figure = Figure(figsize=(WIDTH, _HEIGHT), layout="constrained")
        axes = figure.subplots()
        for number, (name, values) in enumerate(theory.items()):
            line = LINES[number % len(LINES)]
            axes.plot(points, values, f"k{line}", lw=1, label=name)
        if error is not None:
            axes.errorbar(x, y, 2.0 * error, fmt="none", ecolor=GREY, lw=1)
        line = "-" if joined else ""
        axes.plot(x, y, f"o{line}", color=BLUE, ms=4, lw=0.8, label="simulation")
        axes.set(xlabel=labels[0], ylabel=labels[1])
        if theory:
            axes.legend(frameon=False)
    return figure
