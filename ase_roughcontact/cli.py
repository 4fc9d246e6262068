"""The command ``ase-roughcontact``."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

from ase.io import Trajectory

from ase_roughcontact import report
from ase_roughcontact.ensemble import product, run_ensemble, write_table
from ase_roughcontact.record import LoadStep
from ase_roughcontact.scene import NANONEWTON, Scene, default_text, tomllib
from ase_roughcontact.tradeoff import tradeoff

DESCRIPTION = "Contact of a rigid rough sphere with an elastic solid."

RUN = """\
Press the sphere of a scene into its substrate, step by step.

Without a file it runs the built-in scene, which "ase-roughcontact scene" prints: a
template for your own, with every key explained. The folder gets

  curve.csv    one line per step: heights and penetrations in Angstrom, forces in
               eV/Angstrom, areas in Angstrom^2, energies in eV
  sweep.traj   ASE trajectory, one frame per step: tag 1 is an atom in contact, 2 one
               that is attracted; initial charges are pressures in GPa
  view.traj    the same to look at with ase gui: the sphere cut open, large windows
               thinned, the axis in the middle
  curve.png    area against load, beside Eq. (4) of the paper (with matplotlib)
  contact.png  maps of the contact at four loads (with matplotlib)
  scene.toml   the scene

A run that was stopped goes on where it was when started again with the same folder.
Exit status: 0 all steps converged, 1 some did not, 2 the scene or the folder is wrong,
130 interrupted.
"""

PLAN = """\
Tell window, grid, memory and time of every step before anything is calculated, and what
is left out and why that is allowed.

The time comes from a short measurement of the transforms on this machine, and is right
within a factor of about three. Exit status: 0 it fits into the memory that is free, 1
it does not, 2 the scene is wrong.
"""

ENSEMBLE = """\
Calculate a scene for all combinations of some values, in parallel, and keep the steps
in an ASE database (look at it with "ase db FILE"). Started again it goes on where it
was. For five realisations of two spheres:

  ase-roughcontact ensemble my.toml --set roughness.seed=0,1,2,3,4 \\
                                    --set sphere.radius=100.0,1000.0

Exit status: 0 all steps are there, 1 some cases ended with an error, 2 the scene or the
database is wrong, 130 interrupted.
"""


TRADEOFF = """\
Measure what accuracy costs in a scene, on a few of its steps, and recommend settings
for an error in force and area. Exit status: 0 there is a setting, 1 none keeps to the
error, 2 the scene is wrong.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    options = _parser().parse_args(arguments)
    try:
        return _done(options.action(options))
    except BrokenPipeError:  # of a pager that was closed
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (ValueError, RuntimeError, OSError, MemoryError) as error:
        print(f"ase-roughcontact: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\nstopped; what was calculated is kept", file=sys.stderr)
        return 130


def _done(status: int) -> int:
    sys.stdout.flush()  # while a closed pipe can still be caught
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("ase-roughcontact", description=DESCRIPTION)
    number = version("ase-roughcontact")
    parser.add_argument("--version", action="version", version=f"%(prog)s {number}")
    commands = parser.add_subparsers(required=True, metavar="command")

    def command(name: str, action: Any, told: str, text: str) -> Any:
        made = commands.add_parser(
            name,
            help=told,
            description=text,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        made.set_defaults(action=action)
        return made

    def scene_file(made: argparse.ArgumentParser) -> None:
        made.add_argument(
            "scene", nargs="?", help="scene file (TOML); by default the built-in scene"
        )

    def how_to_tell(made: argparse.ArgumentParser) -> None:
        how = made.add_mutually_exclusive_group()
        how.add_argument("--quiet", action="store_true", help="tell errors only")
        how.add_argument("--json", action="store_true", help="a line of JSON per step")

    run = command("run", _run, "press the sphere in, plot area against load", RUN)
    scene_file(run)
    run.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("roughcontact-out"),
        help="folder of the results, made if it is not there (default: %(default)s)",
    )
    how_to_tell(run)

    plan = command("plan", _plan, "tell windows, memory and time beforehand", PLAN)
    scene_file(plan)
    how_to_tell(plan)

    ensemble = command("ensemble", _ensemble, "run many variants of a scene", ENSEMBLE)
    scene_file(ensemble)
    ensemble.add_argument(
        "--set",
        metavar="TABLE.KEY=VALUES",
        action="append",
        default=[],
        help="values of a key, as in the scene file, with commas between them",
    )
    ensemble.add_argument(
        "--database",
        metavar="FILE",
        default="roughcontact.db",
        help="SQLite database, or postgresql://... (default: %(default)s)",
    )
    ensemble.add_argument("--table", metavar="CSV", help="write all steps there, too")
    ensemble.add_argument(
        "--workers", type=int, help="number of processes (default: one per processor)"
    )
    how_to_tell(ensemble)

    trade = command(
        "tradeoff", _tradeoff, "measure what accuracy costs in a scene", TRADEOFF
    )
    scene_file(trade)
    trade.add_argument(
        "--error",
        type=float,
        default=1e-3,
        help="relative error that is allowed (default: %(default)s)",
    )

    figure = command(
        "figure",
        _figure,
        "draw the pictures of a run again",
        "Draw curve.png and contact.png of a folder that a run has made.",
    )
    figure.add_argument("folder", metavar="DIR", type=Path, help="folder of the run")

    command(
        "scene",
        _print_scene,
        "print the built-in scene, a template for your own",
        "Print the built-in scene file: every key is explained in it.",
    )
    return parser


