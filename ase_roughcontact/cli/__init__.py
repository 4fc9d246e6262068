"""The command ``ase-roughcontact``."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ase_roughcontact.cli import figures, report
from ase_roughcontact.cli.completion import BASHRC, candidates
from ase_roughcontact.cli.jsonlines import (
    UNITS_OF_EFFORT,
    UNITS_OF_PROGRESS,
    UNITS_OF_STEPS,
    json_line,
)
from ase_roughcontact.cli.parser import make_parser
from ase_roughcontact.ensemble import product, run_ensemble, write_csv
from ase_roughcontact.ensemble.database import without_password
from ase_roughcontact.ensemble.progress import expected_costs
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.trajectory import count_steps, read_steps
from ase_roughcontact.scene import NANONEWTON, Scene, default_text
from ase_roughcontact.scene.reading import tomllib
from ase_roughcontact.scene.reference import reference_for
from ase_roughcontact.scene.tradeoff import tradeoff


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    options = make_parser().parse_args(arguments)
    try:
        return _done(ACTIONS[options.action](options))
    except BrokenPipeError:  # of a pager that was closed
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (ValueError, RuntimeError, OSError, MemoryError) as error:
        print(f"ase-roughcontact: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        told = "stopped; what was calculated is kept"
        if options.action == "run":
            told += f"; for its pictures: ase-roughcontact figure {options.out}"
        print(f"\n{told}", file=sys.stderr)
        return 130


def _done(status: int) -> int:
    sys.stdout.flush()  # while a closed pipe can still be caught
    return status


def _text(options: argparse.Namespace) -> tuple[str, str]:
    """Text and name of the scene file, or of the built-in one."""
    if not options.scene:
        return default_text(), "default.toml"
    return Scene.text_of(options.scene), options.scene


def _scene(options: argparse.Namespace) -> Scene:
    """Scene of the file, checked."""
    text, name = _text(options)
    scene = Scene.parse(text, name)
    scene.check(name)
    return scene


def _print_scene(options: argparse.Namespace) -> int:
    print(default_text(), end="")
    return 0


def _plan(options: argparse.Namespace) -> int:
    plan = (scene := _scene(options)).plan()
    if options.json:
        target = "eV/Å" if scene.path.control == "load" else "Å"
        units = {"target": target, **UNITS_OF_EFFORT}
        for step in plan.steps:
            print(json_line(asdict(step), units))
    elif not options.quiet:
        heading, unit = {
            "load": ("load (nN)", NANONEWTON),
            "penetration": ("penetration (Å)", 1.0),
            "height": ("height (Å)", 1.0),
        }[scene.path.control]
        print(plan.table(heading, unit))
    return 0 if plan.runs else 1


def _run(options: argparse.Namespace) -> int:
    scene, records = _scene(options), list[LoadStep]()
    talks = not (options.quiet or options.json)
    try:
        _relax(options, scene, records, talks)
    except (ValueError, RuntimeError, OSError, MemoryError):
        if records:
            with suppress(OSError, MemoryError):  # the error that was first is told
                _show(scene, records, options.out, talks)
        raise
    _show(scene, records, options.out, talks)
    return 0 if all(record.converged for record in records) else 1


def _relax(
    options: argparse.Namespace, scene: Scene, records: list[LoadStep], talks: bool
) -> None:
    """Relax step after step, and tell of each."""
    folder, text = options.out, _text(options)[0]
    total, kept = len(scene.steps), count_steps(folder / "sweep.traj")
    laws, costs = reference_for(scene), expected_costs(scene)
    for record in scene.run(folder):
        if not records:
            (folder / "scene.toml").write_text(text, encoding="utf-8")
        if talks and not records:
            print(report.heading(scene, laws))
        records.append(record)
        if talks:
            left = report.time_left(costs, records, kept)
            known = len(records) <= kept
            line = report.row(scene, laws, record, total, left, known)
            print(line, flush=True)
        if options.verbose:
            print(report.effort(record), flush=True)
        if options.json:
            print(json_line(asdict(record), UNITS_OF_STEPS), flush=True)


def _show(scene: Scene, records: list[LoadStep], folder: Path, talks: bool) -> None:
    """Make what there is to see of some steps, and tell where it is."""
    laws = reference_for(scene)
    pictures = figures.draw(scene, laws, records, folder)
    figures.write_view(scene, folder)
    if talks:
        remarks = (
            report.touching_height(scene, records),
            report.largest_tension(laws, records),
        )
        told = "\n".join(filter(None, remarks))
        print(report.farewell(folder, pictures, told), flush=True)


def _figure(options: argparse.Namespace) -> int:
    folder = options.folder
    scene = Scene.read(folder / "scene.toml")
    records = list(read_steps(folder / "sweep.traj"))
    pictures = figures.draw(scene, reference_for(scene), records, folder)
    if not pictures:
        raise RuntimeError("no pictures: matplotlib is not installed, or no contact")
    figures.write_view(scene, folder)
    print("\n".join(str(folder / name) for name in pictures))
    return 0


def _ensemble(options: argparse.Namespace) -> int:
    scene = Scene.parse(*_text(options))
    choices: dict[str, list[Any]] = {}
    for key, values in map(_choice, options.set):
        if key in choices:
            raise ValueError(f"--set {key} is given twice: give all values in one")
        choices[key] = values
    scenes = product(scene, choices)
    for progress in run_ensemble(scenes, options.database, workers=options.workers):
        if options.json:
            print(json_line(asdict(progress), UNITS_OF_PROGRESS), flush=True)
        elif not options.quiet:
            print(progress, flush=True)
    if options.table:
        write_csv(options.database, options.table)
    if not (options.quiet or options.json):
        shown = without_password(options.database)
        print(
            f"Steps are in {shown}: look at them with\n"
            f"  ase db {shown} record=step -c case,step,normal_force,contact_area"
        )
    for case, message in progress.failures.items():
        print(f"ase-roughcontact: case {case}: {message}", file=sys.stderr)
    return 1 if progress.failures else 0


def _tradeoff(options: argparse.Namespace) -> int:
    found = tradeoff(_scene(options), options.error)
    if options.json:
        for trial in found.trials:
            told = {
                **asdict(trial),
                "recommended": trial is found.best,
                "error_wanted": found.wanted,
                "error_of_reference": found.reference_error,
            }
            print(json_line(told, UNITS_OF_EFFORT))
    elif not options.quiet:
        print(found)
    return 1 if found.best is None else 0


def _choice(text: str) -> tuple[str, list[Any]]:
    """Key and values of an option ``table.key=value,value``."""
    key, equals, values = text.partition("=")
    try:
        listed = tomllib.loads(f"values = [{values}]")["values"]
    except tomllib.TOMLDecodeError:
        listed = values.split(",")  # words need no quotes here
    if not equals or not values:
        raise ValueError(f"--set must be TABLE.KEY=VALUE,VALUE,..., got {text!r}")
    return key.strip(), listed


def _completion(options: argparse.Namespace) -> int:
    """Print the line for ~/.bashrc or, when bash asks, what may come next."""
    line = os.environ.get("COMP_LINE")
    if line is None:
        print(BASHRC)
    else:
        point = int(os.environ.get("COMP_POINT", len(line)))
        print("\n".join(candidates(make_parser(), line[:point])))
    return 0


ACTIONS: dict[str, Callable[[argparse.Namespace], int]] = {
    "run": _run,
    "plan": _plan,
    "ensemble": _ensemble,
    "tradeoff": _tradeoff,
    "figure": _figure,
    "scene": _print_scene,
    "completion": _completion,
}
