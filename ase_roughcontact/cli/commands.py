"""The commands of ``ase-roughcontact``: one function each."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import asdict, replace

from ase_roughcontact._util.units import UNITS, printed_unit
from ase_roughcontact.cli import report, runs
from ase_roughcontact.cli.curves import read_curve
from ase_roughcontact.cli.ensembles import ensemble
from ase_roughcontact.cli.jsonlines import json_line
from ase_roughcontact.cli.options import checked_scene
from ase_roughcontact.cli.parser import make_parser
from ase_roughcontact.cli.places import places
from ase_roughcontact.paths.record import units_of
from ase_roughcontact.scene import default_text
from ase_roughcontact.scene.fit import fit_curve
from ase_roughcontact.scene.smooth_fit import smooth_fit
from ase_roughcontact.scene.tradeoff import tradeoff


def _print_scene(options: argparse.Namespace) -> int:
    print(default_text(), end="")
    return 0


def _plan(options: argparse.Namespace) -> int:
    scene = checked_scene(options)
    plan, unit = scene.plan(), report.target_unit(scene)
    if options.json:
        for step in plan.steps:
            print(json_line(asdict(step), units_of() | {"target": unit}))
    elif not options.quiet:
        printed = printed_unit(unit)
        print(plan.table(f"{scene.path.control} ({printed})", UNITS[printed]))
    return 0 if plan.runs else 1


def _fit(options: argparse.Namespace) -> int:
    from ase_roughcontact.cli import figures  # imports matplotlib

    scene = checked_scene(options)
    curve = read_curve(options.curve, options.branch)
    if scene.cantilever is not None:
        curve = replace(curve, stiffness=scene.cantilever)
    fit = fit_curve(scene, curve, [name.strip() for name in options.free.split(",")])
    print(fit)
    smooth = smooth_fit(scene, curve) if scene.wall.attractive else None
    if smooth is not None:
        print(smooth)
    figures.draw_fit(fit, smooth, options.picture)
    print(options.picture)
    return 0 if fit.converged else 1


def _tradeoff(options: argparse.Namespace) -> int:
    from ase_roughcontact.cli import figures  # imports matplotlib

    study = tradeoff(checked_scene(options), options.error)
    figures.draw_tradeoff(study, options.picture)
    if options.json:
        for choice in study.choices:
            values = {
                **asdict(choice),
                "on_front": choice in study.front,
                "in_plan": choice in study.plan,
                "error_wanted": study.wanted,
                "error_of_check": study.checked,
            }
            print(json_line(values, units_of()))
    elif not options.quiet:
        print(study)
        print(options.picture)
    return 0 if study.kept else 1


def _completion(options: argparse.Namespace) -> int:
    try:
        import shtab
    except ImportError as error:
        raise ImportError(
            "completion needs shtab: install the extra completion: pip install "
            "'.[completion]' in the folder of the source code"
        ) from error
    print(shtab.complete(make_parser(), options.shell))
    return 0


COMMANDS: dict[str, Callable[[argparse.Namespace], int]] = {
    "run": runs.run,
    "plan": _plan,
    "ensemble": ensemble,
    "places": places,
    "tradeoff": _tradeoff,
    "figure": runs.draw_figures,
    "maps": runs.write_maps,
    "fit": _fit,
    "report": runs.write_report,
    "scene": _print_scene,
    "completion": _completion,
}
