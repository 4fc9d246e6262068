"""What several commands share: scenes, progress, and lines of JSON."""

from __future__ import annotations

import argparse
import json
import logging
import math
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

from ase_roughcontact.ensemble import Progress
from ase_roughcontact.scene import Scene, default_text


def scene_text(options: argparse.Namespace) -> tuple[str, str]:
    """Return text and name of the scene file, by default of the built-in one."""
    if not options.scene:
        return default_text(), "default.toml"
    return Scene.text_of(options.scene), options.scene


def checked_scene(options: argparse.Namespace) -> Scene:
    """Return the scene; raise `ValueError` if it is invalid."""
    text, name = scene_text(options)
    scene = Scene.parse(text, name)
    scene.check(name)
    for warning in scene.warnings:
        warnings.warn(warning, stacklevel=2)
    return scene


def prints_text(options: argparse.Namespace) -> bool:
    """Return whether text is printed, rather than JSON or nothing."""
    return not (options.quiet or options.json)


@contextmanager
def progress_bar(options: argparse.Namespace) -> Iterator[Callable | None]:
    """Return the function that draws a `Progress` as a bar; None if there is no bar.

    Bars are drawn on terminals, unless nothing or JSON is printed.
    """
    if not (prints_text(options) and sys.stdout.isatty()):
        yield None
        return
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bars

    columns = BarColumn(), TextColumn("{task.description}")
    with Bars(*columns, transient=True, auto_refresh=False) as bars:
        bar = bars.add_task("")

        def draw(progress: Progress) -> None:
            bars.update(
                bar,
                completed=progress.steps,
                total=progress.total,
                description=str(progress),
                refresh=True,
            )

        with _logged(draw):
            yield draw


@contextmanager
def _logged(draw: Callable) -> Iterator[None]:
    """Draw what the package logs, texts with a number and a total, as progress."""
    logger, handler = logging.getLogger("ase_roughcontact"), _Drawn(draw)
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.setLevel(level)
        logger.removeHandler(handler)


class _Drawn(logging.Handler):
    """Handler that draws messages as progress."""

    def __init__(self, draw: Callable) -> None:
        super().__init__()
        self._draw = draw

    def emit(self, record: Any) -> None:
        number, total = record.args
        self._draw(Part(number, total, record.getMessage()))


class Part(NamedTuple):
    """Progress of a path in time, or of a part of a step."""

    steps: float
    total: float
    text: str

    def __str__(self) -> str:
        return self.text


def json_line(values: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """Return a line of JSON, with null in place of NaN and infinity.

    Parameters
    ----------
    values : mapping
        Numbers, strings, lists and dicts.
    units : mapping
        Units of the values that have one, written under the key ``units``; those of
        other keys are ignored.
    """
    used = {key: unit for key, unit in units.items() if key in values}
    return json.dumps(_finite({**values, "units": used}))


def _finite(value: Any) -> Any:
    """Return a value with None in place of numbers that are not finite."""
    if isinstance(value, dict):
        return {key: _finite(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
