"""Maps of contacts, and radial profiles of the pressure."""

from __future__ import annotations

from typing import Any

import numpy as np
from ase import Atoms
from ase.units import GPa
from matplotlib.colors import PowerNorm

from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.analysis import ContactMap, radial_average
from ase_roughcontact.atoms.calculator import RoughContact

NM = UNITS["nm"]


def plot_contact(
    axes: Any,
    shown: Atoms | ContactMap,
    hertz_radius: float | None = None,
    largest: float | None = None,
    title: str = "",
    first_contact_radius: float | None = None,
    circle_label: str = "smooth sphere (Hertz)",
    around_load: bool = False,
    unit: str = "GPa",
    exponent: float = 1.0,
) -> Any:
    """Draw a map of the pressure on the atoms in contact.

    Attracted atoms are grey. The map is limited to the contact and the circles, which
    have labels for a legend.

    Parameters
    ----------
    axes : matplotlib Axes
    shown : Atoms or ContactMap
        Frame of a trajectory, atoms with a `RoughContact` calculator, or a map.
    hertz_radius : float, optional
        Radius of a circle (Å).
    largest : float, optional
        Pressure at the end of the colour scale (`unit`).
    title : str
        Title of the map.
    first_contact_radius : float, optional
        a', the radius of a second, dashed circle (Å).
    circle_label : str
        Label of the first circle.
    around_load : bool
        Whether circles and map are centred at the centre of the repulsive pressure, not
        at the axis of the indenter.
    unit : str
        Unit of the pressure.
    exponent : float
        Exponent of the colour scale: below one, small pressures have more colours.

    Returns
    -------
    matplotlib Axes
        The image of the pressure, for a colour bar, is ``axes.images[0]``.
    """
    contacts = map_of(shown)
    pressure = np.where(contacts.contact, contacts.pressure / UNITS[unit], np.nan)
    x, y, pixels = contacts.x / NM, contacts.y / NM, pixels_of(contacts)
    colours = PowerNorm(exponent, vmin=0.0, vmax=largest)
    axes.imshow(pressure.T, cmap="viridis", norm=colours, **pixels)
    if (contacts.pressure < 0.0).any():
        grey = np.where(contacts.pressure < 0.0, 0.2, np.nan)
        axes.imshow(grey.T, cmap="Greys", vmin=0.0, vmax=1.0, **pixels)
        axes.plot([], [], "s", color="lightgrey", label="attracted atoms")
    circles = (
        (hertz_radius, "k-", circle_label),
        (first_contact_radius, "k--", "first contact $a'$"),
    )
    middle, push = np.zeros(2), np.maximum(contacts.pressure, 0.0)
    if around_load and push.any():
        middle = np.array([push.sum(axis=1) @ x, push.sum(axis=0) @ y]) / push.sum()
    reach = _extent(contacts, middle * NM) / NM
    for radius, line, label in circles:
        if radius is not None:
            reach = max(reach, radius / NM)
            _circle(axes, middle, radius / NM, line, label)
    reach = 1.15 * reach + contacts.spacing / NM
    xlim, ylim = np.add.outer(middle, (-reach, reach))
    axes.set(xlim=xlim, ylim=ylim, title=title)
    axes.set(xlabel="$x$ (nm)", ylabel="$y$ (nm)")
    return axes


def map_of(shown: Atoms | ContactMap) -> ContactMap:
    """Return the map of atoms with a calculator, of a frame, or the given map."""
    if isinstance(shown, ContactMap):
        return shown
    if isinstance(shown.calc, RoughContact):
        return ContactMap.from_atoms(shown)
    return ContactMap.from_frame(shown)


def show_as_scanned(axes: Any, scanned: str) -> None:
    """Turn a map on a scan as the scan: its first line at the top, x as measured.

    Parameters
    ----------
    axes : matplotlib Axes
    scanned : str
        Role of the scanned body: the scan of an "indenter" was turned over; empty: the
        map is not changed.
    """
    if scanned:
        axes.invert_yaxis()
        if scanned == "indenter":
            axes.invert_xaxis()


