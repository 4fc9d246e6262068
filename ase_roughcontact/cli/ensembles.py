"""The command ``ensemble``."""

from __future__ import annotations

import argparse
import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import Any, TypeAlias

from ase_roughcontact._util.files import check_different, check_replaced
from ase_roughcontact._util.printing import show, write
from ase_roughcontact.cli.common import (
    json_line,
    prints_text,
    progress_bar,
    show_plan,
)
from ase_roughcontact.cli.means import means_lines, means_table
from ase_roughcontact.cli.messages import print_error
from ase_roughcontact.cli.study import Study, show_study
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
from ase_roughcontact.ensemble.cases import combinations
from ase_roughcontact.ensemble.database import without_password
from ase_roughcontact.ensemble.ensemble_plan import EnsemblePlan
from ase_roughcontact.ensemble.executors import scheduler_executor
from ase_roughcontact.paths.planned_steps import StartCosts
from ase_roughcontact.scene import Scene

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
                                        --set "sphere.radius=20 nm,50 nm"

    With --error, realisations are added until the standard error of every mean is below
    it. Each load gets as many as it needs, which a pilot of 8 predicts, with the range
    in which nine of ten predictions are right. 95 % of means are within 1.96 standard
    errors, also of few seeds (Student's t). No seeds are added to a mean that is zero
    within the errors of its values, as the dissipated energy of a loop without
    hysteresis, nor more than --most::

      ase-roughcontact ensemble my.toml --error 0.05
      ase-roughcontact ensemble loop.toml --error 0.05 --column dissipated_energy

    With --scheduler, the workers of a Dask cluster calculate, on any number of
    machines::

      dask scheduler --port 8786
      dask worker tcp://HOST:8786 --nthreads 1
      ase-roughcontact ensemble my.toml --scheduler tcp://HOST:8786

    Parameters and their values may be in [study] of the scene, or in --set: lists, or
    ranges FIRST:LAST:STEPS, also FIRST:LAST:STEPS:geometric. A parameter with several
    numbers has a table and a figure of the columns over it, with standard errors,
    scatter and theory, beside the database::

      ase-roughcontact ensemble loop.toml --set roughness.seed=0:19:20 \
          --set "roughness.rms_height=0.1 nm:1 nm:4:geometric"

    With --plan nothing is calculated but the number of cases and steps, the time with
    the workers, the memory of each and the size of the database, from the case of
    median cost.

    Exit status: 0 all steps are stored, 1 some cases failed or the error is larger, 2
    the scene or the database is invalid or damaged, 130 interrupted (Ctrl-C), 143
    terminated (SIGTERM).
    """
    start, study = StartCosts.now(), Study.of(options)
    study.check_files(options.database)
    for option, begin in ("table", b"case,step"), ("results", b"case,state"):
        file = getattr(options, option)
        if file:
            check_different(**{option: file, "database": options.database})
            check_replaced(Path(file), begin)
    variants = _variants(study, study.values)
    if options.plan:
        if study.error is not None:
            raise ValueError(
                "--plan needs the number of realisations, which --error chooses: give "
                "--set roughness.seed=0:9:10, for instance"
            )
        scenes = [scene for _, scene in variants]
        plan = EnsemblePlan.of(scenes, options.workers, start)
        return show_plan(plan, options)
    pool: dict[str, Any] = {"workers": options.workers}
    with ExitStack() as stack:
        if options.scheduler is not None:
            found = scheduler_executor(options.scheduler)
            pool["executor"], workers = stack.enter_context(found)
            if prints_text(options):
                write(workers)
        draw = stack.enter_context(progress_bar(options))
        enough, failures, seeds = _calculate(options, study, variants, pool, draw)
    if study.over:
        show_study(options, study, seeds)
    elif study.realisations > 1 and not options.quiet:
        for variant in _variants(study, study.parameters):
            realisations = product(variant[1], study.seeds)
            for means in _means(options, study, realisations):
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


def _variants(study: Study, values: dict[str, list[Any]]) -> list[_Variant]:
    """Return the combinations of some values, with the scenes that have them."""
    settings = combinations(values, study.together)
    scenes = product(study.scene, values, study.together)
    return list(zip(settings, scenes, strict=True))


def _calculate(
    options: argparse.Namespace,
    study: Study,
    variants: list[_Variant],
    pool: dict[str, Any],
    draw: Callable | None,
) -> tuple[bool, dict[str, str], Sequence[int] | None]:
    """Return whether errors are small enough, messages of failed values, and seeds.

    Seeds are all that were added for a wanted error; None without one.
    """
    enough, failures, largest = True, dict[str, str](), 0
    if study.error is None:
        scenes = [scene for _, scene in variants]
        for progress in run_ensemble(scenes, options.database, **pool):
            _print_progress(options, progress, draw)
            failures = progress.named_failures
        return enough, failures, None
    for variant, column in itertools.product(variants, study.columns or [None]):
        settings, scene = variant
        samplings = sample_ensemble(
            scene,
            options.database,
            study.error,
            column=column,
            most=options.most,
            **pool,
        )
        for sampling in samplings:
            _print_progress(options, sampling.progress, draw, sampling.error)
            if sampling.progress.steps == sampling.progress.total:
                _print_means(options, variant, sampling.means, sampling)
        enough &= sampling.done
        for name, message in sampling.progress.named_failures.items():
            names = filter(None, [_heading(settings), name])
            failures[", ".join(names)] = message
        count = max(mean.realisations + mean.failed for mean in sampling.means)
        largest = max(largest, count)
        if sampling.missing and count >= options.most:
            names = filter(None, [_heading(settings), sampling.means[0].column])
            failures[", ".join(names)] = (
                f"the standard error is {100.0 * sampling.error:.2g} % with "
                f"{options.most} seeds: give a larger --error or --most"
            )
    first = variants[0][1].seed or 0
    return enough, failures, range(first, first + largest)


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
    options: argparse.Namespace, study: Study, realisations: Sequence[Scene]
) -> Iterator[Sequence[MeanValue]]:
    """Yield means of the wanted columns, or of the area and all results of the path.

    A result that no realisation has is left out, unless it is the main one.
    """
    scene, database = realisations[0], options.database
    for column in study.columns:
        yield mean_values(realisations, database, column)
    if study.columns:
        return
    results, main = scene.path.results, scene.path.main_result
    if not main:
        yield mean_values(realisations, database)
    errors = {each.error for each in results.values()}  # stand beside their values
    names = [name for name in results if name not in errors]
    found = (mean_values(realisations, database, name)[0] for name in names)
    yield [mean for mean in found if mean.realisations or mean.column == main]
