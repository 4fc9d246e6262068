"""Figures of sliding paths: friction loops, areas of stick and slip, tractions."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.analysis.path_values import turning_points
from ase_roughcontact.contact.state import SLIPPING, TRACTIONS
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import BLUE, GREY, ORANGE, add_arrow, letter
from ase_roughcontact.plot.surfaces import (
    map_of,
    map_panels,
    pixels_of,
    scale_bar,
    show_as_scanned,
)

_NN, _NM, _GPA = UNITS["nN"], UNITS["nm"], UNITS["GPa"]
# Margin of maps beside contacts.
_MARGIN = 1.1
# Smallest force, or change of a force, that is drawn, relative to the largest force.
_MIN_RELATIVE_FORCE = 0.01
# Smallest lateral force, relative to its bound, with which the bound is drawn.
_MIN_BOUND_RATIO = 0.5


def plot_friction_loop(
    axes: Any,
    steps: Sequence[Any],
    towards: Sequence[float] | FloatArray = (1.0, 0.0),
    bounds: bool = False,
    color: str = BLUE,
    label: str = "along the path",
) -> Any:
    """Plot the lateral force over the lateral displacement, with arrows along the way.

    Parameters
    ----------
    axes : matplotlib Axes
    steps : sequence of SlidingStep
    towards : (float, float)
        Unit vector along which displacement and force are drawn; a force across it is
        drawn, too, unless it is small.
    bounds : bool
        Whether dashed lines are drawn at the forces at which all atoms slip, if the
        lateral force exceeds half of them.
    color, label : str
        Colour and label of the force along the path.

    Returns
    -------
    matplotlib Axes
    """
    x = _displacements(steps, towards)
    forces = np.array([[s.lateral_force_x, s.lateral_force_y] for s in steps]) / _NN
    along, across = forces @ towards, forces @ [-towards[1], towards[0]]
    limit = np.array([s.largest_friction for s in steps]) / _NN
    if bounds and abs(along).max() > _MIN_BOUND_RATIO * limit.max():
        order = np.arange(len(x))
        if (
            np.ptp(limit) < _MIN_RELATIVE_FORCE * limit.max()
        ):  # one line of dashes, not several
            order = x.argsort()
        axes.plot(x[order], limit[order], "--", color=GREY, lw=0.8, label="all slip")
        axes.plot(x[order], -limit[order], "--", color=GREY, lw=0.8)
    axes.plot(x, along, ".-", color=color, label=label)
    for start, end in pairwise(turning_points(x)):
        add_arrow(axes, x[start : end + 1], along[start : end + 1], color)
    if abs(across).max() > _MIN_RELATIVE_FORCE * abs(along).max():
        axes.plot(x, across, ".-", color=ORANGE, label="across it")
    axes.set(xlabel=_label(towards), ylabel="lateral force (nN)")
    return axes


def plot_slip_areas(
    axes: Any,
    steps: Sequence[Any],
    towards: Sequence[float] | FloatArray = (1.0, 0.0),
    over_distance: bool = False,
) -> Any:
    """Plot the areas of stick and slip over the lateral displacement.

    Parameters
    ----------
    axes, steps, towards
        See `plot_friction_loop`.
    over_distance : bool
        Whether areas are plotted over the distance travelled, which does not turn;
        dotted lines are where the displacement does.

    Returns
    -------
    matplotlib Axes
    """
    x, label = _displacements(steps, towards), _label(towards)
    if over_distance:
        turns = turning_points(x)[1:-1]
        x, label = np.append(0.0, abs(np.diff(x)).cumsum()), "distance travelled (nm)"
        for turn in turns:
            axes.axvline(x[turn], color=GREY, lw=0.8, ls=":")
    for name, colour in (("stick", BLUE), ("slip", ORANGE)):
        area = np.array([getattr(s, f"{name}_area") for s in steps]) / _NM**2
        axes.plot(x, area, ".-", color=colour, label=name)
    axes.set(xlabel=label, ylabel="area (nm$^2$)")
    return axes


def plot_tractions(
    axes: Any, shown: Atoms | ContactMap, largest: float | None = None
) -> Any:
    """Draw a map of the lateral tractions, in blue where atoms stick, else in orange.

    Parameters
    ----------
    axes : matplotlib Axes
    shown : Atoms or ContactMap
        Frame or map of a sliding path; see `plot_contact` and `ContactMap.lateral`.
    largest : float, optional
        Traction at the end of the colour scales (GPa).

    Returns
    -------
    matplotlib Axes
        The images of the tractions of atoms that stick and slip (GPa), for colour bars,
        are ``axes.images[0]`` and ``axes.images[1]``.
    """
    contact_map = map_of(shown)
    size = _tractions(contact_map) / _GPA
    largest = largest or float(size.max()) or None
    slips = contact_map.lateral[SLIPPING] > 0.0
    for part, colours in ((~slips, "Blues"), (slips, "Oranges")):
        axes.imshow(
            np.where(contact_map.contact & part, size, np.nan).T,
            cmap=colours,
            vmin=-0.2 * (largest or 0.0),  # not white
            vmax=largest,
            **pixels_of(contact_map),
        )
    i, j = contact_map.contact.nonzero()
    if i.size:
        largest_x = float(abs(contact_map.x[i]).max())
        largest_y = float(abs(contact_map.y[j]).max())
        reach = _MARGIN * max(largest_x, largest_y) / _NM
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach))
    return axes


def draw_friction(
    file: Path,
    steps: Sequence[Any],
    towards: Sequence[float] | FloatArray = (1.0, 0.0),
) -> None:
    """Write the figure of a sliding path: forces over displacement, and areas.

    Parameters
    ----------
    file : path
    steps, towards
        See `plot_friction_loop`.
    """
    with written(file, 4.8) as figure:
        panels = upper, lower = figure.subplots(2, 1)
        plot_friction_loop(upper, steps, towards, bounds=True)
        plot_slip_areas(lower, steps, towards, over_distance=True)
        letter(panels)
        for panel in panels:  # above, where no line is
            panel.locator_params(axis="x", nbins=5)
            panel.legend(
                loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderpad=0.0
            )


def draw_tractions(
    file: Path, frames: Sequence[Atoms], titles: Sequence[str], scanned: str = ""
) -> None:
    """Write the figure of the lateral tractions of some frames.

    Parameters
    ----------
    file : path
    frames : sequence of Atoms
        See `plot_tractions`.
    titles : sequence of str
        Titles of the maps.
    scanned : str
        See `show_as_scanned`.
    """
    largest = max(_tractions(ContactMap.from_frame(each)).max() for each in frames)
    rows, columns = -(-len(frames) // 2), min(len(frames), 2)
    with written(file, 1.5 + rows * (3.0 / columns + 0.2)) as figure:
        panels = map_panels(figure, len(frames))
        for panel, frame, title in zip(panels, frames, titles, strict=True):
            plot_tractions(panel, frame, largest / _GPA)
            panel.set_title(title, loc="right")
            show_as_scanned(panel, scanned)
            scale_bar(panel, "nm")
        letter(panels)
        for image, name in zip(panel.images, ("stick", "slip"), strict=True):
            # other anchors of the panels cut their titles
            bar = figure.colorbar(
                image, ax=panels, location="bottom", aspect=40, panchor=False
            )
            bar.set_label(f"traction of atoms that {name} (GPa)")
            bar.ax.set_xlim(left=0.0)


def _displacements(
    steps: Sequence[Any], towards: Sequence[float] | FloatArray
) -> FloatArray:
    points = np.array([[s.lateral_x, s.lateral_y] for s in steps])
    return points @ towards / _NM


def _label(towards: Sequence[float] | FloatArray) -> str:
    """Return the label of displacements, with their direction unless it is x."""
    angle = f"{np.degrees(np.arctan2(towards[1], towards[0])):.4g}"
    where = {"0": "", "90": "along y "}.get(angle, f"at {angle}\N{DEGREE SIGN} from x ")
    return f"displacement {where}(nm)"


def _tractions(contact_map: ContactMap) -> FloatArray:
    """Return the magnitudes of the tractions of friction (eV/Å^3)."""
    return np.hypot(*(contact_map.lateral[key] for key in TRACTIONS))
