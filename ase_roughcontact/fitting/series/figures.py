"""Maps of the fits of many curves, a histogram, and parameters over their numbers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LogNorm, Normalize
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter, StrMethodFormatter

from ase_roughcontact._util.units import UNITS, pressure_unit
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.series.grid import MapGrid, grid_of
from ase_roughcontact.fitting.series.row import FittedCurve
from ase_roughcontact.fitting.series.summary import is_good, known_values
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import BLUE, GREY, ORANGE, letter

# Smallest ratio of the largest and smallest value on a logarithmic scale.
_MIN_LOGARITHMIC_RATIO = 10.0
# Percentiles of the values at which the colours of a map end.
_COLOUR_PERCENTILES = (2.0, 98.0)
# Largest number of curves for which they end at the lowest and the largest value.
_MAX_CURVES_WITH_ALL_COLOURS = 50
# Smallest half range of the colours, relative to their middle.
_MIN_COLOUR_RANGE = 0.005
# Largest number of bins of a histogram.
_MAX_BINS = 40
# Smallest and largest height of a map in the figure (inches).
_MAP_HEIGHTS = (1.4, 4.0)
# Labels of the drawn quantities, and their units.
_LABELS = {
    "contact_modulus": ("contact modulus", "Pa"),
    "relaxation_time": ("relaxation time (s)", ""),
    "pull_off_force": ("pull-off force", "nN"),
    "work_of_adhesion": ("work of adhesion", "J/m²"),
    "contact_height": ("contact point", "nm"),
    "misfit": ("residual / noise", ""),
}
# Drawn quantities with a standard error.
_WITH_ERRORS = "contact_modulus", "work_of_adhesion", "contact_height"


def draw_series(curves: Sequence[FittedCurve], folder: Path) -> list[Path]:
    """Draw maps, or parameters over the number of the curve, and a histogram.

    Parameters
    ----------
    curves : sequence of FittedCurve
        Results in the order of the measurement.
    folder : path
        Folder for ``maps.png``, or ``series.png`` if the curves were not measured at
        several places, and ``histogram.png``.

    Returns
    -------
    list of Path
        Written files; empty if there is no value.
    """
    shown = [name for name in _LABELS if known_values(curves, name).size]
    if not shown:
        return []
    places = {(each.x, each.y) for each in curves if np.isfinite(each.x + each.y)}
    files = [folder / ("maps.png" if len(places) > 1 else "series.png")]
    if len(places) > 1:
        draw_maps(curves, shown, files[0])
    else:
        draw_parameters(curves, shown, files[0])
    if known_values(curves, "contact_modulus").size > 1:
        files.append(folder / "histogram.png")
        draw_histogram(curves, files[-1])
    return files


def draw_maps(curves: Sequence[FittedCurve], names: Sequence[str], file: Path) -> None:
    """Draw maps of quantities over the places of the curves.

    Parameters
    ----------
    curves : sequence of FittedCurve
    names : sequence of str
        Attributes of `FittedCurve`.
    file : path
        Picture to write.
    """
    grid = grid_of(curves)
    rows = (len(names) + 1) // 2
    height = 2.6
    if grid is not None:
        columns, lines = abs(grid.spacing) * grid.shape
        height = float(np.clip(0.5 + 2.1 * lines / columns, *_MAP_HEIGHTS))
    with written(file, height * rows, width=6.8) as figure:
        panels = list(figure.subplots(rows, 2, squeeze=False).flat)
        for axes in panels[len(names) :]:
            axes.remove()
        panels = panels[: len(names)]
        for axes, name in zip(panels, names, strict=True):
            values, label, _ = _shown(curves, name)
            norm = _scale(values, name != "contact_height")  # which has no zero
            style: dict[str, Any] = {"norm": norm, "cmap": "viridis"}
            if grid is None:
                x, y, unit = _places(curves)
                image = axes.scatter(x, y, c=values, s=12, **style)
            else:
                image, unit = _draw_grid(axes, grid, values, style)
            axes.set(xlabel=f"$x$ ({unit})", ylabel=f"$y$ ({unit})", aspect="equal")
            bar = figure.colorbar(
                image, label=label, extend=_extend(values, image.norm)
            )
            if isinstance(image.norm, LogNorm):
                _label_decades(bar.ax.yaxis)
        letter(panels)


def draw_histogram(curves: Sequence[FittedCurve], file: Path) -> None:
    """Draw a histogram of the contact modulus, with median and quartiles.

    Parameters
    ----------
    curves : sequence of FittedCurve
    file : path
        Picture to write.
    """
    values, label, _ = _shown(curves, "contact_modulus")
    values = values[np.isfinite(values)]
    is_log = values.max() > _MIN_LOGARITHMIC_RATIO * values.min()
    scale = np.log10(values) if is_log else values
    count = min(len(np.histogram_bin_edges(scale, "auto")), _MAX_BINS)
    edges = np.linspace(scale.min(), scale.max(), count + 1)
    if scale.min() == scale.max():
        edges = scale.min() + np.array([-0.5, 0.5]) * max(abs(scale.min()), 1.0) * 0.01
    with written(file, 2.6) as figure:
        axes = figure.subplots()
        bins = list(10.0**edges if is_log else edges)
        axes.hist(values, bins, color=BLUE, alpha=0.7)
        low, middle, high = np.percentile(values, (25.0, 50.0, 75.0))
        axes.axvline(middle, color=ORANGE, lw=1.5, label=f"median {middle:.3g}")
        axes.axvspan(low, high, color=GREY, alpha=0.2, lw=0, label="quartiles")
        axes.set(xlabel=label, ylabel="number of curves")
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))
        if is_log:
            axes.set_xscale("log")
            _label_decades(axes.xaxis)
        axes.legend(title=f"{len(values)} curves")


def draw_parameters(
    curves: Sequence[FittedCurve], names: Sequence[str], file: Path
) -> None:
    """Draw quantities over the number of the curve, with standard errors.

    Parameters
    ----------
    curves : sequence of FittedCurve
    names : sequence of str
        Attributes of `FittedCurve`.
    file : path
        Picture to write.
    """
    numbers = np.arange(1, len(curves) + 1)
    with written(file, 0.6 + 1.3 * len(names)) as figure:
        shape = len(names), 1
        panels = list(figure.subplots(*shape, sharex=True, squeeze=False).flat)
        for axes, name in zip(panels, names, strict=True):
            values, label, scale = _shown(curves, name)
            errors = None
            if name in _WITH_ERRORS:
                found = [getattr(each, f"{name}_error") for each in curves]
                errors = np.array(found) / scale
            axes.errorbar(numbers, values, errors, fmt="o", ms=3, color=BLUE, lw=0.8)
            axes.set_ylabel(label.replace(" (", "\n("))
            if isinstance(_scale(values, name != "contact_height"), LogNorm):
                axes.set_yscale("log")
                _label_decades(axes.yaxis)
        for number, each in zip(numbers, curves, strict=True):
            if not is_good(each):
                panels[0].axvline(number, color=ORANGE, lw=0.6, ls=":")
        panels[-1].set_xlabel("number of the curve")
        panels[-1].xaxis.set_major_locator(MaxNLocator(integer=True))
        letter(panels)


def _shown(curves: Sequence[FittedCurve], name: str) -> tuple[FloatArray, str, float]:
    """Return values of the curves that did not fail, NaN of others, label and unit."""
    values = np.array(
        [getattr(each, name) if is_good(each) else np.nan for each in curves], float
    )
    label, unit = _LABELS[name]
    if name == "contact_modulus":
        unit = pressure_unit(float(np.nanmedian(values)))
    if name == "contact_height":  # the zero of the scanner is arbitrary
        values = values - np.nanmin(values)
        unit = "um" if np.nanmax(values) > 10.0 * UNITS["um"] else "nm"
    if not unit:
        return values, label, 1.0
    label = f"{label} ({unit.replace('um', 'µm')})"
    return values / UNITS[unit], label, UNITS[unit]


def _scale(values: FloatArray, may_be_log: bool) -> Normalize:
    """Return the scale of values, logarithmic over more than a decade."""
    is_few = np.isfinite(values).sum() < _MAX_CURVES_WITH_ALL_COLOURS
    low, high = np.nanpercentile(
        values, (0.0, 100.0) if is_few else _COLOUR_PERCENTILES
    )
    if may_be_log and low > 0.0 and high > _MIN_LOGARITHMIC_RATIO * low:
        return LogNorm(low, high)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    half = max(half, _MIN_COLOUR_RANGE * abs(middle)) or 1.0
    return Normalize(middle - half, middle + half)


def _label_decades(axis: Any) -> None:
    """Label 1, 2 and 5 of each decade of a logarithmic axis."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def _extend(values: FloatArray, norm: Any) -> str:
    """Return at which ends of a colour bar there are further values."""
    ends = np.nanmin(values) < norm.vmin, np.nanmax(values) > norm.vmax
    return {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[ends]


def _draw_grid(
    axes: Any, grid: MapGrid, values: FloatArray, style: dict[str, Any]
) -> tuple[Any, str]:
    """Draw values on a grid; return the image and the unit of its coordinates."""
    unit = _length_unit(max(abs(grid.spacing) * grid.shape))
    edges = [edge / UNITS[unit] for edge in grid.extent]
    axes.set_facecolor("0.85")  # no value
    image = axes.imshow(
        grid.values(values),
        origin="lower",
        extent=edges,
        interpolation="nearest",
        **style,
    )
    return image, unit.replace("um", "µm")


def _places(curves: Sequence[FittedCurve]) -> tuple[FloatArray, FloatArray, str]:
    """Return the coordinates of the curves, and their unit."""
    places = np.array([(each.x, each.y) for each in curves], float)
    sizes = np.nanmax(places, axis=0) - np.nanmin(places, axis=0)
    unit = _length_unit(float(sizes.max()))
    x, y = places.T / UNITS[unit]
    return x, y, unit.replace("um", "µm")


def _length_unit(length: float) -> str:
    """Return nm, um or mm for coordinates over some length (Å)."""
    return next((u for u in ("mm", "um") if length > 2.0 * UNITS[u]), "nm")
