"""The command ``ensemble``."""

from __future__ import annotations

import argparse
import itertools
import math
import re
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from ase_roughcontact._util.files import check_different, check_replaced
from ase_roughcontact._util.printing import number, show, table, write
from ase_roughcontact._util.units import UNITS, printed_unit
from ase_roughcontact._util.validation import shown
from ase_roughcontact.cli import report
from ase_roughcontact.cli.common import json_line, prints_text, progress_bar, scene_text
from ase_roughcontact.cli.messages import print_error
from ase_roughcontact.ensemble import (
    MeanArea,
    Progress,
    Sampling,
    mean_areas,
    product,
    run_ensemble,
    sample_ensemble,
    write_csv,
)
from ase_roughcontact.ensemble.database import without_password
from ase_roughcontact.ensemble.executors import scheduler_executor
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.file import load_toml

if TYPE_CHECKING:
    from ase_roughcontact._util.tables import Table

# A value of a list that is separated by commas: a string, a list, a table or others.
_VALUE = re.compile(r"""(?:"[^"]*"|'[^']*'|\[[^]]*\]|\{[^}]*\}|[^,])+?(?=,|$)""")
_SEED = "roughness.seed"
# Values of some keys, and the scene that has them.
_Variant: TypeAlias = tuple[dict[str, Any], Scene]
# Attributes printed of a mean area, without a wanted error.
_MEAN = "target", "realisations", "mean", "error", "unknown"


def ensemble(options: argparse.Namespace) -> int:
    r"""Run a scene for all combinations of some values, in parallel.

    The steps are stored in an ASE database. An interrupted ensemble is resumed by
    running it again. Of several seeds the mean areas are printed with their standard
    errors. For five realisations of the roughness on two spheres::

      ase-roughcontact ensemble my.toml --set roughness.seed=0,1,2,3,4 \
                                        --set sphere.radius=100.0,1000.0

    With --error, realisations are added until the standard error of the mean area at
    every step is below it. Each load gets as many as it needs, which a pilot of 8
    predicts, with the range in which nine of ten predictions are right::

      ase-roughcontact ensemble my.toml --error 0.05

    With --scheduler, the workers of a Dask cluster calculate, on any number of
    machines::

      dask scheduler --port 8786
      dask worker tcp://HOST:8786 --nthreads 1
      ase-roughcontact ensemble my.toml --scheduler tcp://HOST:8786

    Exit status: 0 all steps are stored, 1 some cases failed or the error is larger, 2
    the scene or the database is invalid or damaged, 130 interrupted (Ctrl-C), 143
    terminated (SIGTERM).
    """
    scene = Scene.parse(*scene_text(options))
    values: dict[str, list[Any]] = {}
    for key, listed in map(_values_of_key, options.set):
        if key in values:
            raise ValueError(f"--set {key} is given twice: give all values in one")
        values[key] = listed
    if options.error is not None and _SEED in values:
        raise ValueError("--error chooses the seeds: omit --set roughness.seed")
    if options.table:
        check_different(table=options.table, database=options.database)
        check_replaced(Path(options.table), b"case,step")
    variants, pool = _variants(scene, values), {"workers": options.workers}
    with ExitStack() as stack:
        if options.scheduler is not None:
            found = scheduler_executor(options.scheduler)
            pool["executor"], workers = stack.enter_context(found)
            if prints_text(options):
                write(workers)
        draw = stack.enter_context(progress_bar(options))
        enough, failures = _calculate(options, variants, pool, draw)
    seeds = values.pop(_SEED, [])
    if len(seeds) > 1 and not options.quiet:
        for variant in _variants(scene, values):
            realisations = product(variant[1], {_SEED: seeds})
            _print_means(options, variant, mean_areas(realisations, options.database))
    if options.table:
        write_csv(options.database, options.table)
    if prints_text(options):
        database = without_password(options.database)
        write(
            f"Results are in {database}. To list them:\n"
            f"  ase db {database} record=step -c case,step,normal_force,contact_area"
        )
    for case, message in failures.items():
        print_error(f"case {case}: {message}")
    return 0 if enough and not failures else 1


def _variants(scene: Scene, values: dict[str, list[Any]]) -> list[_Variant]:
    """Return the combinations of some values, with the scenes that have them."""
    chosen = itertools.product(*values.values())
    settings = (dict(zip(values, each, strict=True)) for each in chosen)
    return list(zip(settings, product(scene, values), strict=True))


