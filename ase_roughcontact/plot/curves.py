"""Curves of a run: area and force along a path, errors along a relaxation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.ticker import LogLocator
from numpy.typing import ArrayLike

from ase_roughcontact._util.validation import finite_array
from ase_roughcontact.paths.instabilities import AdhesionLoop
from ase_roughcontact.plot.style import BLUE, DASHES, GREY, LINES, NN, ORANGE


def plot_curve(
    axes: Any,
    load: np.ndarray,
    area: np.ndarray,
    hertz_area: np.ndarray,
    predicted_area: np.ndarray | None = None,
    laws: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    converged: ArrayLike | None = None,
    level: str = "smooth sphere (Hertz)",
) -> Any:
    """Contact area relative to Hertz against load, beside the prediction.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    load : ndarray, shape (k,)
        Normal forces above zero (nN).
    area, hertz_area : ndarray, shape (k,)
        Areas in one unit: simulated, and of the smooth sphere.
    predicted_area : ndarray, shape (k,), optional
        Area of Eq. (4), in the same unit.
    laws : mapping of str to (array_like, array_like), optional
        Names of other laws, their loads (nN), and their areas relative to Hertz.
    converged : array_like of bool, shape (k,), optional
        Steps that are results; the others are crossed. Default: all.
    level : str
        What an area relative to Hertz of one is.

    Returns
    -------
    matplotlib Axes
    """
    axes.axhline(1.0, color=GREY, lw=1, label=level)
    if predicted_area is not None:
        order = np.argsort(load)
        ratio = (predicted_area / hertz_area)[order]
        axes.plot(np.asarray(load)[order], ratio, "k-", lw=1, label="Eq. (4)")
    for i, (name, (loads, ratios)) in enumerate((laws or {}).items()):
        axes.plot(loads, ratios, LINES[i % 4], color=BLUE, lw=1, label=name)
    ratio, ok = area / hertz_area, _mask(converged, len(load))
    axes.plot(load[ok], ratio[ok], "o", color=ORANGE, ms=5, label="simulation")
    _cross(axes, load[~ok], ratio[~ok])
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis, (low, high) in (
        (axes.xaxis, axes.get_xlim()),
        (axes.yaxis, axes.get_ylim()),
    ):
        if high < 100.0 * low:  # few decades: powers of ten alone tell too little
            axis.set_major_formatter("{x:g}")
            axis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
            axis.set_minor_formatter("{x:g}")
    axes.set_xlabel("normal force $N$ (nN)")
    axes.set_ylabel(r"contact area $A/A_\mathrm{Hertz}$")
    axes.legend(frameon=False, loc="best")
    return axes


def plot_force(
    axes: Any,
    depth: ArrayLike,
    force: ArrayLike,
    laws: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
    pull_off_force: float | None = None,
    xlabel: str = "penetration (Å)",
    converged: ArrayLike | None = None,
    pull_off: str = "pull-off, theory",
) -> Any:
    """Force against penetration or height, tension below zero.

    The axes are cut to the simulation and the pull-off force. A path that turns round
    is drawn as two: towards its largest force, and on from there.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    depth : array_like, shape (k,)
        Penetrations or heights (Å), in the order of the path.
    force : array_like, shape (k,)
        Normal forces, negative in tension (eV/Å).
    laws : mapping of str to (array_like, array_like), optional
        Names of theories, their penetrations or heights (Å), and forces (eV/Å).
    pull_off_force : float, optional
        Of theory, negative, drawn as a level (eV/Å).
    xlabel : str
        What `depth` is, with its unit.
    converged : array_like of bool, shape (k,), optional
        Steps that are results; the others are crossed, and no line leads to them.
        Default: all.
    pull_off : str
        What `pull_off_force` is.

    Returns
    -------
    matplotlib Axes
    """
    x, y = finite_array("depth", depth), finite_array("force", force) / NN
    axes.axhline(0.0, color=GREY, lw=0.6)
    for i, (name, (along, forces)) in enumerate((laws or {}).items()):
        axes.plot(along, np.asarray(forces) / NN, f"k{LINES[i % 4]}", label=name)
    if pull_off_force is not None:
        level = pull_off_force / NN
        axes.axhline(level, color=GREY, ls="--", lw=1, label=pull_off)
    _cut(axes, x, np.append(y, min(0.0, pull_off_force or 0.0) / NN))
    ok = _mask(converged, x.size)
    _cross(axes, x[~ok], y[~ok])
    y = np.where(ok, y, np.nan)
    turn = int(np.nanargmax(y)) if ok.any() else 0
    back = slice(turn, None) if 0 < turn < x.size - 1 else slice(None)
    name = "simulation"
    if back.start:
        there = slice(turn + 1)
        axes.plot(x[there], y[there], "o-", color=BLUE, ms=7, lw=2, label="approach")
        name = "retraction"
    axes.plot(x[back], y[back], "o-", color=ORANGE, ms=4, lw=0.8, label=name)
    axes.set_xlabel(xlabel)
    axes.set_ylabel("normal force $N$ (nN)")
    axes.legend(frameon=False, loc="best")
    return axes


def _mask(converged: ArrayLike | None, count: int) -> np.ndarray:
    """Return which steps are results."""
    return np.full(count, True) if converged is None else np.asarray(converged, bool)


def _cross(axes: Any, x: np.ndarray, y: np.ndarray) -> None:
    """Draw steps that are no results."""
    if x.size:
        axes.plot(x, y, "x", color=GREY, ms=6, label="not converged")


def _cut(axes: Any, x: np.ndarray, y: np.ndarray) -> None:
    """Cut axes to some points, with a margin."""
    for values, limit in ((x, axes.set_xlim), (y, axes.set_ylim)):
        margin = 0.08 * (float(np.ptp(values)) or 1.0)
        limit(values.min() - margin, values.max() + margin)


def plot_loop(
    axes: Any, loop: AdhesionLoop, pull_off_forces: Mapping[str, float] | None = None
) -> Any:
    """Force against height along an adhesion loop, with its jumps.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    loop : AdhesionLoop
        From `adhesion_loop`.
    pull_off_forces : mapping of str to float, optional
        Names of theories, and their pull-off forces, negative, as `theory` gives them
        (eV/Å).

    Returns
    -------
    matplotlib Axes
    """
    ways = (("approach", loop.approach, BLUE), ("retraction", loop.retraction, ORANGE))
    for name, records, colour in ways:
        heights = [record.height for record in records]
        forces = [record.normal_force / NN for record in records]
        axes.plot(heights, forces, "o-", color=colour, ms=2, lw=0.8, label=name)
    for jump in (*loop.approach_jumps, *loop.retraction_jumps):
        after = jump.after.height, jump.after.normal_force / NN
        before = jump.before.height, jump.before.normal_force / NN
        axes.annotate("", after, before, arrowprops={"arrowstyle": "->"})
    for i, (name, force) in enumerate((pull_off_forces or {}).items()):
        line = DASHES[i % len(DASHES)]
        axes.axhline(force / NN, color="k", ls=line, lw=0.8, label=name)
    axes.set_xlabel("height of the indenter (Å)")
    axes.set_ylabel("normal force $N$ (nN)")
    axes.legend()
    return axes


def plot_convergence(
    axes: Any,
    curves: Mapping[str, tuple[ArrayLike, ArrayLike]],
    xlabel: str = "steps of the optimizer",
    ylabel: str = "largest force (eV/Å)",
) -> Any:
    """Errors that are left, against what it cost to get there.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    curves : mapping of str to (array_like, array_like)
        Costs and errors, both of shape (k,), by name. Errors of zero are left out.
    xlabel, ylabel : str
        What they are, with their units.

    Returns
    -------
    matplotlib Axes

    Raises
    ------
    ValueError
        If costs or errors are not finite, or there are not as many of one as of the
        other.
    """
    for i, (name, (cost, error)) in enumerate(curves.items()):
        x, y = finite_array("costs", cost), abs(finite_array("errors", error))
        if x.shape != y.shape or x.ndim != 1:
            raise ValueError(
                f"{name}: costs and errors must be lists of one length, got shapes "
                f"{x.shape} and {y.shape}"
            )
        axes.plot(x[y > 0], y[y > 0], LINES[i % 4], label=name)
    axes.set_yscale("log")
    axes.set_xlabel(xlabel)
    axes.set_ylabel(ylabel)
    axes.legend()
    return axes
