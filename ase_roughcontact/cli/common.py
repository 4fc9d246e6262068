"""Functions for several commands: scenes, progress, and lines of JSON."""

from __future__ import annotations

import argparse
import json
import logging
import math
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ase_roughcontact._util.printing import show, terminal, write
from ase_roughcontact.ensemble.ensemble_plan import EnsemblePlan
from ase_roughcontact.paths.planned_steps import TOTAL_UNITS
from ase_roughcontact.results.record import LoadStep, units_of
from ase_roughcontact.scene import Scene, default_text


def scene_text(options: argparse.Namespace) -> tuple[str, str]:
    """Return text and name of the scene file, by default of the built-in one."""
    if not options.scene:
        return default_text(), "default.toml"
    return Scene.text_of(options.scene), options.scene


def checked_scene(options: argparse.Namespace) -> Scene:
    """Return the scene; raise `ValueError` if it is invalid.

    The error for the file of a measurement says what reads it.
    """
    file = options.scene
    try:
        text, name = scene_text(options)
        scene = Scene.parse(text, name)
    except ValueError as error:
        if not file or Path(file).suffix.lower() in ("", ".toml"):
            raise
        raise ValueError(
            f"{error}. A force curve is drawn by: ase-roughcontact curve {file}; a "
            "scan is the file in [topography] of a scene"
        ) from error
    scene.check(name)
    for warning in scene.warnings:
        warnings.warn(warning, stacklevel=2)
    return scene


def prints_text(options: argparse.Namespace) -> bool:
    """Return whether text is printed, rather than JSON or nothing."""
    return not (options.quiet or options.json)


@contextmanager
def progress_bar(options: argparse.Namespace) -> Iterator[Callable | None]:
    """Return the function that draws a bar of a number, a total and a text; or None.

    Bars are drawn on terminals, unless nothing or JSON is printed. Messages that the
    package logs with a number and a total are drawn, too.
    """
    if not (prints_text(options) and sys.stdout.isatty()):
        yield None
        return
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bars

    columns = BarColumn(), TextColumn("{task.description}")
    with Bars(
        *columns,
        console=terminal(),
        transient=True,
        auto_refresh=False,
        redirect_stderr=sys.stderr.isatty(),
    ) as bars:
        bar = bars.add_task("")

        def draw(done: float, total: float, text: str) -> None:
            options: Any = {"total": total, "description": text}
            bars.update(bar, completed=done, refresh=True, **options)

        class Drawn(logging.Handler):
            def emit(self, record: Any) -> None:
                done, total = record.args
                draw(done, total, record.getMessage())

        logger, handler = logging.getLogger("ase_roughcontact"), Drawn()
        level = logger.level
        logger.addHandler(handler)
        logger.setLevel(logging.INFO)
        try:
            yield draw
        finally:
            logger.setLevel(level)
            logger.removeHandler(handler)


def json_line(values: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """Return a line of JSON, with null in place of NaN, and "inf" of infinity.

    Parameters
    ----------
    values : mapping
        Numbers, strings, lists and dicts.
    units : mapping
        Units of values, written under the key ``units``; units of other keys are
        ignored.
    """
    used = {key: unit for key, unit in units.items() if key in values}
    return json.dumps(_plain({**values, "units": used}))


def step_line(step: LoadStep) -> str:
    """Return a step as a line of JSON, with reasons for null under ``not_known``."""
    values = {**asdict(step), "not_known": step.not_known}
    return json_line(values, units_of(type(step)))


def _plain(value: Any) -> Any:
    """Return a value with numbers that JSON can represent."""
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else f"{value:g}"
    return value


def show_plan(plan: EnsemblePlan, options: argparse.Namespace) -> int:
    """Print the plan of many cases; return the exit status."""
    if options.json:
        write(json_line(plan.totals, TOTAL_UNITS))
    elif not options.quiet:
        show(plan.printed())
    return 0 if plan.fits else 2
