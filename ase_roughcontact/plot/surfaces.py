"""What is seen on the surface: contacts, their pressure, and roughness."""

from __future__ import annotations

from typing import Any

import numpy as np
from ase import Atoms
from ase.units import GPa
from numpy.typing import ArrayLike

from ase_roughcontact.analysis import radial_average
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.plot.style import NM
from ase_roughcontact.topography.selfaffine import SelfAffine
from ase_roughcontact.topography.spectrum import power_spectrum


def plot_contact(
    axes: Any,
    frame: Atoms,
    hertz_radius: float | None = None,
    largest: float | None = None,
    title: str = "",
    first_contact_radius: float | None = None,
    circle: str = "smooth sphere (Hertz)",
) -> Any:
    """Map of the pressure on the atoms in contact, seen from above.

    Atoms that the wall attracts are grey. The map is cut to the contact and the
    circles, which have labels for a legend.

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
    circle : str
        What the first circle is.

    Returns
    -------
    matplotlib image
        Of the pressure in GPa, for a colour bar.
    """
    seen = ContactMap.from_frame(frame)
    shown = np.where(seen.contact, seen.pressure / GPa, np.nan)
    x, y, half = seen.x / NM, seen.y / NM, 0.5 * seen.spacing / NM
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
    attracted = np.where(seen.pressure < 0.0, 0.2, np.nan)
    if (seen.pressure < 0.0).any():
        axes.imshow(
            attracted.T,
            origin="lower",
            extent=extent,
            cmap="Greys",
            vmin=0.0,
            vmax=1.0,
            interpolation="none",
        )
        axes.plot([], [], "s", color="lightgrey", label="attracted atoms")
    circles = (
        (hertz_radius, "k-", circle),
        (first_contact_radius, "k--", "first contact $a'$"),
    )
    reach = _extent(seen) / NM
    for radius, line, label in circles:
        if radius is not None:
            reach = max(reach, radius / NM)
            _circle(axes, radius / NM, line, label)
    reach = 1.15 * reach + 2.0 * half
    square = -reach, reach
    axes.set(xlim=square, ylim=square, title=title)
    axes.set(xlabel="$x$ (nm)", ylabel="$y$ (nm)")
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
    radius = average.radius / NM
    # rings without an atom in contact have no pressure in contact, not zero
    axes.plot(radius, average.contact_pressure / GPa, "o", label="atoms in contact")
    axes.plot(radius, average.pressure / GPa, "-", label="all atoms")
    if hertz_radius is not None:
        r = np.linspace(0.0, hertz_radius, 201)
        peak = 1.5 * contact_map.normal_force / (np.pi * hertz_radius**2)
        hertz = peak * np.sqrt(1.0 - (r / hertz_radius) ** 2)
        axes.plot(r / NM, hertz / GPa, "k--", label="smooth sphere (Hertz)")
    axes.set_xlim(left=0.0)
    axes.set_xlabel("distance from the axis $r$ (nm)")
    axes.set_ylabel("pressure $p$ (GPa)")
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
    axes.loglog(q[seen] * NM, density[seen] / NM**4, "o", label=label)
    if roughness is not None:
        ends, law = _self_affine_law(roughness)
        axes.loglog(ends * NM, law / NM**4, "k-", label=r"$q^{-2(1+H)}$")
    axes.set_xlabel("wave number $q$ (nm$^{-1}$)")
    axes.set_ylabel("power spectral density $C$ (nm$^4$)")
    axes.legend()
    return axes


def _extent(seen: ContactMap) -> float:
    """Distance from the axis, along x and y, of the farthest atom in contact."""
    x = seen.x[seen.contact.any(axis=1)]
    y = seen.y[seen.contact.any(axis=0)]
    return float(abs(np.append(x, y)).max(initial=0.0))


def _circle(axes: Any, radius: float, line: str, label: str) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    axes.plot(x, y, line, lw=1, label=label)


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
