"""Figures of adhesion loops, and of their force curves on a cantilever."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.path_kinds.loop.cantilever import CantileverCurve
from ase_roughcontact.path_kinds.loop.instabilities import AdhesionLoop
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import (
    BRANCHES,
    DASHES,
    GREY,
    add_jump,
    add_right_scale,
    legend_below,
)

NN, NM = UNITS["nN"], UNITS["nm"]


def plot_loop(
    axes: Any,
    loop: AdhesionLoop,
    pull_off_forces: Mapping[str, float] | None = None,
    theory: Mapping[str, tuple[ArrayLike, ArrayLike]] | None = None,
) -> Any:
    """Plot force against depth of an adhesion loop, with arrows at instabilities.

    The depth is the penetration of the `LoadStep`, positive into the solid. Error bars
    are twice the estimated errors of the force.

    Parameters
    ----------
    axes : matplotlib Axes
    loop : AdhesionLoop
        Loop from `adhesion_loop`.
    pull_off_forces : mapping of str to float, optional
        Pull-off forces of theories by label (eV/Å).
    theory : mapping of str to (array_like, array_like), optional
        Penetrations (Å) and forces (eV/Å) of theories, by label. They are drawn within
        the limits of the loop.

    Returns
    -------
    matplotlib Axes
    """
    first_contact = loop.approach[0].height + loop.approach[0].penetration
    for name, colour, width in BRANCHES:
        steps = getattr(loop, name)
        heights, forces = loop.curve(name)
        depths = first_contact - heights
        axes.plot(depths, forces / NN, "-", color=colour, lw=width, label=name)
        rows = [(s.penetration, s.normal_force / NN, s.force_error / NN) for s in steps]
        x, y, error = np.transpose(rows)
        axes.plot(x, y, "o", color=colour, ms=2)
        axes.errorbar(x, y, 2.0 * error, fmt="none", ecolor=GREY, lw=1)
    for jump in loop.jumps:
        before = jump.before.penetration, jump.before.normal_force / NN
        after = jump.after.penetration, jump.after.normal_force / NN
        add_jump(axes, before, after)
    for i, (label, force) in enumerate((pull_off_forces or {}).items()):
        line = DASHES[i % len(DASHES)]
        axes.axhline(-force / NN, color="k", ls=line, lw=0.8, label=label)
    axes.set(xlabel="depth (Å)", ylabel="normal force $N$ (nN)")
    limits = axes.axis()
    for i, (label, (along, values)) in enumerate((theory or {}).items()):
        depth, level = np.asarray(along), np.asarray(values) / NN
        axes.plot(depth, level, f"k{DASHES[i % len(DASHES)]}", lw=0.8, label=label)
    axes.axis(limits)
    axes.legend()
    return axes


def draw_loop(
    file: Path,
    loop: AdhesionLoop,
    pull_off_forces: Mapping[str, float],
    theory: Mapping[str, tuple[ArrayLike, ArrayLike]],
) -> None:
    """Write the figure of an adhesion loop.

    Parameters
    ----------
    file : path
    loop, pull_off_forces, theory
        See `plot_loop`.
    """
    with written(file, 3.4) as figure:
        axes = figure.subplots()
        plot_loop(axes, loop, pull_off_forces, theory)
        legend_below(figure, [axes])


def plot_cantilever(axes: Any, curve: CantileverCurve) -> Any:
    """Plot force against distance of a cantilever, with its deflection at the right.

    Parameters
    ----------
    axes : matplotlib Axes
    curve : CantileverCurve
        Force curve from `cantilever_curve`.

    Returns
    -------
    matplotlib Axes
    """
    axes.axhline(0.0, color=GREY, lw=0.6)
    for name, colour, width in BRANCHES:
        branch = getattr(curve, name)
        x, force = branch.distance / NM, branch.force / NN
        axes.plot(x, force, "-", color=colour, lw=width, label=name)
        for jump in branch.jumps:
            distance = jump.distance / NM
            before = distance, jump.force_before / NN
            after = distance, jump.force_after / NN
            add_jump(axes, before, after)
    add_right_scale(axes, "deflection (nm)", NN / NM / curve.stiffness)
    axes.set_xlabel("distance of the base $D$ (nm)")
    axes.set_ylabel("normal force $N$ (nN)")
    axes.legend()
    return axes
