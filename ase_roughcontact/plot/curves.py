"""Curves: area and force along a path, errors along a relaxation.

Functions for paths take arrays, or steps in place of the first array.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.ticker import LogLocator
from numpy.typing import ArrayLike

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import finite_array
from ase_roughcontact.plot.step_columns import column_of_steps, is_steps
from ase_roughcontact.plot.style import BLUE, GREY, LINES, ORANGE, limit_to
from ase_roughcontact.results.record import LoadStep

NN = UNITS["nN"]
NM = UNITS["nm"]
# Margin of axes beside the steps, relative to their range.
_AXES_MARGIN = 0.08


def plot_curve(
    axes: Any,
    load: np.ndarray | Sequence[LoadStep],
    area: np.ndarray | None = None,
    hertz_area: ArrayLike = 1.0,
    theory: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    converged: ArrayLike | None = None,
    hertz_label: str = "smooth sphere (Hertz)",
    area_error: ArrayLike | None = None,
    label: str = "simulation",
) -> Any:
    """Plot contact area relative to Hertz against load, beside theory.

    Parameters
    ----------
    axes : matplotlib Axes
    load : ndarray, shape (k,), or sequence of LoadStep
        Positive normal forces (nN). Steps, such as `Results`, have areas, their errors
        and whether they are converged, too.
    area : ndarray, shape (k,), optional
        Areas of the simulation (area; of steps Å^2).
    hertz_area : array_like, shape (k,)
        Areas of the smooth sphere, in the same unit.
    theory : mapping of str to (array_like, array_like), optional
        Loads (nN) and areas relative to Hertz of theories, by label.
    converged : array_like of bool, shape (k,), optional
        Whether steps are converged; other steps are drawn as crosses. Default: all are.
    hertz_label : str
        Label of the line at a relative area of one.
    area_error : array_like, shape (k,), optional
        Estimated errors of the areas; error bars show twice the estimate.
    label : str
        Label of the areas.

    Returns
    -------
    matplotlib Axes
    """
    if is_steps(load):
        steps, load = load, column_of_steps(load, "normal_force") / NN
        area, area_error, converged = _areas(steps)
    if area is None:
        raise TypeError("plot_curve needs steps, or loads and areas")
    hertz_area = np.asarray(hertz_area)
    axes.axhline(1.0, color=GREY, lw=1, label=hertz_label)
    error = None if area_error is None else area_error / hertz_area
    plot_area(axes, load, area / hertz_area, theory, converged, error, label)
    axes.set_ylabel(r"contact area $A/A_\mathrm{Hertz}$")
    return axes


def plot_area(
    axes: Any,
    load: np.ndarray | Sequence[LoadStep],
    area: np.ndarray | None = None,
    theory: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    converged: ArrayLike | None = None,
    area_error: ArrayLike | None = None,
    label: str = "simulation",
) -> Any:
    """Plot contact area against load, beside theory, on logarithmic axes.

    Parameters
    ----------
    axes : matplotlib Axes
    load : ndarray, shape (k,), or sequence of LoadStep
        Positive normal forces (nN), or steps; see `plot_curve`.
    area : ndarray, shape (k,), optional
        Areas (nm²).
    theory : mapping of str to (array_like, array_like), optional
        Loads and areas of theories, by label.
    converged, area_error, label
        See `plot_curve`.

    Returns
    -------
    matplotlib Axes
    """
    if is_steps(load):
        steps, load = load, column_of_steps(load, "normal_force") / NN
        area, area_error, converged = _areas(steps, NM**2)
    if area is None:
        raise TypeError("plot_area needs steps, or loads and areas")
    load = np.asarray(load)
    for i, (name, (loads, areas)) in enumerate((theory or {}).items()):
        axes.plot(loads, areas, LINES[i % 4], color="k", lw=1, label=name)
    ok = _converged_mask(converged, len(load))
    axes.plot(load[ok], area[ok], "o", color=ORANGE, ms=5, label=label)
    if area_error is not None:
        bars = 2.0 * np.asarray(area_error)
        axes.errorbar(load, area, bars, fmt="none", ecolor=ORANGE, lw=1)
    _mark_not_converged(axes, load[~ok], area[~ok])
    axes.set(xscale="log", yscale="log")
    for axis, (low, high) in (
        (axes.xaxis, axes.get_xlim()),
        (axes.yaxis, axes.get_ylim()),
    ):
        if high < 100.0 * low:  # powers of ten alone are too few ticks
            axis.set_major_formatter("{x:g}")
            axis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
            axis.set_minor_formatter("{x:g}")
    axes.set(xlabel="normal force $N$ (nN)", ylabel="contact area (nm$^2$)")
    axes.legend(frameon=False, loc="best")
    return axes


def plot_force(
    axes: Any,
    depth: ArrayLike | Sequence[LoadStep],
    force: ArrayLike | None = None,
    theory: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    pull_off_force: float | None = None,
    xlabel: str = "penetration (Å)",
    converged: ArrayLike | None = None,
    pull_off_label: str = "pull-off, theory",
    depth_error: ArrayLike = 0.0,
    force_error: ArrayLike = 0.0,
) -> Any:
    """Plot force against penetration or height; tension is negative.

    The axes are limited to the simulation and the pull-off force; theories outside of
    them are left out. A path that reverses is drawn as two curves, which meet at the
    step furthest from the first one.

    Parameters
    ----------
    axes : matplotlib Axes
    depth : array_like, shape (k,), or sequence of LoadStep
        Penetrations or heights (Å), in the order of the path. Steps, such as `Results`,
        have penetrations, forces, their errors and whether they are converged.
    force : array_like, shape (k,), optional
        Normal forces, negative in tension (eV/Å).
    theory : mapping of str to (array_like, array_like), optional
        Penetrations or heights (Å) and forces (eV/Å) of theories, by label.
    pull_off_force : float, optional
        Pull-off force of theory (eV/Å), drawn as a horizontal line.
    xlabel : str
        Quantity and unit of `depth`.
    converged : array_like of bool, shape (k,), optional
        Whether steps are converged; other steps are drawn as crosses apart from the
        curve. Default: all are.
    pull_off_label : str
        Label of `pull_off_force`.
    depth_error, force_error : array_like, shape (k,), optional
        Estimated errors (Å, eV/Å); error bars show twice the estimate.

    Returns
    -------
    matplotlib Axes
    """
    if is_steps(depth):
        steps, depth = depth, column_of_steps(depth, "penetration")
        force, force_error = (
            column_of_steps(steps, name) for name in ("normal_force", "force_error")
        )
        converged = column_of_steps(steps, "converged")
    if force is None:
        raise TypeError("plot_force needs steps, or depths and forces")
    x, y = finite_array("depth", depth), finite_array("force", force) / NN
    axes.axhline(0.0, color=GREY, lw=0.6)
    limit_to(axes, x, np.append(y, -(pull_off_force or 0.0) / NN), _AXES_MARGIN)
    for i, (name, (along, forces)) in enumerate((theory or {}).items()):
        points = np.array([along, np.asarray(forces) / NN])
        if _is_inside(axes, points):
            axes.plot(*points, f"k{LINES[i % 4]}", label=name)
    if pull_off_force is not None:
        level = -pull_off_force / NN
        axes.axhline(level, color=GREY, ls="--", lw=1, label=pull_off_label)
    ok = _converged_mask(converged, x.size)
    _mark_not_converged(axes, x[~ok], y[~ok])
    bars_x = np.broadcast_to(2.0 * np.asarray(depth_error), x.shape)
    bars_y = np.broadcast_to(2.0 * np.asarray(force_error) / NN, x.shape)
    axes.errorbar(x, y, bars_y, bars_x, fmt="none", ecolor=GREY, lw=1)
    y = np.where(ok, y, np.nan)
    peak = int(np.argmax(abs(x - x[0])))  # where the path reverses
    label = "simulation"
    if 0 < peak < x.size - 1:
        label, up = "retraction", slice(peak + 1)
        axes.plot(x[up], y[up], "o-", color=BLUE, ms=7, lw=2, label="approach")
        x, y = x[peak:], y[peak:]
    axes.plot(x, y, "o-", color=ORANGE, ms=4, lw=0.8, label=label)
    axes.set(xlabel=xlabel, ylabel="normal force $N$ (nN)")
    axes.legend(frameon=False, loc="best")
    return axes


def _areas(
    steps: Sequence[LoadStep], unit: float = 1.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return areas and their errors in a unit (Å^2), and which steps are converged."""
    area, error = (
        column_of_steps(steps, name) for name in ("contact_area", "area_error")
    )
    return area / unit, error / unit, column_of_steps(steps, "converged")


