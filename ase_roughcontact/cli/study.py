"""What an ensemble varies and shows: [study] of a scene, options, table and figure."""

from __future__ import annotations

import argparse
import math
import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ase_roughcontact._util.files import check_replaced, replaced
from ase_roughcontact._util.printing import number, show, table, write
from ase_roughcontact._util.units import UNITS, printed_unit, with_unit
from ase_roughcontact._util.validation import shown
from ase_roughcontact.cli import report
from ase_roughcontact.cli.common import prints_text, scene_text
from ase_roughcontact.cli.means import (
    MIN_PRINTED_ERROR,
    column_heading,
    lower_bound_notes,
    printed_units,
)
from ase_roughcontact.ensemble.cases import combinations
from ase_roughcontact.ensemble.means import check_column, default_column
from ase_roughcontact.ensemble.study import (
    SEED,
    StudyPoint,
    drawn_over,
    is_seed,
    parameter_label,
    study_points,
    write_study,
)
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.file import load_toml
from ase_roughcontact.scene.study import StudyConfig, range_values

# A value of a list that is separated by commas: a string, a list, a table or others.
_VALUE_PATTERN = re.compile(
    r"""(?:"[^"]*"|'[^']*'|\[[^]]*\]|\{[^}]*\}|[^,])+?(?=,|$)"""
)
# A range: first, last, number of values and, if given, the scale.
_RANGE_PATTERN = re.compile(r"([^:]+):([^:]+):(\d+)(?::(\w+))?")


@dataclass(frozen=True)
class Study:
    """What an ensemble varies, and what it shows.

    Attributes
    ----------
    scene : Scene
        Scene without its section [study].
    values : dict
        Values by key, also of the seeds.
    error : float or None
        Wanted relative standard error of the means.
    columns : tuple of str
        Columns that are averaged; empty for the default.
    over : str
        Parameter of the figure; empty without one.
    together : tuple of str
        Keys that vary together.
    """

    scene: Scene
    values: dict[str, list[Any]]
    error: float | None
    columns: tuple[str, ...]
    over: str
    together: tuple[str, ...]

    @classmethod
    def of(cls, options: argparse.Namespace) -> Study:
        """Return the study of a scene file, changed by options.

        Raises
        ------
        ValueError
            If keys or columns are unknown, the seeds are given twice, or keys that vary
            together have different numbers of values.
        """
        scene = Scene.parse(*scene_text(options))
        section = scene.study or StudyConfig()
        scene = replace(scene, study=None)
        given = _given_values(options.set)
        error = section.error if options.error is None else options.error
        values = {key: list(each) for key, each in section.parameters.items()} | given
        seeds_given = [key for key in given if is_seed(key)]
        if options.error is not None and seeds_given:
            raise ValueError(f"--error chooses the seeds: omit --set {seeds_given[0]}")
        has_seeds = section.seeds or any(map(is_seed, section.parameters))
        if section.error is not None and has_seeds:
            raise ValueError("[study] error chooses the seeds: omit seeds")
        if options.error is not None:
            values = {key: each for key, each in values.items() if not is_seed(key)}
        elif section.seeds and not seeds_given:
            first = scene.seed
            if first is None:
                raise ValueError(
                    "[study] seeds need [roughness], or seed in [topography]"
                )
            values[SEED] = list(range(first, first + section.seeds))
        if seeds_given:
            error = None
        columns = tuple(options.column or section.columns or ())
        over = drawn_over(values, options.over or section.over)
        found = cls(scene, values, error, columns, over, section.together)
        combinations(values, found.together)  # raises if numbers of values differ
        for column in columns:
            check_column(found.variant, column)
        return found

    @property
    def variant(self) -> Scene:
        """The scene with the first value of each key."""
        return self.scene.with_values({key: v[0] for key, v in self.values.items()})

    @property
    def seeds(self) -> dict[str, list[Any]]:
        """Values of the seeds, over which means are taken, by key."""
        return {key: each for key, each in self.values.items() if is_seed(key)}

    @property
    def parameters(self) -> dict[str, list[Any]]:
        """Values of all other keys."""
        return {key: each for key, each in self.values.items() if not is_seed(key)}

    @property
    def realisations(self) -> int:
        """Number of realisations of the roughness for each combination of values."""
        return math.prod(map(len, self.seeds.values()))

    @property
    def shown_columns(self) -> tuple[str, ...]:
        """Columns of table and figure: the given ones, or the default."""
        return self.columns or (default_column(self.variant),)

    def files(self, database: str) -> tuple[Path, Path, Path]:
        """Return the names of table, figure and page, beside the database."""
        root = "roughcontact" if "://" in database else os.path.splitext(database)[0]
        csv, png, html = (Path(f"{root}-study.{end}") for end in ("csv", "png", "html"))
        return csv, png, html

    def check_files(self, database: str) -> None:
        """Raise `ValueError` if a table would replace one of another program."""
        if self.over:
            check_replaced(self.files(database)[0], b"column,unit")


