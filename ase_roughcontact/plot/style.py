"""Colours, lines, units, and defaults for printed figures."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from string import ascii_lowercase
from typing import Any, Literal

import numpy as np
from cycler import cycler
from matplotlib import rc_context

from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact._util.validation import FloatArray

#: First branch of a force curve.
BLUE = "#0072B2"
#: Simulations, and the second branch of a force curve.
ORANGE = "#D55E00"
#: Theory, errors and marks.
GREY = "#7F7F7F"
#: Palette of Okabe and Ito, suitable for all kinds of colour vision.
COLOURS = (BLUE, ORANGE, "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
#: Width of a journal column (inches).
WIDTH = 3.4
#: Styles of broken lines.
DASHES = ("--", ":", "-.")
#: Styles of lines.
LINES = ("-", *DASHES)
#: Names, colours and widths of lines of the branches of a force curve.
BRANCHES: tuple[tuple[Literal["approach", "retraction"], str, float], ...] = (
    ("approach", BLUE, 2.0),
    ("retraction", ORANGE, 0.8),
)
# Largest number of characters of labels that are placed side by side in a legend.
_MAX_LABEL_LENGTH = 20
# Share of a line at either side of its arrow that determines its direction.
_ARROW_SHARE = 0.04
# Size of the head of an arrow (points), larger than the points of a line.
_HEAD_SIZE = 14


def style() -> AbstractContextManager:
    """Return a context with defaults for printed figures.

    The width of a journal column (86 mm), 8-point text, inward ticks on all sides,
    Okabe and Ito's colours, and 300 dots per inch.

    Returns
    -------
    context manager
        Figures created within it have these defaults.
    """
    return rc_context(
        {
            "figure.figsize": (WIDTH, 2.6),
            "figure.constrained_layout.use": True,
            "savefig.dpi": 300,
            "font.size": 8,
            "axes.linewidth": 0.6,
            "axes.titlesize": 8,
            "axes.prop_cycle": cycler(color=COLOURS),
            "lines.linewidth": 1.0,
            "lines.markersize": 3.5,
            "legend.fontsize": 7,
            "legend.frameon": False,
            "pdf.fonttype": 42,
            "xtick.direction": "in",
            "ytick.direction": "in",
            "xtick.labelsize": 7,
            "ytick.labelsize": 7,
            "xtick.top": True,
            "ytick.right": True,
        }
    )


def add_jump(axes: Any, before: Sequence[float], after: Sequence[float]) -> None:
    """Draw an arrow from the point before an instability to the point after it."""
    axes.annotate("", after, before, arrowprops={"arrowstyle": "->"})


def add_right_scale(axes: Any, label: str, factor: float, **options: Any) -> None:
    """Add a scale at the right, proportional to the scale at the left."""
    functions = (lambda value: factor * value, lambda value: value / factor)
    axes.secondary_yaxis("right", functions=functions).set_ylabel(label, **options)


def letters(count: int) -> list[str]:
    """Return the letters of panels, a, b, ...; numbers if there are more than 26."""
    if count > len(ascii_lowercase):
        return [str(number) for number in range(1, count + 1)]
    return list(ascii_lowercase[:count])


def letter(panels: Sequence[Any]) -> None:
    """Write (a), (b), ... at the upper left of panels."""
    for name, panel in zip(letters(len(panels)), panels, strict=True):
        panel.set_title(f"({name})", loc="left")


def add_arrow(axes: Any, x: FloatArray, y: FloatArray, colour: str) -> None:
    """Draw the head of an arrow at the middle of a line, in its direction."""
    steps = [np.diff(each) / (float(np.ptp(each)) or 1.0) for each in (x, y)]
    along = np.append(0.0, np.cumsum(np.hypot(*steps)))
    if not along[-1]:
        return
    at = along[-1] * np.array([0.5 - _ARROW_SHARE, 0.5, 0.5 + _ARROW_SHARE])
    before, tip, after = np.transpose([np.interp(at, along, each) for each in (x, y)])
    # the shaft, a chord beside the line, is not drawn
    arrow = {"arrowstyle": "-|>", "color": colour, "shrinkA": 0, "shrinkB": 0, "lw": 0}
    tail = tip - (after - before)
    axes.annotate("", tip, tail, arrowprops={**arrow, "mutation_scale": _HEAD_SIZE})


def limit_to(axes: Any, x: FloatArray, y: FloatArray, margin: float) -> None:
    """Limit axes to some points, with a margin relative to their range.

    Values that are equal but for rounding have the range of their size.
    """
    for values, limit in ((x, axes.set_xlim), (y, axes.set_ylim)):
        extent, size = float(np.ptp(values)), float(abs(values).max())
        if extent <= LENGTH_ROUNDING * size:
            extent = size or 1.0
        width = margin * extent
        limit(values.min() - width, values.max() + width)


def legend_below(figure: Any, panels: Sequence[Any]) -> None:
    """Replace the legends of all panels by one below them."""
    handles: dict[str, Any] = {}
    for panel in panels:
        lines, labels = panel.get_legend_handles_labels()
        handles.update(zip(labels, lines, strict=True))
    for panel in panels:
        if panel.get_legend():
            panel.get_legend().remove()
    if handles:
        columns = 2 if max(map(len, handles)) < _MAX_LABEL_LENGTH else 1
        figure.legend(
            handles.values(), handles.keys(), loc="outside lower center", ncols=columns
        )