def _calculate(
    options: argparse.Namespace,
    variants: list[_Variant],
    pool: dict[str, Any],
    draw: Callable | None,
) -> tuple[bool, dict[str, str]]:
    """Return whether the error is small enough, and messages of cases that failed."""
    enough, failures = True, dict[str, str]()
    if options.error is None:
        scenes = [scene for _, scene in variants]
        for progress in run_ensemble(scenes, options.database, **pool):
            _print_progress(options, progress, draw)
            failures = progress.failures
        return enough, failures
    for variant in variants:
        samplings = sample_ensemble(variant[1], options.database, options.error, **pool)
        for sampling in samplings:
            _print_progress(options, sampling.progress, draw, sampling.error)
            if sampling.progress.steps == sampling.progress.total:
                _print_means(options, variant, sampling.means, sampling)
        enough &= sampling.done
        failures |= sampling.progress.failures
    return enough, failures


def _print_progress(
    options: argparse.Namespace,
    progress: Progress,
    draw: Callable | None,
    error: float = math.nan,
) -> None:
    """Show the progress, and the largest standard error so far if there is one."""
    known = math.isfinite(error)
    if options.json:
        values = asdict(progress) | ({"error": error} if known else {})
        write(json_line(values, {"elapsed": "s", "left": "s"}))
    elif draw:
        draw(progress.steps, progress.total, str(progress))
    elif not options.quiet:
        running = f", standard error {100.0 * error:.2g} %" if known else ""
        write(f"{progress}{running}")


def _print_means(
    options: argparse.Namespace,
    variant: _Variant,
    means: Sequence[MeanArea],
    sampling: Sampling | None = None,
) -> None:
    """Print the mean areas of a variant, and the realisations that it still needs."""
    settings, scene = variant
    if options.json:
        units = {"mean": "Å^2", "target": report.target_unit(scene)}
        for mean in means:
            shown = {k: v for k, v in asdict(mean).items() if sampling or k in _MEAN}
            write(json_line(settings | shown, units))
    elif not options.quiet:
        heading = ", ".join(f"{key} = {value}" for key, value in settings.items())
        show(*([heading] if heading else []), *means_table(scene, means, sampling))


def means_table(
    scene: Scene, means: Sequence[MeanArea], sampling: Sampling | None = None
) -> list[Any]:
    """Return mean areas, their errors, and the realisations that are still needed."""
    reasons = Counter(mean.unknown for mean in means if mean.unknown)
    notes = [
        f"Errors are not known in {count} of {len(means)} steps: {reason}."
        for reason, count in reasons.items()
    ]
    if sampling is None:
        return [_table(scene, means), *notes]
    wanted = f"standard error of {100.0 * sampling.wanted:g} %"
    if sampling.done:
        others = "other " if reasons else ""
        notes.append(f"All {others}areas have a {wanted} or less.")
    elif sampling.missing:
        likely = "{} to {}".format(*sampling.likely_missing)
        needed = f"About {sampling.missing} more steps (likely {likely})"
        notes.append(f"{needed} for a {wanted}.")
    return [_table(scene, means, more=True), *notes]


def _table(scene: Scene, means: Sequence[MeanArea], more: bool = False) -> Table:
    """Return the table of mean areas; with the realisations to expect if wanted."""
    unit = printed_unit(report.target_unit(scene))
    target = "time" if unit == "s" else scene.path.control
    heads = [f"{target} ({unit})", f"mean {report.heading(scene, scene.area_column)}"]
    heads += ["standard error (%)", "realisations", "expected (likely)"]
    rows = [
        (
            mean.target / UNITS[unit],
            mean.mean / UNITS["nm²"],
            number(100.0 * mean.error, 2),
            mean.realisations,
            "-"
            if mean.unknown
            else "{} ({} to {})".format(mean.expected, *mean.likely),
        )
        for mean in means
    ]
    count = 5 if more else 4
    return table(heads[:count], [row[:count] for row in rows])


def _values_of_key(text: str) -> tuple[str, list[Any]]:
    """Return key and values of an option ``section.key=value,value``."""
    key, equals, values = text.partition("=")
    listed = [_value(part.strip()) for part in _VALUE.findall(values)]
    if not equals or not listed:
        raise ValueError(
            f"--set must be SECTION.KEY=VALUE,VALUE,..., got {shown(text)}"
        )
    return key.strip(), listed


def _value(text: str) -> Any:
    """Return a value as in a scene file; strings need no quotes."""
    try:
        return load_toml(f"value = {text}")["value"]
    except ValueError:
        return text
