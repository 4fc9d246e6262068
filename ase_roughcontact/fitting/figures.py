"""Figure of a measured force curve, its fits and the residuals."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.least_squares import Fit
from ase_roughcontact.fitting.smooth_fit import SmoothFit
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import BLUE, GREY, ORANGE, legend_below, letter

_NN = UNITS["nN"]
# Smallest force in a contact, relative to the noise, and to the largest force.
_MIN_FORCE, _MIN_RELATIVE_FORCE = 5.0, 0.01
# Margin beside the contact, relative to it.
_CONTACT_MARGIN = 0.15
# Smallest tension of points of the part under tension, relative to the largest one.
_MIN_TENSION = 0.5
# Smallest margin beside this part, relative to the curve.
_MIN_MARGIN = 0.03


def draw_fit(fit: Fit, smooth: SmoothFit | None, file: Path) -> None:
    """Draw the contact of a measured force curve, its fits, and the residuals.

    With adhesion a third panel has the part under tension.

    Parameters
    ----------
    fit : Fit
        Fit of a scene, with the measured curve.
    smooth : SmoothFit, optional
        Fit of a smooth sphere.
    file : path
        Picture to write.
    """
    curves: list[tuple] = [("fit", fit, BLUE, 2.0, "-")]
    if smooth is not None:
        curves.append(("smooth sphere", smooth, ORANGE, 1.2, "--"))
    (name, x_unit), (_, y_unit) = fit.abscissa, fit.ordinate
    with written(file, 5.5) as figure:
        ratios = (3, 1.3, 3) if x_unit != "s" and _adheres(fit) else (3, 1.3)
        panels = figure.subplots(len(ratios), 1, height_ratios=ratios)
        upper, lower, *details = panels
        _draw_curves(upper, fit, curves, size=1.5)
        for detail in details:
            _draw_curves(detail, fit, curves, size=2.5)
            _cut_to_tension(detail, fit)
        for _, each, colour, _, _ in curves:
            residual = (each.fitted - fit.force)[fit.compared] / UNITS[y_unit]
            distance = fit.distance[fit.compared] / UNITS[x_unit]
            lower.plot(distance, residual, ".", color=colour, ms=2)
        lower.axhline(0.0, color="black", lw=0.5)
        lower.set_ylabel(f"residual ({y_unit})")
        lower.sharex(upper)
        if x_unit != "s":
            _cut_to_contact(upper, fit)
        for axes in panels:
            axes.set_xlabel(f"{name} ({x_unit})")
        letter(panels)
        legend_below(figure, [upper])


def _draw_curves(axes: Any, fit: Fit, curves: Sequence[tuple], size: float) -> None:
    """Draw measured points, hollow where they are not compared, below some curves."""
    (_, x_unit), (label, y_unit) = fit.abscissa, fit.ordinate
    distance, force = fit.distance / UNITS[x_unit], fit.force / UNITS[y_unit]
    points = {"color": GREY, "ms": size}
    inside, outside = fit.compared, ~fit.compared
    axes.plot(distance[inside], force[inside], "o", **points, label="measured")
    if outside.any():
        hollow = distance[outside], force[outside]
        left_out = "measured at a jump, not compared"
        axes.plot(*hollow, "o", **points, mfc="white", label=left_out)
    for name, each, colour, width, line in curves:
        x, y = each.line or (fit.distance, each.fitted)
        x, y = x / UNITS[x_unit], y / UNITS[y_unit]
        axes.plot(x, y, line, color=colour, lw=width, label=name)
    axes.set_ylabel(f"{label} ({y_unit})")


def _adheres(fit: Fit) -> bool:
    """Return whether a measured tension exceeds the noise."""
    return bool(fit.far_force - fit.force.min() > _MIN_FORCE * fit.noise)


def _cut_to_contact(axes: Any, fit: Fit) -> None:
    """Limit axes to the points at which a force acts, with a margin of free points."""
    distance = fit.distance / UNITS["nm"]
    force = abs(fit.force - fit.far_force)
    acts = force > max(_MIN_FORCE * fit.noise, _MIN_RELATIVE_FORCE * force.max())
    if acts.any():
        low, high = distance[acts].min(), distance[acts].max()
        margin = _CONTACT_MARGIN * (high - low)
        ends = low - margin, high + margin
        axes.set_xlim(np.clip(ends, distance.min() - margin, distance.max() + margin))


def _cut_to_tension(axes: Any, fit: Fit) -> None:
    """Limit axes to the part of a curve under tension, with as much compression."""
    distance, force = fit.distance / UNITS["nm"], fit.force / _NN
    free = fit.far_force / _NN
    tension = free - force.min()
    part = distance[force < free - _MIN_TENSION * tension]
    if part.size:
        margin = max(2.0 * np.ptp(part), _MIN_MARGIN * np.ptp(distance))
        ends = part.min() - margin, part.max() + margin
        axes.set_xlim(np.clip(ends, distance.min(), distance.max()))
        lowest = min(line.get_ydata().min() for line in axes.lines)
        axes.set_ylim(free - 1.2 * (free - lowest), free + tension)
