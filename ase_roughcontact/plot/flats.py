"""Figures of nominally flat contacts against the nominal pressure."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact import theory
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.plot.style import GREY, ORANGE, add_right_scale

# One megapascal in ASE's unit of pressure, eV/Å^3.
_MPA = UNITS["MPa"]
# One nanometre (Å).
_NM = UNITS["nm"]
# Number of points of a curve of theory.
_CURVE_POINTS = 60
# Factor by which a curve of theory exceeds the steps.
_CURVE_EXTENT = 1.5


def plot_flat_area(
    axes: Any,
    pressure: np.ndarray,
    fraction: ArrayLike,
    scale: float,
    error: ArrayLike = 0.0,
) -> Any:
    """Plot the contact fraction of a rough flat against the nominal pressure.

    Beside it are Persson's theory and ``A/A0 = kappa p/(h' E*)`` of hard walls.

    Parameters
    ----------
    axes : matplotlib Axes
    pressure : ndarray, shape (k,)
        Nominal pressures, positive (eV/Å^3).
    fraction : array_like, shape (k,)
        Contact fractions A/A0.
    scale : float
        The pressure ``h' E*``, with the rms slope h' (eV/Å^3).
    error : array_like, shape (k,), optional
        Estimated errors of the fractions; error bars show twice the estimate.

    Returns
    -------
    matplotlib Axes
    """
    low, high = _pressure_axis(axes, pressure)
    along = np.geomspace(low, high, _CURVE_POINTS)
    rough = theory.mean_contact_pressure(scale, 1.0, theory.KAPPA_PERSSON)
    persson = theory.contact_fraction(along, rough)
    linear = theory.KAPPA_HARD * along / scale
    axes.plot(along / _MPA, persson, "k-", lw=1, label="Persson")
    label = rf"$\kappa p/(h' E^*)$, $\kappa = {theory.KAPPA_HARD:g}$"
    axes.plot(along / _MPA, np.where(linear < 1.0, linear, np.nan), "k--", label=label)
    bars = np.broadcast_to(2.0 * np.asarray(error), pressure.shape)
    axes.errorbar(pressure / _MPA, fraction, bars, fmt="none", ecolor=ORANGE, lw=1)
    axes.plot(pressure / _MPA, fraction, "o", color=ORANGE, label="simulation")
    axes.set(yscale="log", ylabel="contact area $A/A_0$")
    return axes


def plot_flat_gap(axes: Any, pressure: np.ndarray, gap: ArrayLike) -> Any:
    """Plot the mean gap of a rough flat (Å) against the nominal pressure (eV/Å^3)."""
    _pressure_axis(axes, pressure)
    axes.plot(pressure / _MPA, np.asarray(gap) / _NM, "o-", color=ORANGE, lw=0.8)
    axes.set_ylabel("mean gap (nm)")
    return axes


def plot_flat_conductance(
    axes: Any,
    pressure: np.ndarray,
    stiffness: np.ndarray,
    modulus: float,
    conductance: np.ndarray | None = None,
) -> Any:
    """Plot the contact stiffness of a rough flat, and its conductance at the right.

    The scales are those on which both agree for the elastic contact of a hard wall
    without attraction.

    Parameters
    ----------
    axes : matplotlib Axes
    pressure : ndarray, shape (k,)
        Nominal pressures (eV/Å^3).
    stiffness : ndarray, shape (k,)
        Normal stiffness of the contact (eV/Å^2).
    modulus : float
        Contact modulus E* (eV/Å^3).
    conductance : ndarray, shape (k,), optional
        Conductance times the sum of the resistivities (Å).

    Returns
    -------
    matplotlib Axes
    """
    unit = UNITS["N/m"]
    _pressure_axis(axes, pressure)
    axes.plot(
        pressure / _MPA, stiffness / unit, "o-", color=ORANGE, lw=0.8, label="stiffness"
    )
    axes.set(yscale="log", ylabel="contact stiffness $k$ (N/m)")
    if conductance is not None:
        scaled = 0.5 * modulus * conductance / unit
        axes.plot(pressure / _MPA, scaled, "s--", color=GREY, ms=3, label="conductance")
        axes.tick_params(which="both", right=False)
        label = "conductance\n× resistivity (nm)"
        add_right_scale(axes, label, 2.0 * unit / modulus / _NM, color=GREY)
        axes.legend()
    return axes


def _pressure_axis(axes: Any, pressure: np.ndarray) -> tuple[float, float]:
    """Set up the axis of nominal pressures; return its ends."""
    low, high = pressure.min() / _CURVE_EXTENT, pressure.max() * _CURVE_EXTENT
    axes.set(xlim=(low / _MPA, high / _MPA), xlabel="nominal pressure $p$ (MPa)")
    axes.set_xscale("log")
    return low, high
