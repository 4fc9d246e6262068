"""The command ``ensemble``."""

from __future__ import annotations

import argparse
import itertools
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeAlias

from ase_roughcontact._util.files import check_different, check_replaced
from ase_roughcontact._util.printing import show, write
from ase_roughcontact._util.validation import shown
from ase_roughcontact.cli.common import json_line, prints_text, progress_bar, scene_text
from ase_roughcontact.cli.means import means_lines, means_table
from ase_roughcontact.cli.messages import print_error
from ase_roughcontact.ensemble import (
    MeanValue,
    Progress,
    Sampling,
    mean_values,
    product,
    run_ensemble,
    sample_ensemble,
    write_csv,
)
from ase_roughcontact.ensemble.database import without_password
from ase_roughcontact.ensemble.executors import scheduler_executor
from ase_roughcontact.ensemble.means import check_column
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.file import load_toml

# A value of a list that is separated by commas: a string, a list, a table or others.
_VALUE_PATTERN = re.compile(
    r"""(?:"[^"]*"|'[^']*'|\[[^]]*\]|\{[^}]*\}|[^,])+?(?=,|$)"""
)
# Key of the seed of a random surface.
_SEED_KEY = "roughness.seed"
# Rows and columns of the database that a message lists.
_LISTED_COLUMNS = "record=step -c case,step,normal_force,contact_area"
# Values of some keys, and the scene that has them.
_Variant: TypeAlias = tuple[dict[str, Any], Scene]


def ensemble(options: argparse.Namespace) -> int:
    r"""Run a scene for all combinations of some values, in parallel.

    The steps are stored in an ASE database. An interrupted ensemble is resumed by
    running it again. Of several seeds the means are printed with their standard errors:
    of the contact area, of a loop and a sliding path of all results, or of --column.
    For five realisations of the roughness on two spheres::

      ase-roughcontact ensemble my.toml --set roughness.seed=0,1,2,3,4 \
                                        --set sphere.radius=100.0,1000.0

    With --error, realisations are added until the standard error of every mean is below
    it. Each load gets as many as it needs, which a pilot of 8 predicts, with the range
    in which nine of ten predictions are right. 95 % of means are within 1.96 standard
    errors, also of few seeds (Student's t)::

      ase-roughcontact ensemble my.toml --error 0.05
      ase-roughcontact ensemble loop.toml --error 0.05 --column dissipated_energy

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
    if options.error is not None and _SEED_KEY in values:
        raise ValueError("--error chooses the seeds: omit --set roughness.seed")
    for option, begin in ("table", b"case,step"), ("results", b"case,state"):
        file = getattr(options, option)
        if file:
            check_different(**{option: file, "database": options.database})
            check_replaced(Path(file), begin)
    variants = _variants(scene, values)
    pool: dict[str, Any] = {"workers": options.workers}
    if options.column:
        check_column(variants[0][1], options.column)
    with ExitStack() as stack:
        if options.scheduler is not None:
            found = scheduler_executor(options.scheduler)
            pool["executor"], workers = stack.enter_context(found)
            if prints_text(options):
                write(workers)
        draw = stack.enter_context(progress_bar(options))
        enough, failures = _calculate(options, variants, pool, draw)
    seeds = values.pop(_SEED_KEY, [])
    if len(seeds) > 1 and not options.quiet:
        for variant in _variants(scene, values):
            realisations = product(variant[1], {_SEED_KEY: seeds})
            for means in _means(options, realisations):
                _print_means(options, variant, means)
    if options.table:
        write_csv(options.database, options.table)
    if options.results:
        write_csv(options.database, options.results, record="case")
    if prints_text(options):
        database = without_password(options.database)
        rows, result = _LISTED_COLUMNS, variants[0][1].path.main_result
        if result:
            rows = f"record=case -c case,state,seed,{result}"
        write(f"Results are in {database}. To list them:\n  ase db {database} {rows}")
    for name, message in failures.items():
        print_error(f"{name}: {message}")
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
    """Return whether the error is small enough, and messages by the failed values."""
    enough, failures = True, dict[str, str]()
    if options.error is None:
        scenes = [scene for _, scene in variants]
        for progress in run_ensemble(scenes, options.database, **pool):
            _print_progress(options, progress, draw)
            failures = progress.named_failures
        return enough, failures
    for variant in variants:
        settings, scene = variant
        samplings = sample_ensemble(
            scene, options.database, options.error, column=options.column, **pool
        )
        for sampling in samplings:
            _print_progress(options, sampling.progress, draw, sampling.error)
            if sampling.progress.steps == sampling.progress.total:
                _print_means(options, variant, sampling.means, sampling)
        enough &= sampling.done
        for name, message in sampling.progress.named_failures.items():
            names = filter(None, [_heading(settings), name])
            failures[", ".join(names)] = message
    return enough, failures


def _print_progress(
    options: argparse.Namespace,
    progress: Progress,
    draw: Callable | None,
    error: float = math.nan,
) -> None:
    """Show the progress, and the largest standard error so far if there is one."""
    has_error = math.isfinite(error)
    if options.json:
        values = asdict(progress)
        if has_error:
            values["error"] = error
        write(json_line(values, {"elapsed": "s", "left": "s"}))
    elif draw:
        draw(progress.steps, progress.total, str(progress))
    elif not options.quiet:
        text = f", standard error {100.0 * error:.2g} %" if has_error else ""
        write(f"{progress}{text}")


def _print_means(
    options: argparse.Namespace,
    variant: _Variant,
    means: Sequence[MeanValue],
    sampling: Sampling | None = None,
) -> None:
    """Print the means of a variant, and the realisations that it still needs."""
    settings, scene = variant
    if options.json:
        for line in means_lines(scene, settings, means, sampling):
            write(line)
    elif means and not options.quiet:
        if settings:
            show(_heading(settings))
        show(*means_table(scene, means, sampling))


def _heading(settings: Mapping[str, Any]) -> str:
    """Return keys and values as text."""
    return ", ".join(f"{key} = {value}" for key, value in settings.items())


def _means(
    options: argparse.Namespace, realisations: Sequence[Scene]
) -> Iterator[Sequence[MeanValue]]:
    """Yield means of the wanted column, or of the area and all results of the path."""
    scene, database = realisations[0], options.database
    if options.column or not scene.path.main_result:
        yield mean_values(realisations, database, options.column)
    if options.column:
        return
    results = scene.path.results
    errors = {each.error for each in results.values()}  # stand beside their values
    names = [name for name in results if name not in errors]
    found = (mean_values(realisations, database, name)[0] for name in names)
    yield [mean for mean in found if mean.realisations or mean.failed]


def _values_of_key(text: str) -> tuple[str, list[Any]]:
    """Return key and values of an option ``section.key=value,value``."""
    key, equals, values = text.partition("=")
    listed = [_value(part.strip()) for part in _VALUE_PATTERN.findall(values)]
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