def pixels_of(contacts: ContactMap) -> dict[str, Any]:
    """Return options of `imshow` for a map with the first index along x (nm)."""
    half = 0.5 * contacts.spacing / NM
    x, y = contacts.x / NM, contacts.y / NM
    extent = x[0] - half, x[-1] + half, y[0] - half, y[-1] + half
    return {"origin": "lower", "extent": extent, "interpolation": "none"}


def map_panels(figure: Any, count: int) -> list[Any]:
    """Return axes for some maps, two beside each other."""
    grid = figure.subplots(-(-count // 2), min(count, 2), squeeze=False)
    panels = list(grid.flat)
    for panel in panels[count:]:
        panel.remove()
    return panels[:count]


def scale_bar(axes: Any, unit: str) -> None:
    """Draw a bar of a round length below a map, in place of its axes.

    Parameters
    ----------
    axes : matplotlib Axes
        Axes with equal scales, which may be inverted.
    unit : str
        Unit of the coordinates.
    """
    limits = (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    width = right - left
    longest = 0.4 * abs(width)
    decade = 10.0 ** np.floor(np.log10(longest))
    length = max(n * decade for n in (1, 2, 5) if n * decade <= longest)
    y = bottom - 0.05 * (top - bottom)  # below the frame, where nothing is covered
    left = right - np.copysign(length, width)
    bar: dict[str, Any] = {"lw": 2.5, "solid_capstyle": "butt", "clip_on": False}
    axes.plot([left, right], [y, y], "k-", **bar)
    place: dict[str, Any] = {"textcoords": "offset points", "ha": "right"}
    place |= {"va": "center", "annotation_clip": False}
    axes.annotate(f"{length:g} {unit}", (left, y), (-4, 0), **place)
    axes.set(xlim=limits[0], ylim=limits[1])
    axes.set(xticks=[], yticks=[], xlabel="", ylabel="")


def plot_pressure(
    axes: Any, shown: Atoms | ContactMap, hertz_radius: float | None = None
) -> Any:
    r"""Plot the pressure averaged over rings against the distance from the axis.

    .. math:: p_\text{Hertz}(r) = \frac{3N}{2\pi a^2} \sqrt{1 - r^2/a^2}

    Parameters
    ----------
    axes : matplotlib Axes
    shown : Atoms or ContactMap
        See `plot_contact`.
    hertz_radius : float, optional
        Contact radius a of a smooth sphere under the same force (Å).

    Returns
    -------
    matplotlib Axes
    """
    contact_map = map_of(shown)
    average = radial_average(contact_map)
    radius = average.radius / NM
    # undefined, not zero, for rings without atoms in contact
    axes.plot(radius, average.contact_pressure / GPa, "o", label="atoms in contact")
    axes.plot(radius, average.pressure / GPa, "-", label="all atoms")
    if hertz_radius is not None:
        r = np.linspace(0.0, hertz_radius, 201)
        peak = 1.5 * contact_map.normal_force / (np.pi * hertz_radius**2)
        hertz = peak * np.sqrt(1.0 - (r / hertz_radius) ** 2)
        axes.plot(r / NM, hertz / GPa, "k--", label="smooth sphere (Hertz)")
    axes.set_xlim(left=0.0)
    axes.set(xlabel="distance from the axis $r$ (nm)", ylabel="pressure $p$ (GPa)")
    axes.legend()
    return axes


def _extent(contacts: ContactMap, center: FloatArray) -> float:
    """Return the largest coordinate of an atom in contact, relative to a center."""
    x = contacts.x[contacts.contact.any(axis=1)] - center[0]
    y = contacts.y[contacts.contact.any(axis=0)] - center[1]
    return float(abs(np.append(x, y)).max(initial=0.0))


def _circle(axes: Any, middle: Any, radius: float, line: str, label: str) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    axes.plot(middle[0] + x, middle[1] + y, line, lw=1, label=label)