def _converged_mask(converged: ArrayLike | None, count: int) -> np.ndarray:
    """Return which steps are converged."""
    return np.full(count, True) if converged is None else np.asarray(converged, bool)


def _mark_not_converged(axes: Any, x: np.ndarray, y: np.ndarray) -> None:
    """Draw steps that are not converged."""
    if x.size:
        axes.plot(x, y, "x", color=GREY, ms=6, label="not converged")


def _is_inside(axes: Any, points: np.ndarray) -> bool:
    """Return whether a point, shape (2, k), is within the limits of axes."""
    low, high = np.transpose([axes.get_xlim(), axes.get_ylim()])
    inside = (points >= low[:, None]) & (points <= high[:, None])
    return bool(inside.all(axis=0).any())


def plot_convergence(
    axes: Any,
    curves: Mapping[str, tuple[ArrayLike, ArrayLike]],
    xlabel: str = "steps of the optimizer",
    ylabel: str = "largest force (eV/Å)",
) -> Any:
    """Plot errors against cost, on a logarithmic axis of errors.

    Parameters
    ----------
    axes : matplotlib Axes
    curves : mapping of str to (array_like, array_like)
        Costs and errors, both of shape (k,), by label. Errors of zero are omitted.
    xlabel, ylabel : str
        Quantity and unit of costs and errors.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ValueError
        If costs or errors are not finite, or their shapes differ.
    """
    for i, (name, (cost, error)) in enumerate(curves.items()):
        x, y = finite_array("costs", cost), abs(finite_array("errors", error))
        if x.shape != y.shape or x.ndim != 1:
            raise ValueError(
                f"{name}: costs and errors must be one-dimensional and of the same "
                f"length, got shapes {x.shape} and {y.shape}"
            )
        axes.plot(x[y > 0], y[y > 0], LINES[i % 4], label=name)
    axes.set(yscale="log", xlabel=xlabel, ylabel=ylabel)
    axes.legend()
    return axes
