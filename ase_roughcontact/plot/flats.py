"""Figures of nominally flat contacts against the nominal pressure.

The functions take arrays, or steps in place of the pressures.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ase_roughcontact import theory
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.plot.step_columns import column_of_steps, is_steps
from ase_roughcontact.plot.style import GREY, ORANGE, add_right_scale
from ase_roughcontact.results.record import LoadStep, columns_of

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
    pressure: np.ndarray | Sequence[LoadStep],
    fraction: ArrayLike | None = None,
    scale: float | None = None,
    error: ArrayLike = 0.0,
) -> Any:
    """Plot the contact fraction of a rough flat against the nominal pressure.

    Beside it are Persson's theory and ``A/A0 = kappa p/(h' E*)`` of hard walls.

    Parameters
    ----------
    axes : matplotlib Axes
    pressure : ndarray, shape (k,), or sequence of LoadStep
        Nominal pressures, positive (eV/Å^3). Steps of a flat, such as `Results`, have
        contact areas and their errors, too.
    fraction : array_like, shape (k,), optional
        Contact fractions A/A0.
    scale : float
        The pressure ``h' E*``, with the rms slope h' (eV/Å^3).
    error : array_like, shape (k,), optional
        Estimated errors of the fractions; error bars show twice the estimate.

    Returns
    -------
    matplotlib Axes
    """
    if is_steps(pressure):
        steps, pressure = pressure, column_of_steps(pressure, "nominal_pressure")
        per_area = pressure / column_of_steps(steps, "normal_force")
        fraction = per_area * column_of_steps(steps, "contact_area")
        error = per_area * column_of_steps(steps, "area_error")
    if fraction is None or scale is None:
        raise TypeError(
            "plot_flat_area needs a scale, and steps, or pressures and fractions"
        )
    pressure = np.asarray(pressure)
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


def plot_flat_gap(
    axes: Any,
    pressure: np.ndarray | Sequence[LoadStep],
    gap: ArrayLike | None = None,
) -> Any:
    """Plot the mean gap of a rough flat against the nominal pressure.

    Parameters
    ----------
    axes : matplotlib Axes
    pressure : ndarray, shape (k,), or sequence of LoadStep
        Nominal pressures (eV/Å^3), or steps of a flat.
    gap : array_like, shape (k,), optional
        Mean gaps (Å).

    Returns
    -------
    matplotlib Axes
    """
    if is_steps(pressure):
        gap = column_of_steps(pressure, "mean_gap")
        pressure = column_of_steps(pressure, "nominal_pressure")
    if gap is None:
        raise TypeError("plot_flat_gap needs steps, or pressures and gaps")
    pressure = np.asarray(pressure)
    _pressure_axis(axes, pressure)
    axes.plot(pressure / _MPA, np.asarray(gap) / _NM, "o-", color=ORANGE, lw=0.8)
    axes.set_ylabel("mean gap (nm)")
    return axes


def plot_flat_conductance(
    axes: Any,
    pressure: np.ndarray | Sequence[LoadStep],
    stiffness: np.ndarray | None = None,
    modulus: float | None = None,
    conductance: np.ndarray | None = None,
) -> Any:
    """Plot the contact stiffness of a rough flat, and its conductance at the right.

    The scales are those on which both agree for the elastic contact of a hard wall
    without attraction.

    Parameters
    ----------
    axes : matplotlib Axes
    pressure : ndarray, shape (k,), or sequence of LoadStep
        Nominal pressures (eV/Å^3). Steps of a flat have stiffnesses, and conductances
        if they were asked for.
    stiffness : ndarray, shape (k,), optional
        Normal stiffness of the contact (eV/Å^2).
    modulus : float
        Contact modulus E* (eV/Å^3).
    conductance : ndarray, shape (k,), optional
        Conductance times the sum of the resistivities (Å).

    Returns
    -------
    matplotlib Axes
    """
    if is_steps(pressure):
        steps, pressure = pressure, column_of_steps(pressure, "nominal_pressure")
        stiffness = column_of_steps(steps, "contact_stiffness")
        if "conductance" in columns_of(type(steps[0])):
            conductance = column_of_steps(steps, "conductance")
    if stiffness is None or modulus is None:
        raise TypeError(
            "plot_flat_conductance needs a modulus, and steps, or pressures and "
            "stiffnesses"
        )
    pressure, unit = np.asarray(pressure), UNITS["N/m"]
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
