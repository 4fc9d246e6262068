"""Means of an ensemble on one HTML page: the answer, a chart, a figure, tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.printing import Table, number
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli.page import PageTable, rendered
from ase_roughcontact.cli.page_data import chart_column
from ase_roughcontact.ensemble.study import (
    StudyPoint,
    numeric_values,
    parameter_label,
)

_CAPTION = (
    "Means over the realisations of the roughness, with standard errors; band: scatter "
    "of one realisation; dashed: theory."
)
_GOOD = "All means are of converged realisations within the limits of the model."
# Standard errors of a change that is more than scatter.
_SIGNIFICANT = 2.0

# Points of a column, its heading and unit in print, and its printed table with notes.
Column = tuple[Sequence[StudyPoint], str, str, Sequence[Any]]


def page_of_study(
    title: str,
    scene: str,
    over: str,
    columns: Sequence[Column],
    files: tuple[Path, Path],
) -> str:
    """Return the page of a study.

    Parameters
    ----------
    title : str
    scene : str
        Text of the scene file.
    over : str
        Parameter of the figure.
    columns : sequence of Column
        What the study shows.
    files : (path, path)
        Table and figure of the study.

    Returns
    -------
    str
        HTML, without references to other files.
    """
    table, figure = files
    tables = []
    for _, _, _, (printed, *notes) in columns:
        assert isinstance(printed, Table)
        heads = [(*_head_and_unit(head), "") for head in printed.heads]
        rows = [(False, [(text, "") for text in row]) for row in printed.rows]
        tables.append(PageTable(heads, rows, [str(note) for note in notes]))
    points = [point for column in columns for point in column[0]]
    return rendered(
        title=title,
        scene=scene,
        answer=answer_of_study(over, columns[0]),
        rows="means",
        count=len(points),
        good=_GOOD,
        explained="",
        warnings=_warnings(points, _labels(columns)),
        inputs={},
        results={},
        figures=[(figure.name, figure.read_bytes(), _CAPTION)],
        stresses=[],
        data=data_of_study(over, columns),
        saved=[table],
        tables=tables,
    )


def answer_of_study(over: str, column: Column) -> str:
    """Return how a mean changes from the first to the last value of a parameter.

    Parameters
    ----------
    over : str
        The parameter.
    column : Column
        What is averaged. Points with other values of the other parameters, or another
        target, than the first point are left out.
    """
    points, heading, unit, _ = column
    first, last = 0, 0
    for i, point in enumerate(points):
        others = {**point.values, over: points[0].values[over]}
        targets = points[0].mean.target, point.mean.target
        same = math.isnan(targets[0]) or targets[0] == targets[1]
        if others == points[0].values and same:
            last = i
    labels, errors, ends = _labels([column]), [], []
    for i in (first, last):
        mean = points[i].mean
        errors.append(abs(mean.mean) * mean.error)
        value = number(mean.mean / UNITS[unit])
        error = number(errors[-1] / UNITS[unit], 2)
        ends.append(f"{value} ± {error} {unit} at {labels[i]}".replace("  ", " "))
    change = points[last].mean.mean - points[first].mean.mean
    text = f"The mean {heading.partition(' (')[0]} is {ends[0]}"
    if last:
        text += f", and {ends[1]}"
    if last and abs(change) < _SIGNIFICANT * math.hypot(*errors):
        text += ", which differ by less than twice the standard error"
    count = points[0].mean.realisations
    return f"{text}; {count} realisation{'s' if count != 1 else ''}."


def data_of_study(over: str, columns: Sequence[Column]) -> dict[str, Any]:
    """Return means, errors, scatter and theory for the chart of a page.

    Parameters
    ----------
    over : str
        Parameter that is drawn along the horizontal axis.
    columns : sequence of Column
        Their points are rows of the chart, one column after the other.

    Returns
    -------
    dict
        See `data_of_run`.
    """
    points = [point for column in columns for point in column[0]]
    found = []
    for key in points[0].values:
        try:
            values, unit = numeric_values(key, [point.values[key] for point in points])
        except ValueError:
            continue
        found.append(chart_column(key, unit, values, label=parameter_label(key)))
    start = 0
    for of_column, heading, unit, _ in columns:
        here, scale = slice(start, start + len(of_column)), UNITS[unit]
        start += len(of_column)
        name, label = of_column[0].mean.column, heading.partition(" (")[0]
        means = np.array([point.mean.mean for point in of_column]) / scale
        errors = abs(means) * [point.mean.error for point in of_column]
        more = {
            "scatter": [point.mean.scatter / scale for point in of_column],
            "theory": [point.theory / scale for point in of_column],
        }
        every = [_filled(each, here, len(points)) for each in (means, errors)]
        found.append(chart_column(name, unit, every[0], every[1], label))
        for what, values in more.items():
            if np.isfinite(values).any():
                filled, words = _filled(values, here, len(points)), f"{what} of {label}"
                found.append(chart_column(f"{name}_{what}", unit, filled, label=words))
    return {
        "columns": found,
        "rows": "row",
        "labels": _labels(columns),
        "filters": _filters(columns),
        "x": over,
        "y": points[0].mean.column,
        "lines": False,
        "theory": None,
        "maps": None,
    }


def _parameters(columns: Sequence[Column]) -> list[dict[str, str]]:
    """Return the printed parameters and the target of each row of the chart."""
    found = []
    for _, heading, _, (printed, *_) in columns:
        names = printed.heads[: list(printed.heads).index(heading)]
        found += [dict(zip(names, row, strict=False)) for row in printed.rows]
    return found


def _labels(columns: Sequence[Column]) -> list[str]:
    """Return the parameters and the target of each row of the chart in words."""
    return [
        ", ".join(f"{name} {text}" for name, text in row.items())
        for row in _parameters(columns)
    ]


def _filters(columns: Sequence[Column]) -> list[dict[str, Any]]:
    """Return the parameters with several values, by which rows may be chosen."""
    rows = _parameters(columns)
    found = []
    for name in dict.fromkeys(name for row in rows for name in row):
        values = [row.get(name, "") for row in rows]
        if len(set(values) - {""}) > 1:
            found.append({"label": name, "values": values})
    return found


def _filled(values: Any, here: slice, count: int) -> np.ndarray:
    """Return values in some of several rows, NaN in the others."""
    filled = np.full(count, np.nan)
    filled[here] = values
    return filled


def _head_and_unit(head: str) -> tuple[str, str]:
    """Return name and unit of a heading: "area (nm²)"."""
    name, _, unit = head.partition(" (")
    return name, unit.rstrip(")")


def _warnings(points: Sequence[StudyPoint], labels: Sequence[str]) -> list[str]:
    """Return warnings of realisations that failed or exceed limits of the model."""
    found = []
    for point, label in zip(points, labels, strict=True):
        mean = point.mean
        if mean.validity:
            found.append(f"{label}: {mean.validity}")
        if mean.failed:
            found.append(f"{label}: {mean.failed} realisations failed or have no value")
        if mean.unknown:
            found.append(f"{label}: errors are not known: {mean.unknown}")
    return list(dict.fromkeys(found))
