"""Fits of many force curves on one HTML page: the answer, a chart, maps, a table."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.printing import number
from ase_roughcontact._util.units import UNITS, pressure_unit
from ase_roughcontact.cli.answers import median_in_words
from ase_roughcontact.cli.page import PageTable, rendered
from ase_roughcontact.cli.page_data import chart_column, grid_maps
from ase_roughcontact.fitting.series.grid import grid_of
from ase_roughcontact.fitting.series.row import CURVE_UNITS, FittedCurve
from ase_roughcontact.fitting.series.summary import SeriesSummary, is_good

# Columns of the table, with the columns of their errors.
_SHOWN = {
    "contact_modulus": "contact_modulus_error",
    "work_of_adhesion": "work_of_adhesion_error",
    "pull_off_force": "",
    "contact_height": "contact_height_error",
    "largest_indentation": "",
    "residual": "",
    "noise": "",
}
# Unit of the places.
_LENGTH = "\N{MICRO SIGN}m"
_PRESSURES = "contact_modulus", "contact_modulus_error", "instantaneous_modulus"
_CAPTIONS = {
    "maps.png": "Results on the map; grey: curves without a result.",
    "series.png": "Results over the number of the curve, with standard errors.",
    "histogram.png": "Histogram of the contact moduli.",
}
_GOOD = "All curves were read and fitted, without a doubt."


def page_of_curves(curves: Sequence[FittedCurve], folder: Path) -> str:
    """Return the page of the fits of many curves.

    Parameters
    ----------
    curves : sequence of FittedCurve
        Results in the order of the measurement.
    folder : path
        Folder with ``curves.csv`` and the figures.

    Returns
    -------
    str
        HTML, without references to other files.
    """
    summary, units = SeriesSummary(curves), _units(curves)
    warnings = [
        f"{count} curves failed: {reason}" for count, reason in summary.failures
    ]
    warnings += [f"doubt of {count} curves: {doubt}" for count, doubt in summary.doubts]
    known = [name for name in units if np.isfinite(_values(curves, name)).any()]
    shown = [name for name in _SHOWN if name in known]
    heads = [("curve", "", "file and number")]
    heads += [(name.replace("_", " "), units[name], "") for name in shown]
    rows = []
    for curve in curves:
        cells = [_cell(curve, name, units[name]) for name in shown]
        rows.append((not is_good(curve), [(_label(curve), ""), *cells]))
    return rendered(
        title=folder.resolve().name,
        scene="",
        answer=answer_of_curves(curves),
        rows="curves",
        count=len(curves),
        good=_GOOD,
        explained="± is the standard error by noise.",
        warnings=warnings,
        inputs={},
        results={},
        figures=[
            (name, (folder / name).read_bytes(), text)
            for name, text in _CAPTIONS.items()
            if (folder / name).is_file()
        ],
        stresses=[],
        data=_data(curves, known, units) if known else None,
        saved=[folder / "curves.csv"],
        tables=[PageTable(heads, rows)],
    )


def answer_of_curves(curves: Sequence[FittedCurve]) -> str:
    """Return the median of the modulus, or of the pull-off force, with quartiles."""
    summary = SeriesSummary(curves)
    failed = sum(count for count, _ in summary.failures)
    names = "contact_modulus", "pull_off_force"
    quartiles = summary.quartiles
    name = next((each for each in names if each in quartiles), "")
    if not name:
        return f"There is no result: {failed} of {len(curves)} curves failed."
    middle = float(quartiles[name][1])
    unit = pressure_unit(middle) if name == "contact_modulus" else "nN"
    words = {"contact_modulus": "contact modulus", "pull_off_force": "pull-off force"}
    text = median_in_words(words[name], quartiles[name], unit, "curves")
    return f"{text}; {failed} of {len(curves)} curves failed."


def _units(curves: Sequence[FittedCurve]) -> dict[str, str]:
    """Return the units of the page: of moduli by their size."""
    moduli = _values(curves, "contact_modulus")
    units = {**CURVE_UNITS, "x": _LENGTH, "y": _LENGTH}
    if np.isfinite(moduli).any():
        unit = pressure_unit(float(np.nanmedian(moduli)))
        units |= dict.fromkeys(_PRESSURES, unit)
    return {**units, "misfit": ""}


def _values(curves: Sequence[FittedCurve], name: str) -> np.ndarray:
    """Return an attribute of the curves in ASE's units; NaN of curves that failed."""
    return np.array([getattr(c, name) if is_good(c) else math.nan for c in curves])


def _data(
    curves: Sequence[FittedCurve], known: Sequence[str], units: dict[str, str]
) -> dict[str, Any]:
    """Return columns for the chart, and maps if the curves are on a grid."""
    values = {name: _values(curves, name) / UNITS[units[name]] for name in known}
    columns = [chart_column("curve", "", np.arange(1.0, len(curves) + 1.0))]
    for name in known:
        error = values.get(f"{name}_error")
        columns.append(chart_column(name, units[name], values[name], error))
    grid, maps = grid_of(curves), None
    drawn = [name for name in known if name not in ("x", "y")]
    if grid is not None and drawn:
        flipped = tuple(slice(None, None, -1 if d < 0 else 1) for d in grid.spacing)
        found = {k: (grid.values(values[k]).T[flipped], units[k]) for k in drawn}
        last = grid.first + grid.spacing * (np.array(grid.shape) - 1)
        ends = np.sort([grid.first, last], axis=0) / UNITS[_LENGTH]
        (left, low), (right, high) = ends.tolist()
        maps = grid_maps(found, (left, right), (low, high), _LENGTH)
    main = next(name for name in ("contact_modulus", *known) if name in known)
    return {
        "columns": columns,
        "rows": "curve",
        "labels": [_label(curve) for curve in curves],
        "x": "curve",
        "y": main,
        "lines": False,
        "theory": None,
        "maps": maps,
    }


def _label(curve: FittedCurve) -> str:
    """Return the names of a curve in its file."""
    member = f" {curve.member}" if curve.member else ""
    return f"{Path(curve.file).name}{member} {curve.number}"


def _cell(curve: FittedCurve, name: str, unit: str) -> tuple[str, str]:
    """Return a value and its error as text."""
    value = getattr(curve, name)
    if math.isnan(value):
        return "not known", ""
    error = getattr(curve, _SHOWN[name]) if _SHOWN[name] else math.nan
    text = number(value / UNITS[unit]).replace("-", "\N{MINUS SIGN}")
    return text, "" if math.isnan(error) else number(error / UNITS[unit], 2)
