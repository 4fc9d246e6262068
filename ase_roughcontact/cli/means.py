"""Means over realisations of the roughness as printed tables and lines of JSON."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from ase_roughcontact._util.printing import note, number, table
from ase_roughcontact._util.units import UNITS, printed_unit
from ase_roughcontact.cli import report
from ase_roughcontact.cli.common import json_line
from ase_roughcontact.ensemble import MeanValue, Sampling
from ase_roughcontact.ensemble.study import unit_of
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.printed import units_in_print

# Attributes of a mean that need a wanted error.
_SAMPLING_ATTRIBUTES = "expected", "likely"
#: Relative error of the values above which it is printed.
MIN_PRINTED_ERROR = 0.001


def printed_units(scene: Scene, column: str) -> str:
    """Return the unit in which a result or a column of steps is printed."""
    if column in scene.path.results:
        unit = scene.path.results[column].unit
        return printed_unit(unit, scene.contact_modulus)
    return units_in_print(scene)[column]


def column_heading(scene: Scene, column: str) -> str:
    """Return the heading of a result or a column of steps, with its printed unit."""
    if column not in scene.path.results:
        return report.heading(scene, column)
    label = scene.path.results[column].label or column.replace("_", " ")
    unit = printed_units(scene, column)
    return f"{label} ({unit})" if unit else label


def means_lines(
    scene: Scene,
    settings: Mapping[str, Any],
    means: Sequence[MeanValue],
    sampling: Sampling | None = None,
) -> Iterator[str]:
    """Yield a line of JSON for each mean, with the values of the keys that are set."""
    for mean in means:
        units = {"mean": unit_of(scene, mean.column)}
        units["scatter"] = units["mean"]
        if not math.isnan(mean.target):
            units["target"] = report.target_unit(scene)
        values = asdict(mean)
        if sampling is None:
            values = {k: v for k, v in values.items() if k not in _SAMPLING_ATTRIBUTES}
        given = {key: unit for key, unit in units.items() if unit}
        yield json_line({**settings, **values}, given)


def means_table(
    scene: Scene, means: Sequence[MeanValue], sampling: Sampling | None = None
) -> list[Any]:
    """Return a table of means with notes: limits, failed realisations, needed ones.

    Parameters
    ----------
    scene : Scene
        One of the realisations.
    means : sequence of MeanValue
        Means of one column at all targets, or of several results of the path.
    sampling : Sampling, optional
        State of an ensemble that grows to a wanted error.
    """
    notes = list[Any]()
    reasons = Counter(mean.unknown for mean in means if mean.unknown)
    for reason, count in reasons.items():
        notes.append(
            f"Errors are not known in {count} of {len(means)} {_rows(means)}: {reason}."
        )
    count = sum(mean.is_below_errors for mean in means)
    if count:
        notes.append(
            f"{count} of {len(means)} {_rows(means)} are zero within the errors of the "
            "values, which more realisations do not reduce."
        )
    failed = max((mean.failed for mean in means), default=0)
    if failed:
        notes.append(
            note(
                f"Mean without up to {failed} realisations that failed, did not "
                "converge or have no value: unless these are random, it is biased.",
                style="yellow",
            )
        )
    notes += lower_bound_notes(scene, means)
    limits = dict.fromkeys(mean.validity for mean in means if mean.validity)
    if limits:
        # the last step has the largest contact of most paths
        notes.append(
            note(
                f"* outside of the validity of the model: {[*limits][-1]}", 0, "yellow"
            )
        )
    if sampling is not None:
        notes += _needed(sampling, bool(reasons or count))
    return [_table(scene, means, sampling is not None), *notes]


def lower_bound_notes(scene: Scene, means: Sequence[MeanValue]) -> Iterator[Any]:
    """Yield a note for each column with values that are lower bounds."""
    most: dict[str, MeanValue] = {}
    for mean in means:
        largest = most.setdefault(mean.column, mean)
        if mean.lower_bounds > largest.lower_bounds:
            most[mean.column] = mean
    for column, mean in most.items():
        if mean.lower_bounds:
            text = (
                f"{column_heading(scene, column)}: a lower bound in "
                f"{mean.lower_bounds} of {mean.realisations} realisations, and so is "
                "the mean: go deeper before the retraction."
            )
            yield note(text, style="yellow")


def _rows(means: Sequence[MeanValue]) -> str:
    return "results" if math.isnan(means[0].target) else "steps"


def _needed(sampling: Sampling, some_unknown: bool) -> list[str]:
    """Return whether the wanted error is reached, or what it needs."""
    wanted = f"standard error of {100.0 * sampling.wanted:g} %"
    if sampling.done:
        others = "other " if some_unknown else ""
        return [f"All {others}means have a {wanted} or less."]
    if not sampling.missing:
        return []
    least, largest = sampling.likely_missing
    unit = "steps" if sampling.progress.unit == "steps" else "realisations"
    needed = f"{sampling.missing} more {unit} (likely {least} to {largest})"
    return [f"About {needed} for a {wanted}."]


def _table(scene: Scene, means: Sequence[MeanValue], with_expected: bool) -> Any:
    """Return the table of means, of one column in steps or of several results."""
    of_results = math.isnan(means[0].target)
    unit = printed_unit(report.target_unit(scene))
    heads = ["result", "mean"]
    if not of_results:
        target = "time" if unit == "s" else scene.path.control
        heading = column_heading(scene, means[0].column)
        heads = [f"{target} ({unit})", f"mean {heading}"]
    heads += ["standard error (%)", "scatter", "realisations"]
    with_error = any(mean.value_error >= MIN_PRINTED_ERROR for mean in means)
    with_marks = any(mean.validity for mean in means)
    if with_error:
        heads.append("value error (%)")
    if with_expected:
        heads.append("expected (likely)")
    if with_marks:
        heads.append("")
    rows = []
    for mean in means:
        name: Any = column_heading(scene, mean.column)
        if not of_results:
            name = mean.target / UNITS[unit]
        scale = UNITS[printed_units(scene, mean.column)]
        count: Any = mean.realisations
        if mean.failed:
            count = f"{mean.realisations} of {mean.realisations + mean.failed}"
        row = [
            name,
            mean.mean / scale,
            number(100.0 * mean.error, 2),
            number(mean.scatter / scale, 2),
            count,
        ]
        if with_error:
            row.append(number(100.0 * mean.value_error, 2))
        if with_expected:
            row.append(_expected(mean))
        if with_marks:
            row.append("*" if mean.validity else "")
        rows.append(row)
    return table(heads, rows, left=1 if of_results else 0)


def _expected(mean: MeanValue) -> str:
    if mean.unknown or mean.is_below_errors:
        return "-"
    least, largest = mean.likely
    return f"{mean.expected} ({least} to {largest})"
