"""Errors of choices against their costs."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from itertools import compress, product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.transforms import Bbox

from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import COLOURS, GREY
from ase_roughcontact.tradeoff.result import Tradeoff

# Markers of the sources of errors.
_MARKERS = "osD^v<>P"
# Smallest error that is distinguished from zero, relative to the wanted error.
_MIN_RELATIVE_ERROR = 1e-3
# Size of the markers of the first source (points).
_MARKER_SIZE = 5.0
# Increase of the size for each further source (points). It is drawn behind the others,
# so that no marker hides another.
_MARKER_GROWTH = 0.8
# Distances of a label from its point, the preferred ones first (points).
_LABEL_DISTANCES = (8.0, 14.0, 22.0)
# Directions from a point to its label, the preferred ones first.
_DIRECTIONS = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))
# Horizontal alignments of a label by its direction along x: 0, 1 and -1.
_HORIZONTAL = ("center", "left", "right")
# Vertical alignments of a label by its direction along y: 0, 1 and -1.
_VERTICAL = ("center", "bottom", "top")


def draw_tradeoff(study: Tradeoff, file: Path) -> None:
    """Draw errors of choices against their costs."""
    choices = [
        (c.source, f"{'≤ ' * c.is_bound}{c.label}", c.error, c.cost)
        for c in study.choices
    ]
    front = [n for n, choice in enumerate(study.choices) if choice in study.front]
    with written(file, 4.2, width=6.0) as figure:
        axes = figure.subplots()
        plot_tradeoff(axes, choices, front, study.wanted, study.of)


def plot_tradeoff(
    axes: Any,
    choices: Sequence[tuple[str, str, float, float]],
    front: Collection[int] = (),
    wanted: float | None = None,
    of: str = "area",
) -> Any:
    """Plot error against cost, with the Pareto front of each source as a line.

    Parameters
    ----------
    axes : matplotlib Axes
    choices : sequence of (str, str, float, float)
        Source of the error, label, relative error and cost. Zeros, and errors of less
        than 1e-3 of the wanted one, are drawn at a tenth of the smallest other value,
        or of the wanted error if this is smaller.
    front : collection of int
        Numbers of the choices on the Pareto front of their source: no other choice of
        the source is both cheaper and more accurate.
    wanted : float, optional
        Wanted error, drawn as a horizontal line.
    of : str
        The answer with these errors: "area", "force" or "height".

    Returns
    -------
    matplotlib Axes
    """
    sources = [source for source, *_ in choices]
    given_errors = np.array([error for _, _, error, _ in choices])
    given_costs = np.array([cost for _, _, _, cost in choices])
    errors = _above_edge(given_errors, wanted)
    costs = _above_edge(given_costs)
    axes.set(xscale="log", yscale="log")
    for kind, source in enumerate(dict.fromkeys(sources)):
        style = {"color": COLOURS[kind % len(COLOURS)], "clip_on": False}
        members = [n for n, each in enumerate(sources) if each == source]
        marker = _MARKERS[kind % len(_MARKERS)]
        points = costs[members], errors[members]
        size, order = _MARKER_SIZE + _MARKER_GROWTH * kind, 3.0 - 0.1 * kind
        axes.plot(*points, marker, ms=size, label=source, zorder=order, **style)
        along = sorted(set(front).intersection(members), key=lambda n: costs[n])
        if len(along) > 1:
            axes.plot(costs[along], errors[along], lw=0.8, zorder=1, **style)
    if wanted is not None:
        axes.axhline(wanted, color=GREY, ls="--", lw=0.8, label="wanted error")
    axes.margins(0.12)
    axes.set_xlabel("FFT pairs times grid points" + _edge(costs != given_costs, "left"))
    axes.set_ylabel(f"error of the {of}" + _edge(errors != given_errors, "lower"))
    options = {"ncols": 4, "frameon": False, "fontsize": 7}
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), **options)
    labels = dict[tuple[float, float], list[str]]()
    for x, y, (_, label, *_) in zip(costs, errors, choices, strict=True):
        labels.setdefault((x, y), []).append(label)
    _annotate(axes, {point: ", ".join(names) for point, names in labels.items()})
    return axes


def _above_edge(values: np.ndarray, wanted: float | None = None) -> np.ndarray:
    """Return values; small values are replaced by a tenth of the smallest other one."""
    shown = values > _MIN_RELATIVE_ERROR * (wanted or 0.0)
    edge = min(values[shown].min(initial=math.inf), wanted or math.inf) / 10.0
    return np.where(shown, values, edge if edge < math.inf else 1.0)


def _edge(moved: np.ndarray, side: str) -> str:
    """Return the addition to the label of an axis with values drawn at its edge."""
    return f" (about 0 at the {side} edge)" if moved.any() else ""


def _annotate(axes: Any, labels: dict[tuple[float, float], str]) -> None:
    """Write labels beside points, where they overlap neither lines nor each other."""
    axes.get_figure().draw_without_rendering()  # places the axes
    paths = [
        line.get_transform().transform_path(line.get_path()) for line in axes.lines
    ]
    has_marker = [line.get_marker() != "None" for line in axes.lines]
    markers = np.concatenate([p.vertices for p in compress(paths, has_marker)])
    curves = list(compress(paths, np.logical_not(has_marker)))
    taken: list[Bbox] = []
    for point, label in labels.items():
        options = {"textcoords": "offset points", "fontsize": 7, "in_layout": False}
        note = axes.annotate(label, point, (0.0, 0.0), **options)
        for distance, (right, up) in product(_LABEL_DISTANCES, _DIRECTIONS):
            note.set_position((distance * right, distance * up))
            note.set(ha=_HORIZONTAL[right], va=_VERTICAL[up])
            box = note.get_window_extent()
            inside = np.allclose(Bbox.intersection(axes.bbox, box) or 0.0, box)
            crossed = any(curve.intersects_bbox(box, filled=False) for curve in curves)
            hidden = box.padded(_MARKER_SIZE).count_contains(markers)
            if inside and not (crossed or hidden or box.count_overlaps(taken)):
                break
        taken.append(box)
