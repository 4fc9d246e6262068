"""The commands of ``ase-roughcontact``: one function each."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ase_roughcontact._util.files import refuse_link, replaced
from ase_roughcontact._util.units import UNITS, printed_unit
from ase_roughcontact._util.validation import shown
from ase_roughcontact.analysis import ContactMap, write_map
from ase_roughcontact.cli import loops, report
from ase_roughcontact.cli.curves import read_curve
from ase_roughcontact.cli.jsonlines import json_line
from ase_roughcontact.cli.page import page
from ase_roughcontact.cli.parser import make_parser
from ase_roughcontact.ensemble import (
    Progress,
    Sampling,
    product,
    run_ensemble,
    sample_ensemble,
    write_csv,
)
from ase_roughcontact.ensemble.database import without_password
from ase_roughcontact.ensemble.progress import ProgressMeter, expected_costs
from ase_roughcontact.paths.cantilever import cantilever_curve
from ase_roughcontact.paths.instabilities import AdhesionLoop
from ase_roughcontact.paths.record import LoadStep, units_of
from ase_roughcontact.paths.trajectory import count_steps, read_frames, read_steps
from ase_roughcontact.scene import Scene, default_text
from ase_roughcontact.scene.file import load_toml
from ase_roughcontact.scene.fit import fit_curve, smooth_fit
from ase_roughcontact.scene.reference import Reference, reference_for
from ase_roughcontact.scene.tradeoff import tradeoff

UNITS_OF_PROGRESS = {"elapsed": "s", "left": "s"}
#: Errors that are printed as a line.
ERRORS = ValueError, RuntimeError, OSError, MemoryError, ImportError


def _scene_text(options: argparse.Namespace) -> tuple[str, str]:
    """Return text and name of the scene file, by default of the built-in one."""
    if not options.scene:
        return default_text(), "default.toml"
    return Scene.text_of(options.scene), options.scene


def _scene(options: argparse.Namespace) -> Scene:
    text, name = _scene_text(options)
    scene = Scene.parse(text, name)
    scene.check(name)
    return scene


def _print_scene(options: argparse.Namespace) -> int:
    print(default_text(), end="")
    return 0


def _plan(options: argparse.Namespace) -> int:
    scene = _scene(options)
    plan, unit = scene.plan(), report.target_unit(scene)
    if options.json:
        for step in plan.steps:
            print(json_line(asdict(step), units_of() | {"target": unit}))
    elif not options.quiet:
        printed = printed_unit(unit)
        print(plan.table(f"{scene.path.control} ({printed})", UNITS[printed]))
    return 0 if plan.runs else 1


def _run(options: argparse.Namespace) -> int:
    scene, steps = _scene(options), list[LoadStep]()
    if scene.path.is_loop:
        return _run_loop(options, scene)
    scene.check_path()  # before theory needs the statistics of the roughness
    reference = reference_for(scene)
    try:
        _relax(options, reference, steps)
    except ERRORS:
        if steps:
            with suppress(OSError, MemoryError):  # in favour of the first error
                _write_results(options, reference, steps)
        raise
    _write_results(options, reference, steps)
    return 0 if all(step.converged for step in steps) else 1


def _run_loop(options: argparse.Namespace, scene: Scene) -> int:
    """Approach and retract, print each state, and draw the force curves."""
    folder, states = options.out, list[LoadStep]()
    options.again = "start anew"

    def show(state: LoadStep) -> None:
        states.append(state)
        if _prints_text(options):
            print(loops.row(state) + report.limits(state), flush=True)
        if options.json:
            print(json_line(asdict(state), units_of()), flush=True)

    if _prints_text(options):
        print(report.description(reference_for(scene)) + loops.header())
    validity = "raise" if options.strict else "ignore"  # the table has them
    loop = scene.loop(folder, show, validity, _scene_text(options)[0])
    pictures, values, failure = _loop_results(folder, scene, loop)
    if _prints_text(options):
        print("\n".join([values, *report.exceeded_limits(states)]))
        print(report.file_list(folder, pictures), flush=True)
    if failure:
        report.print_error(failure)
    return 0 if all(state.converged for state in states) and not failure else 1


def _loop_results(
    folder: Path, scene: Scene, loop: AdhesionLoop
) -> tuple[list[str], str, str]:
    """Draw the figures of a loop; return them, its values, and what failed."""
    from ase_roughcontact.cli import figures  # imports matplotlib

    curve, failure = None, ""
    states = (*loop.approach, *loop.retraction[1:])
    pictures = figures.draw(reference_for(scene), states, folder)
    figures.draw_loop(loop, folder / "loop.png")
    pictures.append("loop.png")
    if scene.cantilever is not None:
        try:
            curve = cantilever_curve(loop, scene.cantilever)
        except ValueError as error:  # the loop itself is valid
            failure = str(error)
    if curve is not None:
        loops.write_curve(curve, folder / "cantilever.csv")
        figures.draw_cantilever(curve, folder / "cantilever.png")
        pictures.append("cantilever.png")
    figures.write_view(scene, folder)
    return pictures, loops.summary(loop, curve), failure


def _relax(
    options: argparse.Namespace,
    reference: Reference,
    steps: list[LoadStep],
) -> None:
    """Relax all steps, print each, and append it to a list."""
    folder, (text, _) = options.out, _scene_text(options)
    # more steps than the scene has are those of another one, which `run` refuses
    restored = min(count_steps(folder / "sweep.traj"), len(reference.scene.steps))
    meter = ProgressMeter({"path": expected_costs(reference.scene)})
    meter.add(["path"] * restored)
    meter.progress()
    validity = "raise" if options.strict else "ignore"  # the table has them
    for step in reference.scene.run(folder, validity, text):
        if not steps and _prints_text(options):
            print(report.table_header(reference))
        steps.append(step)
        if len(steps) > restored:
            meter.add(["path"])
        if _prints_text(options):
            progress, old = meter.progress(), len(steps) <= restored
            row = report.table_row(reference, step, progress, old)
            print(row, flush=True)
        if options.verbose:
            print(report.solver_line(step), flush=True)
        if options.json:
            print(json_line(asdict(step), units_of()), flush=True)


def _prints_text(options: argparse.Namespace) -> bool:
    return not (options.quiet or options.json)


def _write_results(
    options: argparse.Namespace,
    reference: Reference,
    steps: list[LoadStep],
) -> None:
    """Draw figures, write the trajectory for viewing, and print where they are."""
    from ase_roughcontact.cli import figures  # imports matplotlib

    pictures = figures.draw(reference, steps, options.out)
    figures.write_view(reference.scene, options.out)
    if _prints_text(options):
        print(report.summary(reference, steps, options.out, pictures), flush=True)


def _figure(options: argparse.Namespace) -> int:
    from ase_roughcontact.cli import figures  # imports matplotlib

    folder = options.folder
    scene = Scene.read(folder / "scene.toml")
    steps = list(read_steps(folder / "sweep.traj"))
    if scene.path.is_loop:
        pictures, _, _ = _loop_results(folder, scene, _loop_of(scene, steps))
    else:
        pictures = figures.draw(reference_for(scene), steps, folder)
    if not pictures:
        raise RuntimeError("no figures: the sphere touches in no step")
    figures.write_view(scene, folder)
    print("\n".join(str(folder / name) for name in pictures))
    return 0


def _loop_of(scene: Scene, steps: list[LoadStep]) -> AdhesionLoop:
    return AdhesionLoop.of(steps, scene.loop_options["smallest_step"])


def _report(options: argparse.Namespace) -> int:
    folder = options.folder
    scene = Scene.read(folder / "scene.toml")
    steps = list(read_steps(folder / "sweep.traj"))
    reference, values = reference_for(scene), ""
    if scene.path.is_loop:
        _, values, _ = _loop_results(folder, scene, _loop_of(scene, steps))
    file = folder / "report.html"
    with replaced(file) as name:
        text = page(reference, steps, folder, values)
        Path(name).write_text(text, encoding="utf-8")
    print(file)
    return 0


def _fit(options: argparse.Namespace) -> int:
    from ase_roughcontact.cli import figures  # imports matplotlib

    scene = _scene(options)
    depth, force = read_curve(options.curve, options.branch)
    fit = fit_curve(scene, depth, force, [n.strip() for n in options.free.split(",")])
    print(fit)
    smooth = None
    if scene.wall.attractive:
        smooth = smooth_fit(scene, depth, force)
        print(f"smooth sphere: work_of_adhesion {smooth.work_of_adhesion:.5g} J/m²")
    figures.draw_fit(fit, smooth, options.picture)
    print(options.picture)
    return 0 if fit.converged else 1


def _maps(options: argparse.Namespace) -> int:
    folder = options.folder
    surface = Scene.read(folder / "scene.toml").surface
    refuse_link(folder / "maps")
    (folder / "maps").mkdir(exist_ok=True)
    for number, frame in enumerate(read_frames(folder / "sweep.traj")):
        name = folder / "maps" / f"step-{number:04d}.{options.format}"
        write_map(ContactMap.from_frame(frame, surface), name)
        print(name)
    return 0


def _ensemble(options: argparse.Namespace) -> int:
    scene = Scene.parse(*_scene_text(options))
    values: dict[str, list[Any]] = {}
    for key, listed in map(_values_of_key, options.set):
        if key in values:
            raise ValueError(f"--set {key} is given twice: give all values in one")
        values[key] = listed
    scenes = product(scene, values)
    failures: dict[str, str] = {}
    enough = True
    if options.error is None:
        for progress in run_ensemble(scenes, options.database, workers=options.workers):
            _print_progress(options, progress)
            failures = progress.failures
    else:
        if "roughness.seed" in values:
            raise ValueError("--error chooses the seeds: omit --set roughness.seed")
        for each in scenes:
            sampling = _sample(options, each)
            enough &= sampling.done
            failures |= sampling.progress.failures
    if options.table:
        write_csv(options.database, options.table)
    if _prints_text(options):
        database = without_password(options.database)
        print(
            f"Results are in {database}. To list them:\n"
            f"  ase db {database} record=step -c case,step,normal_force,contact_area"
        )
    for case, message in failures.items():
        report.print_error(f"case {case}: {message}")
    return 0 if enough and not failures else 1


def _print_progress(options: argparse.Namespace, progress: Progress) -> None:
    if options.json:
        print(json_line(asdict(progress), UNITS_OF_PROGRESS), flush=True)
    elif not options.quiet:
        print(progress, flush=True)


def _sample(options: argparse.Namespace, scene: Scene) -> Sampling:
    """Add realisations until the means have the wanted error; print them each round."""
    reports = sample_ensemble(
        scene, options.database, options.error, workers=options.workers
    )
    for sampling in reports:
        _print_progress(options, sampling.progress)
        if sampling.progress.steps == sampling.progress.total:
            _print_means(options, scene, sampling)
    return sampling


def _print_means(options: argparse.Namespace, scene: Scene, sampling: Sampling) -> None:
    units = {"mean": "Å^2", "target": report.target_unit(scene)}
    if options.json:
        for mean in sampling.means:
            print(json_line(asdict(mean), units), flush=True)
    elif not options.quiet:
        print(report.means_table(scene, sampling), flush=True)


def _values_of_key(text: str) -> tuple[str, list[Any]]:
    """Return key and values of an option ``section.key=value,value``."""
    key, equals, values = text.partition("=")
    try:
        listed = load_toml(f"values = [{values}]")["values"]
    except ValueError:
        listed = values.split(",")  # strings without quotes
    if not equals or not values:
        raise ValueError(
            f"--set must be SECTION.KEY=VALUE,VALUE,..., got {shown(text)}"
        )
    return key.strip(), listed


def _tradeoff(options: argparse.Namespace) -> int:
    study = tradeoff(_scene(options), options.error)
    if options.json:
        for trial in study.trials:
            values = {
                **asdict(trial),
                "recommended": trial is study.best,
                "error_wanted": study.requested,
                "error_of_reference": study.reference_error,
            }
            print(json_line(values, units_of()))
        for grid in study.grids:
            print(json_line(asdict(grid), units_of()))
    elif not options.quiet:
        print(study)
    return 1 if study.best is None else 0


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
    "run": _run,
    "plan": _plan,
    "ensemble": _ensemble,
    "tradeoff": _tradeoff,
    "figure": _figure,
    "maps": _maps,
    "fit": _fit,
    "report": _report,
    "scene": _print_scene,
    "completion": _completion,
}
