"""Figures: each function draws into the axes that it is given. Needs matplotlib.

::

    with style():
        figure, axes = pyplot.subplots()
        plot_loop(axes, loop, {"JKR": jkr_pull_off_force(radius, work)})
        figure.savefig("loop.pdf")

Lengths are shown in nm, forces in nN, pressures in GPa; arguments are in ASE's units,
unless it says otherwise.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
from ase import Atoms
from ase.units import GPa, J, m
from cycler import cycler
from matplotlib import rc_context
from matplotlib.ticker import LogLocator
from numpy.typing import ArrayLike

from ase_roughcontact.analysis import radial_average
from ase_roughcontact.checks import finite_array
from ase_roughcontact.contactmap import ContactMap
from ase_roughcontact.hysteresis import AdhesionLoop
from ase_roughcontact.selfaffine import SelfAffine
from ase_roughcontact.spectrum import power_spectrum

# Okabe and Ito's palette, told apart by all kinds of colour vision.
BLUE, ORANGE, GREY = "#0072B2", "#D55E00", "#7F7F7F"
COLOURS = (BLUE, ORANGE, "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_DASHES = ("--", ":", "-.")

_NM, _NN = 10.0, 1e-9 * J / m


def style() -> AbstractContextManager:
    """Defaults for figures in print, as a context.

    A column of a journal wide (86 mm), letters of 8 points, ticks inside on all sides,
    Okabe and Ito's colours, and 300 dots per inch where a file needs dots.

    Returns
    -------
    context manager
        Figures made within have the defaults; those made outside do not.
    """
    ticks = {
        f"{side}tick.{key}": value
        for side in "xy"
        for key, value in (("direction", "in"), ("labelsize", 7))
    }
    sides = {"xtick.top": True, "ytick.right": True}
    return rc_context(
        {
            "figure.figsize": (3.4, 2.6),
            "figure.constrained_layout.use": True,
            "savefig.dpi": 300,
            "font.size": 8,
            "axes.linewidth": 0.6,
            "axes.prop_cycle": cycler(color=COLOURS),
            "lines.linewidth": 1.0,
            "lines.markersize": 3.5,
            "legend.fontsize": 7,
            "legend.frameon": False,
            "pdf.fonttype": 42,
            **ticks,
            **sides,
        }
    )


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
    axes.yaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_minor_locator(LogLocator(subs=(2.0, 5.0)))
    axes.yaxis.set_minor_formatter("{x:g}")
    axes.set_xlabel("normal force $N$ (nN)")
    axes.set_ylabel(r"contact area $A/A_\mathrm{Hertz}$")
    axes.legend(frameon=False, loc="best")
    return axes


def plot_contact(
    axes: Any,
    frame: Atoms,
    hertz_radius: float | None = None,
    largest: float | None = None,
    title: str = "",
    first_contact_radius: float | None = None,
) -> Any:
    """Map of the pressure on the atoms in contact, seen from above.

    The map is cut to the contact and the circles.

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
    first_contact_radius : float, optional
        a', the radius of a second, dashed circle (Å).

    Returns
    -------
    matplotlib image
        Of the pressure in GPa, for a colour bar.
    """
    seen = ContactMap.from_frame(frame)
    shown = np.where(seen.contact, seen.pressure / GPa, np.nan)
    x, y, half = seen.x / _NM, seen.y / _NM, 0.5 * seen.spacing / _NM
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
    reach = 0.0
    for radius, line in ((hertz_radius, "k-"), (first_contact_radius, "k--")):
        if radius is not None:
            reach = max(reach, radius / _NM)
            _circle(axes, radius / _NM, line)
    for places, along in ((x, 1), (y, 0)):
        reach = max(reach, abs(places[seen.contact.any(axis=along)]).max(initial=0.0))
    reach = 1.15 * reach + 2.0 * half
    axes.set_xlim(-reach, reach)
    axes.set_ylim(-reach, reach)
    axes.set_xlabel("$x$ (nm)")
    axes.set_ylabel("$y$ (nm)")
    axes.set_title(title)
    return image


def plot_pressure(
    axes: Any,
    contact_map: ContactMap,
    hertz_radius: float | None = None,
    bins: int | ArrayLike | None = None,
) -> Any:
    r"""Pressure against the distance from the axis, averaged over rings.

    .. math:: p_\text{Hertz}(r) = \frac{3N}{2\pi a^2} \sqrt{1 - r^2/a^2}

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    contact_map : ContactMap
        The contact.
    hertz_radius : float, optional
        a, the contact radius of a smooth sphere under the same force (Å).
    bins : int or array_like, optional
        Rings, see `radial_average`.

    Returns
    -------
    matplotlib Axes
    """
    average = radial_average(contact_map, bins)
    radius = average.radius / _NM
    # rings without an atom in contact have no pressure in contact, not zero
    axes.plot(radius, average.contact_pressure / GPa, "o", label="atoms in contact")
    axes.plot(radius, average.pressure / GPa, "-", label="all atoms")
    if hertz_radius is not None:
        r = np.linspace(0.0, hertz_radius, 201)
        peak = 1.5 * contact_map.normal_force / (np.pi * hertz_radius**2)
        hertz = peak * np.sqrt(1.0 - (r / hertz_radius) ** 2)
        axes.plot(r / _NM, hertz / GPa, "k--", label="smooth sphere (Hertz)")
    axes.set_xlim(left=0.0)
    axes.set_xlabel("distance from the axis $r$ (nm)")
    axes.set_ylabel("pressure $p$ (GPa)")
    axes.legend()
    return axes


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
        forces = [record.normal_force / _NN for record in records]
        axes.plot(heights, forces, "o-", color=colour, ms=2, lw=0.8, label=name)
    for jump in (*loop.approach_jumps, *loop.retraction_jumps):
        after = jump.after.height, jump.after.normal_force / _NN
        before = jump.before.height, jump.before.normal_force / _NN
        axes.annotate("", after, before, arrowprops={"arrowstyle": "->"})
    for i, (name, force) in enumerate((pull_off_forces or {}).items()):
        line = _DASHES[i % len(_DASHES)]
        axes.axhline(force / _NN, color="k", ls=line, lw=0.8, label=name)
    axes.set_xlabel("height of the indenter (Å)")
    axes.set_ylabel("normal force $N$ (nN)")
    axes.legend()
    return axes


def plot_spectrum(
    axes: Any,
    heights: np.ndarray,
    spacing: float,
    roughness: SelfAffine | None = None,
    label: str = "measured",
) -> Any:
    r"""Power spectrum of periodic heights, beside that of a self-affine surface.

    .. math:: C(q) = C_0 \max(q, q_L)^{-2(1+H)}, \qquad
              C_0 = 2\pi h'^2 \left[\frac{q_L^4 - q_0^4}{4\,q_L^{2(1+H)}}
                    + \frac{q_s^{2(1-H)} - q_L^{2(1-H)}}{2(1-H)}\right]^{-1}

    with :math:`q_L = 2\pi/\lambda_L`, from the longest wave :math:`q_0` to
    :math:`q_s = 2\pi/\lambda_s`; so :math:`h'^2 = \int q^2 C(q)\,d^2q/(2\pi)^2`.

    Parameters
    ----------
    axes : matplotlib Axes
        Where to draw.
    heights : ndarray, shape (n, m)
        Heights (Å).
    spacing : float
        Distance between them (Å).
    roughness : SelfAffine, optional
        Whose law is drawn.
    label : str
        Name of the heights.

    Returns
    -------
    matplotlib Axes
    """
    q, density = power_spectrum(heights, spacing)
    seen = density > 1e-12 * density.max()  # not the rounding beyond the last wave
    axes.loglog(q[seen] * _NM, density[seen] / _NM**4, "o", label=label)
    if roughness is not None:
        ends, law = _self_affine_law(roughness)
        axes.loglog(ends * _NM, law / _NM**4, "k-", label=r"$q^{-2(1+H)}$")
    axes.set_xlabel("wave number $q$ (nm$^{-1}$)")
    axes.set_ylabel("power spectral density $C$ (nm$^4$)")
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
        line = ("-", *_DASHES)[i % 4]
        axes.plot(x[y > 0], y[y > 0], line, label=name)
    axes.set_yscale("log")
    axes.set_xlabel(xlabel)
    axes.set_ylabel(ylabel)
    axes.legend()
    return axes


def _circle(axes: Any, radius: float, line: str) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    axes.plot(radius * np.cos(angle), radius * np.sin(angle), line, lw=1)


def _self_affine_law(rough: SelfAffine) -> tuple[np.ndarray, np.ndarray]:
    """Return the ends of the parts of C(q), and its values there."""
    longest = rough.longest_wavelength or rough.long_wavelength
    waves = np.array([longest, rough.long_wavelength, rough.short_wavelength])
    q = 2 * np.pi / waves
    first, middle, last = q
    fall, power = 2.0 * (1.0 + rough.hurst), 2.0 * (1.0 - rough.hurst)
    flat = (middle**4 - first**4) / (4.0 * middle**fall)
    slopes = flat + (last**power - middle**power) / power
    scale = 2 * np.pi * rough.rms_slope**2 / slopes
    return q, scale * np.maximum(q, middle) ** -fall