def _text(options: argparse.Namespace) -> tuple[str, str]:
    """Text and name of the scene file, or of the built-in one."""
    if not options.scene:
        return default_text(), "default.toml"
    return Scene.text_of(options.scene), options.scene


def _print_scene(options: argparse.Namespace) -> int:
    print(default_text(), end="")
    return 0


def _plan(options: argparse.Namespace) -> int:
    scene = Scene.parse(*_text(options))
    plan = scene.plan()
    if options.json:
        for step in plan.steps:
            print(json.dumps(asdict(step)))
    elif not options.quiet:
        heading, unit = {
            "load": ("load (nN)", NANONEWTON),
            "penetration": ("penetration (Å)", 1.0),
            "height": ("height (Å)", 1.0),
        }[scene.path.control]
        print(plan.table(heading, unit))
    return 0 if plan.fits else 1


def _run(options: argparse.Namespace) -> int:
    text, name = _text(options)
    scene, folder = Scene.parse(text, name), options.out
    total, kept = len(scene.steps), _frames(folder)
    records: list[LoadStep] = []
    talks = not (options.quiet or options.json)
    for record in scene.run(folder):
        if not records:
            (folder / "scene.toml").write_text(text, encoding="utf-8")
        if talks and not records:
            print(report.heading(scene))
        records.append(record)
        if talks:
            known = len(records) <= kept
            print(report.row(scene, record, total, known), flush=True)
        if options.json:
            print(json.dumps(asdict(record)), flush=True)
    pictures = report.draw(scene, records, folder)
    report.write_view(scene, folder)
    if talks:
        print(report.farewell(folder, pictures))
    return 0 if all(record.converged for record in records) else 1


def _frames(folder: Path) -> int:
    """Count the steps that an earlier run has left."""
    file = folder / "sweep.traj"
    if not file.exists() or not file.stat().st_size:
        return 0
    try:
        with Trajectory(file) as frames:
            return len(frames)
    except (OSError, ValueError):  # to be told when the run reads it
        return 0


def _figure(options: argparse.Namespace) -> int:
    folder = options.folder
    scene = Scene.read(folder / "scene.toml")
    with Trajectory(folder / "sweep.traj") as frames:
        records = [LoadStep(**frame.info["load_step"]) for frame in frames]
    pictures = report.draw(scene, records, folder)
    if not pictures:
        raise RuntimeError("no pictures: matplotlib is not installed, or no force")
    print("\n".join(str(folder / name) for name in pictures))
    return 0


def _ensemble(options: argparse.Namespace) -> int:
    scene = Scene.parse(*_text(options))
    scenes = product(scene, dict(_choice(text) for text in options.set))
    for progress in run_ensemble(scenes, options.database, workers=options.workers):
        if options.json:
            print(json.dumps(asdict(progress)), flush=True)
        elif not options.quiet:
            print(progress, flush=True)
    if options.table:
        write_table(options.database, options.table)
    if not (options.quiet or options.json):
        print(
            f"Steps are in {options.database}: look at them with\n"
            f"  ase db {options.database} record=step -c case,step,normal_force,"
            "contact_area"
        )
    for case, message in progress.failures.items():
        print(f"ase-roughcontact: case {case}: {message}", file=sys.stderr)
    return 1 if progress.failures else 0


def _tradeoff(options: argparse.Namespace) -> int:
    found = tradeoff(Scene.parse(*_text(options)), options.error)
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
