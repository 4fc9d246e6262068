"""Figures of a measured force curve as it was read, and of fits of an indenter."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.curve_checks import contact_point
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.fitting.indentation import IndentationFit
from ase_roughcontact.fitting.relaxation import RelaxationFit
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import (
    BLUE,
    BRANCHES,
    GREY,
    ORANGE,
    legend_below,
    letter,
)

_NM, _NN = UNITS["nm"], UNITS["nN"]
# Number of points of a drawn model.
_DRAWN_POINTS = 500


def draw_curve(curve: ForceCurve, file: Path) -> None:
    """Draw a curve as it was read: branches, turn, free force and contact.

    Parameters
    ----------
    curve : ForceCurve
    file : path
        Picture to write.
    """
    with written(file, 4.4) as figure:
        panels = figure.subplots(2, 1)
        upper, lower = panels
        for axes, values in ((upper, curve.base), (lower, curve.depth)):
            _draw_branches(axes, curve, values / _NM)
            axes.axhline(curve.far_force / _NN, color="black", lw=0.5, ls=":")
            axes.set_ylabel("force (nN)")
        start, turn = 0, int(np.argmin(curve.base))
        for point, marker, label in ((start, ">", "first point"), (turn, "v", "turn")):
            _mark(upper, curve, point, marker, label)
        if (contact := contact_point(curve)) is not None:
            _mark(upper, curve, contact, "o", "leaves the free force")
        upper.set_xlabel("height of the base (nm)")
        lower.set_xlabel("depth of the tip (nm)")
        letter(panels)
        legend_below(figure, [upper])


def draw_indentation(fit: IndentationFit, file: Path) -> None:
    """Draw an indentation fit over the base and the indentation, and residuals.

    Parameters
    ----------
    fit : IndentationFit
    file : path
        Picture to write.
    """
    indentation = fit.indentation / _NM
    with written(file, 5.5) as figure:
        panels = figure.subplots(3, 1, height_ratios=(3, 3, 1.3))
        upper, middle, lower = panels
        base = fit.curve.base / _NM
        _draw_points(upper, base, fit.curve.force / _NN, fit.compared)
        upper.plot(base, fit.fitted / _NN, color=BLUE, lw=1.5, label=fit.indenter.name)
        upper.plot(base, fit.baseline / _NN, ":", color="black", lw=0.8)
        contact = int(np.argmin(abs(fit.indentation)))
        _mark(upper, fit.curve, contact, "o", "contact point")
        _draw_points(middle, indentation, fit.force / _NN, fit.compared)
        low, high = (depth / _NM for depth in fit.drawn_depths)
        depths = np.linspace(low, 1.05 * high, _DRAWN_POINTS)
        middle.plot(depths, fit.model(depths * _NM) / _NN, color=BLUE, lw=1.5)
        residual = (fit.fitted - fit.curve.force) / _NN
        lower.plot(
            indentation[fit.compared], residual[fit.compared], ".", color=BLUE, ms=2
        )
        lower.axhline(0.0, color="black", lw=0.5)
        for axes in (middle, lower):
            axes.set_xlim(low, 1.05 * high)
            axes.set_xlabel("indentation (nm)")
        upper.set_xlabel("height of the base (nm)")
        upper.set_ylabel("force (nN)")
        middle.set_ylabel("force (nN)")
        lower.set_ylabel("residual (nN)")
        letter(panels)
        legend_below(figure, [upper])


def draw_relaxation(fit: RelaxationFit, file: Path) -> None:
    """Draw the forces of an approach and a hold over time, their fit, and residuals.

    Parameters
    ----------
    fit : RelaxationFit
    file : path
        Picture to write.
    """
    with written(file, 3.8) as figure:
        panels = figure.subplots(2, 1, height_ratios=(3, 1.3), sharex=True)
        upper, lower = panels
        everywhere = np.ones(len(fit.time), bool)
        _draw_points(upper, fit.time, fit.force / _NN, everywhere)
        terms = len(fit.relaxation_times)
        times = "relaxation time" if terms == 1 else "relaxation times"
        label = f"{fit.indenter.name}, {terms} {times}"
        upper.plot(fit.time, fit.fitted / _NN, color=BLUE, lw=1.5, label=label)
        residual = (fit.fitted - fit.force) / _NN
        lower.plot(fit.time, residual, ".", color=BLUE, ms=2)
        lower.axhline(0.0, color="black", lw=0.5)
        upper.set_ylabel("force (nN)")
        lower.set_ylabel("residual (nN)")
        lower.set_xlabel("time (s)")
        letter(panels)
        legend_below(figure, [upper])


def _draw_branches(axes: Any, curve: ForceCurve, x: np.ndarray) -> None:
    """Draw the points of both branches."""
    names = {-1.0: BRANCHES[0], 1.0: BRANCHES[1]}
    for branch in curve.branches:
        name, colour, _ = names[branch.direction]
        part = branch.points
        axes.plot(
            x[part], curve.force[part] / _NN, ".", color=colour, ms=1.5, label=name
        )


def _draw_points(
    axes: Any, x: np.ndarray, force: np.ndarray, compared: np.ndarray
) -> None:
    """Draw measured points, those that are not compared paler."""
    axes.plot(x[compared], force[compared], ".", color=GREY, ms=2, label="measured")
    if not compared.all():
        left_out = {"color": GREY, "ms": 2, "alpha": 0.3, "label": "not compared"}
        axes.plot(x[~compared], force[~compared], ".", **left_out)


def _mark(axes: Any, curve: ForceCurve, point: int, marker: str, label: str) -> None:
    """Mark a point over the height of the base."""
    at = curve.base[point] / _NM, curve.force[point] / _NN
    style = {"mfc": "none", "mec": ORANGE if marker == "o" else "black", "ms": 6}
    axes.plot(*at, marker, label=label, **style)