def show_study(
    options: argparse.Namespace, study: Study, seeds: Sequence[int] | None = None
) -> None:
    """Print, write and draw the means of a study, and write its page.

    Parameters
    ----------
    options : argparse.Namespace
        Options of the command.
    study : Study
    seeds : sequence of int, optional
        Seeds that replace the seeds of the study.
    """
    # import matplotlib and jinja2
    from ase_roughcontact.cli.study_page import page_of_study
    from ase_roughcontact.ensemble.figures import draw_study

    values = dict(study.values)
    if seeds is not None:
        values[SEED] = list(seeds)
    scene, units, panels = study.variant, dict[str, str](), dict[str, Any]()
    every, columns = list[StudyPoint](), []
    for column in study.shown_columns:
        points = study_points(
            study.scene, values, options.database, column, study.together
        )
        heading, every = column_heading(scene, column), every + points
        panels[heading], units[heading] = points, printed_units(scene, column)
        printed = _study_table(scene, points, study)
        columns.append((points, heading, units[heading], printed))
        if prints_text(options):
            show("", *printed)
    csv, png, html = study.files(options.database)
    write_study(csv, every)
    draw_study(png, panels, study.over, units, _targets(scene, every))
    text, _ = scene_text(options)
    page = page_of_study(html.stem, text, study.over, columns, (csv, png))
    with replaced(html) as name:
        Path(name).write_text(page, encoding="utf-8")
    if prints_text(options):
        write(f"\n{csv}\n{png}\n{html}")


def _study_table(scene: Scene, points: Sequence[StudyPoint], study: Study) -> list[Any]:
    """Return the table of a column, with notes."""
    column = points[0].mean.column
    scale = UNITS[printed_units(scene, column)]
    varied = [key for key in points[0].values if len(study.values[key]) > 1]
    targets = _targets(scene, points)
    with_theory = any(point.theory_name for point in points)
    heads = [*map(parameter_label, varied), *["target"] * bool(targets)]
    heads.append(column_heading(scene, column))
    heads += ["scatter", "realisations", *["theory"] * with_theory, ""]
    rows = []
    for point in points:
        mean = point.mean
        total = mean.realisations + mean.failed
        count = f"{mean.realisations} of {total}" if mean.failed else mean.realisations
        row: list[Any] = [str(point.values[key]) for key in varied]
        if targets:
            row.append(targets[mean.target])
        error = abs(mean.mean) * mean.error / scale
        row.append(f"{number(mean.mean / scale)} ± {number(error, 2)}")
        row += [number(mean.scatter / scale, 2), count]
        row += [point.theory / scale] * with_theory
        rows.append([*row, "*" * bool(mean.validity)])
    notes = ["±: standard error of the mean; scatter: standard deviation of one."]
    if any(point.mean.realisations == 2 for point in points):
        notes.append("Errors of two realisations are too uncertain for bars.")
    value_errors = [
        abs(mean.mean) * mean.value_error
        for mean in (point.mean for point in points)
        if mean.value_error >= MIN_PRINTED_ERROR
    ]
    if value_errors:
        notes.append(
            f"Grid, window and steps change single values by up to "
            f"{number(max(value_errors) / scale, 2)}, which more seeds do not reduce."
        )
    names = dict.fromkeys(point.theory_name for point in points if point.theory_name)
    notes += [f"Theory: {name}." for name in names]
    if any(point.mean.validity for point in points):
        notes.append("* outside of the validity of the model: see column validity")
    if any(point.mean.failed for point in points):
        notes.append("Means are without realisations that failed, or have no value.")
    bounds = lower_bound_notes(scene, [point.mean for point in points])
    return [table(heads, rows, left=len(varied)), *notes, *bounds]


def _targets(scene: Scene, points: Sequence[StudyPoint]) -> dict[float, str]:
    """Return texts for the targets of several steps; none for results of a path."""
    targets = dict.fromkeys(point.mean.target for point in points)
    known = [target for target in targets if not math.isnan(target)]
    if not known:
        return {}
    unit = printed_unit(report.target_unit(scene))
    return {target: with_unit(target, unit) for target in known}


def _given_values(options: Sequence[str]) -> dict[str, list[Any]]:
    """Return the values by key of options ``--set``."""
    values: dict[str, list[Any]] = {}
    for key, listed in map(_values_of_key, options):
        if key in values:
            raise ValueError(f"--set {key} is given twice: give all values in one")
        values[key] = listed
    return values


def _values_of_key(text: str) -> tuple[str, list[Any]]:
    """Return key and values of ``section.key=value,value`` or ``=first:last:steps``."""
    key, equals, values = (part.strip() for part in text.partition("="))
    found = _RANGE_PATTERN.fullmatch(values)
    if equals and found:
        first, last = map(_value, found.groups()[:2])
        scale = found[4] or "linear"
        return key, list(range_values(key, first, last, int(found[3]), scale))
    listed = [_value(part.strip()) for part in _VALUE_PATTERN.findall(values)]
    if not equals or not listed:
        raise ValueError(
            "--set must be SECTION.KEY=VALUE,VALUE,... or SECTION.KEY=FIRST:LAST:STEPS"
            f", got {shown(text)}"
        )
    return key, listed


def _value(text: str) -> Any:
    """Return a value as in a scene file; strings need no quotes."""
    try:
        return load_toml(f"value = {text}")["value"]
    except ValueError:
        return text
