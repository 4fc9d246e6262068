"""Figures: area against load, and maps of the contact. Needs matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from ase import Atoms
from ase.units import GPa

from ase_roughcontact.contactmap import ContactMap

# Okabe and Ito's palette, told apart by all kinds of colour vision.
BLUE, ORANGE, GREY = "#0072B2", "#D55E00", "#7F7F7F"


def plot_curve(
    axes: Any,
    load: np.ndarray,
    area: np.ndarray,
    hertz_area: np.ndarray,
    predicted_area: np.ndarray,
) -> Any:
    """Contact area relative to Hertz against load, beside the prediction.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    load : ndarray, shape (k,)
        Normal forces (nN), rising.
    area, hertz_area, predicted_area : ndarray, shape (k,)
        Areas in one unit: simulated, of the smooth sphere, and of Eq. (4).

    Returns
    -------
    matplotlib Axes
    """
    axes.axhline(1.0, color=GREY, lw=1, label="smooth sphere (Hertz)")
    axes.plot(load, predicted_area / hertz_area, "k-", lw=1, label="Eq. (4)")
    axes.plot(load, area / hertz_area, "o", color=ORANGE, ms=5, label="simulation")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("normal force $N$ (nN)")
    axes.set_ylabel(r"contact area $A/A_\mathrm{Hertz}$")
    axes.legend(frameon=False)
    return axes


def plot_contact(
    axes: Any,
    frame: Atoms,
    hertz_radius: float | None = None,
    largest: float | None = None,
    title: str = "",
) -> Any:
    """Map of the pressure on the atoms in contact, seen from above.

    The map is cut to the contact and the circle.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    frame : Atoms
        A snapshot, as it is in a trajectory.
    hertz_radius : float, optional
        Radius of a circle around the indenter's axis (Å).
    largest : float, optional
        Pressure at the end of the colour scale (GPa).
    title : str
        Title of the map.

    Returns
    -------
    matplotlib image
        Of the pressure in GPa, for a colour bar.
    """
    seen = ContactMap.from_frame(frame)
    shown = np.where(seen.contact, seen.pressure / GPa, np.nan)
    x, y, half = seen.x / 10.0, seen.y / 10.0, 0.05 * seen.spacing
    extent = (x[0] - half, x[-1] + half, y[0] - half, y[-1] + half)
    image = axes.imshow(
        shown.T,
        origin="lower",
        extent=extent,
        cmap="viridis",
        vmin=0.0,
        vmax=largest,
        interpolation="none",
    )
    if hertz_radius is not None:
        angle = np.linspace(0.0, 2.0 * np.pi, 181)
        axes.plot(
            hertz_radius / 10.0 * np.cos(angle),
            hertz_radius / 10.0 * np.sin(angle),
            "k-",
            lw=1,
        )
    reach = 0.0 if hertz_radius is None else hertz_radius / 10.0
    for places, along in ((x, 1), (y, 0)):
        reach = max(reach, abs(places[seen.contact.any(axis=along)]).max(initial=0.0))
    reach = 1.15 * reach + 2.0 * half
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_xlabel("$x$ (nm)")
    axes.set_ylabel("$y$ (nm)")
    axes.set_title(title)
    return image
