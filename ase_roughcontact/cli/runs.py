"""Runs of a scene: paths and loops, and the results in their folder."""

from __future__ import annotations

import argparse
import math
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ase_roughcontact._util.files import refuse_link, replaced
from ase_roughcontact._util.printing import entries, show, write
from ase_roughcontact._util.units import LENGTHS, TIMES, UNITS, quantity
from ase_roughcontact.analysis import ContactMap, write_map, write_stress
from ase_roughcontact.analysis.stress_files import equally_spaced
from ase_roughcontact.cli import report
from ase_roughcontact.cli.common import (
    checked_scene,
    prints_text,
    progress_bar,
    scene_text,
    step_line,
)
from ase_roughcontact.cli.messages import ERRORS, print_error
from ase_roughcontact.ensemble import read_places
from ase_roughcontact.ensemble.progress import ProgressMeter, TimeMeter, step_costs
from ase_roughcontact.loading.trajectory import (
    frames_of_steps,
    places_of_steps,
    steps_with_frames,
)
from ase_roughcontact.paths.restart import read_restart, read_steps
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.results.validity import Reaction
from ase_roughcontact.scene import Results, Scene
from ase_roughcontact.scene.preview import preview
from ase_roughcontact.scene.reference import Reference, reference_for
from ase_roughcontact.scene.results import RESTART

if TYPE_CHECKING:
    from ase_roughcontact.cli.stress_figures import StressView


def run(options: argparse.Namespace) -> int:
    """Move the indenter of a scene along its path, step by step.

    The kinds of path are "steps", given loads, penetrations or heights; "loop",
    approach and retraction with adhesion; "time", on a viscoelastic solid; "sliding",
    against friction; and "sliding-in-time", with rate and state friction.

    Without a scene file the built-in scene is run. "ase-roughcontact scene" prints it,
    as a template with a description of each key. Files in the output folder::

      curve.csv    one line per step: heights and penetrations in Å, forces in eV/Å,
                   areas in Å^2, energies in eV
      sweep.traj   frames for looking, of all steps or about a hundred, which
                   ase.io reads; tags: 1 in contact, 2 attracted, 4 in plastic
                   contact, 5 in contact and slipping; initial charges: pressure in
                   GPa
      sweep.restart.npz
                   all steps and the last state, from which a run is resumed
      view.traj    the same for viewing with ase gui: contact in purple, sphere cut
                   open, large windows thinned, heights enlarged
      curve.png    contact area against load, with Eq. (4) of Pastewka & Robbins
                   (2016), and with adhesion JKR, DMT and Maugis-Dugdale; of a loop
                   also under tension
      force.png    force against penetration or height; for paths of these, and for
                   paths with tension other than loops
      loop.png     force against depth of a loop; with a cantilever also
                   cantilever.png and cantilever.csv, its force curve
      contact.png  maps of the contact pressure of four steps
      stress.png   stresses below the surface, if they are asked for
      friction.png, tractions.png
                   lateral force and areas of stick and slip of a sliding path, and
                   maps of the lateral tractions
      time.png     force and area over time and over depth, of a path in time
      scene.toml   the scene

    An interrupted run is resumed by running it again with the same folder. If the
    reader of its output ends before, such as head, it goes on without printing.

    Steps that exceed a limit of the model, such as the hardness of the substrate, are
    marked in the table and in curve.csv. With --strict the run stops at the first of
    them.

    With --preview a part of the steps is calculated on a grid of up to four times the
    spacing, in a part of the time, into the folder DIR-preview. The errors of the areas
    are estimated, as in any run. A run of few steps in small windows is calculated
    itself, since it takes little longer. Of a loop the deepest state is shown.

    Exit status: 0 all steps converged, 1 some did not, 2 the scene or the folder is
    invalid, a file of it is damaged, or a step exceeds a limit with --strict, 130
    interrupted (Ctrl-C), 143 terminated (SIGTERM).
    """
    scene = checked_scene(options)
    steps: list[LoadStep] = []
    if options.preview:
        full, scene = scene, preview(scene)
        if scene is full and prints_text(options):
            write("The run is as short as a preview: it is calculated itself.")
        options.out = options.out.with_name(f"{options.out.name}-preview")
    scene.check_path()  # before theory needs the statistics of the roughness
    reference = reference_for(scene)
    try:
        _relax(options, reference, steps)
    except ERRORS:
        if steps:
            with suppress(OSError, MemoryError):  # do not mask the first error
                _write_results(options, reference, steps)
        raise
    failure = _write_results(options, reference, steps)
    return 0 if all(step.converged for step in steps) and not failure else 1


def _relax(
    options: argparse.Namespace, reference: Reference, steps: list[LoadStep]
) -> None:
    """Relax all steps, print each, and append it to a list."""
    scene, folder = reference.scene, options.out
    text = None if options.preview else scene_text(options)[0]
    schedule, timer = scene.path.schedule(scene.bodies), None
    if schedule:
        timer = TimeMeter(schedule, scene.path.expected_counts(scene.bodies))
    costs: dict[str, dict[int, float]] = {}
    count = scene.path.count(scene.bodies)
    earlier = read_restart(folder / RESTART)
    # a step that is relaxed again takes another time
    seconds = [step.columns["seconds"] for step in earlier.steps] if earlier else []
    restored = len(seconds)
    if count is not None:
        # more steps than the scene has belong to another scene, which `run` refuses
        restored = min(restored, count)
        costs["path"] = step_costs(scene)
    meter = ProgressMeter(costs)
    for number in range(restored):
        meter.finish("path", number)
    meter.progress()
    validity: Reaction = "raise" if options.strict else "ignore"  # the table has them
    table = report.StepTable(reference, options.verbose)
    with progress_bar(options) as draw:
        step: Any
        for step in scene.run(folder, validity, text):
            if not steps and prints_text(options):
                show(entries(report.inputs(reference).items()), "")
            steps.append(step)
            is_restored = seconds[len(steps) - 1 : len(steps)] == [step.seconds]
            meter.finish("path", step.step)
            if timer and is_restored:
                timer.restart(step.time)
            elif timer:
                timer.finish(step.time)
            parts = table.parts(step, restored=is_restored)
            if parts and prints_text(options):
                show(*parts)
            if options.json:
                write(step_line(step))
            if draw and costs:
                progress = meter.progress()
                draw(progress.steps, progress.total, str(progress))
            elif draw and schedule:
                draw(step.time, schedule.duration, str(timer))


def _write_results(
    options: argparse.Namespace, reference: Reference, steps: list[LoadStep]
) -> str:
    """Draw figures, print a summary and the files; return the error of figures."""
    pictures, failure = _draw_pictures(reference, steps, options.out)
    if prints_text(options):
        show(*report.summary(reference, steps))
        write(f"Results are in {options.out}:")
        show(report.files_table(pictures, steps))
        write(f"To view it: ase gui -R=-60x {options.out / 'view.traj'}")
    if failure:
        print_error(failure)
    return failure


def _draw_pictures(
    reference: Reference,
    steps: list[LoadStep],
    folder: Path,
    shown: list[LoadStep] | None = None,
    stress_view: StressView | None = None,
    ending: str = "png",
) -> tuple[list[str], str]:
    """Draw figures, write the trajectory for viewing; return names and the error."""
    from ase_roughcontact.cli import figures  # imports matplotlib

    scene, failure = reference.scene, ""
    pictures = figures.draw(reference, steps, folder, shown, stress_view, ending)
    try:
        pictures.extend(scene.path.draw(scene.bodies, steps, folder, ending))
    except ValueError as error:  # the states themselves are valid
        failure = str(error)
    figures.write_view(scene, steps, folder)
    return pictures, failure


def draw_figures(options: argparse.Namespace) -> int:
    """Draw the figures of a run again.

    Draws curve.png, force.png, contact.png and, if stresses below the surface are asked
    for, stress.png of a finished or interrupted run, and writes view.traj, as "run"
    does. With --format pdf, svg or eps the figures are vector graphics. Maps of a path
    in time show the steps closest to the times, for instance: --times 0.5,1,"1500 ms".

    In stress.png are a section, a map at a depth, and stresses on the vertical line
    through the largest stress of the section. Section and map contain the largest
    stress, unless their places are given, for instance: --along y --at "-2 nm" --depth
    "5 nm".
    """
    folder, scene, steps = _results_of(options)
    shown = _steps_at_times(folder, scene, steps, options.times)
    view = _stress_view(options, scene, folder)
    ending = options.format
    pictures, _ = _draw_pictures(
        reference_for(scene), steps, folder, shown, view, ending
    )
    seen = steps if shown is None else shown
    reason = report.reason_without_maps(seen, f"contact.{ending}" in pictures)
    if not pictures:
        raise RuntimeError(f"no figures, {reason}")
    write("\n".join(str(folder / name) for name in pictures))
    if reason:
        write(f"no contact.{ending}, {reason}")
    return 0


def write_report(options: argparse.Namespace) -> int:
    """Write DIR/report.html, the results of a run or of places on one page.

    The page begins with the main result and its error, and has warnings, input, figures
    and numbers of a finished or interrupted run. It needs no other file and no network:
    columns are drawn against each other, pressure, gap and contact of up to eight steps
    are shown, with the value under the pointer, and the table is sorted by a heading.
    What is shown can be saved as CSV, SVG or PNG. If stresses below the surface are
    asked for, a slider moves a map of the stress through the depth.
    """
    from ase_roughcontact.cli import figures  # imports matplotlib
    from ase_roughcontact.cli.page import page, page_of_places  # imports jinja2
    from ase_roughcontact.cli.page_data import data_of_run

    table = options.folder / "places.csv"
    if table.is_file():
        folder, scene = options.folder, Scene.of_results(options.folder)
        text = page_of_places(reference_for(scene), read_places(table), folder)
    else:
        folder, scene, steps = _results_of(options)
        reference = reference_for(scene)
        pictures, _ = _draw_pictures(reference, steps, folder)
        stresses = figures.stress_pictures(scene, steps, folder)
        data = data_of_run(Results(folder)) if steps else None
        text = page(reference, steps, folder, pictures, stresses, data)
    file = folder / "report.html"
    with replaced(file) as name:
        Path(name).write_text(text, encoding="utf-8")
    write(str(file))
    return 0


def write_maps(options: argparse.Namespace) -> int:
    """Write the pressure, gap, displacement and contact of each step to DIR/maps.

    The run may be finished or interrupted; steps with a frame in sweep.traj have maps,
    with [output] keep = "all" all steps. The format is NetCDF (nc), arrays of NumPy
    (npz) or the format of ParaView (vti). With --times 0.5,1,"1500 ms" only the steps
    of a path in time that are closest to these times have maps. With --depths 1,"50 Å"
    the stress at these depths below the surface is written, too, to stress-0000 and so
    on; in the format of ParaView it is a file vti, which OVITO reads, too, if these are
    two or more equally spaced depths, else a file vtr.
    """
    folder, scene, steps = _results_of(options)
    shown = _steps_at_times(folder, scene, steps, options.times)
    surface = scene.sampled_surface
    wanted = {step.step: step for step in steps if shown is None or step in shown}
    depths = _depths(options.depths, scene, folder)
    refuse_link(folder / "maps")
    (folder / "maps").mkdir(exist_ok=True)
    for frame in frames_of_steps(folder / "sweep.traj", wanted):
        number = frame.info["load_step"]["step"]
        name = folder / "maps" / f"step-{number:04d}.{options.format}"
        contact_map = ContactMap.from_frame(frame, surface)
        write_map(contact_map, name, wanted[number])
        write(str(name))
        if depths:
            suffix = options.format
            if suffix == "vti" and not equally_spaced(depths):
                suffix = "vtr"
            name = folder / "maps" / f"stress-{number:04d}.{suffix}"
            write_stress(contact_map, scene.solid, depths, name)
            write(str(name))
    return 0


def _depths(text: str | None, scene: Scene, folder: Path) -> list[float]:
    """Return the depths in an option (Å); none without it."""
    if text is None:
        return []
    _check_stresses("--depths", scene, folder)
    return sorted(_depth("--depths", each) for each in text.split(","))


def _stress_view(
    options: argparse.Namespace, scene: Scene, folder: Path
) -> StressView | None:
    """Return section and depth in the options of figures; None without them."""
    from ase_roughcontact.cli.stress_figures import StressView  # imports matplotlib

    given = {
        "--along": options.along,
        "--at": options.at,
        "--depth": options.depth,
    }
    given = {name: value for name, value in given.items() if value is not None}
    if not given:
        return None
    _check_stresses(next(iter(given)), scene, folder)
    return StressView(
        along=options.along or "x",
        at=None if options.at is None else _length("--at", options.at),
        depth=None if options.depth is None else _depth("--depth", options.depth),
    )


def _check_stresses(option: str, scene: Scene, folder: Path) -> None:
    """Raise `ValueError` if an option needs stresses that the solid does not have."""
    if not scene.solid.has_subsurface:
        raise ValueError(
            f"{option} needs Poisson's ratio or elastic constants: give poisson in "
            f"[substrate] of {folder / 'scene.toml'}"
        )


def _depth(option: str, text: str) -> float:
    """Return a depth in an option (Å)."""
    depth = _length(option, text)
    if not 0.0 <= depth < math.inf:
        raise ValueError(f"{option} must be a length of at least 0, got {text}")
    return depth


def _length(option: str, text: str) -> float:
    """Return a length in an option, in nm or with a unit (Å)."""
    try:
        return float(text) * UNITS["nm"]
    except ValueError:
        return quantity(option, text, LENGTHS, "nm")


def _results_of(options: argparse.Namespace) -> tuple[Path, Scene, list[LoadStep]]:
    """Return the folder of a run, its scene and its steps."""
    scene = Scene.of_results(options.folder)
    steps_with_frames(options.folder / "sweep.traj")  # raises before anything is drawn
    steps = read_steps(options.folder / RESTART, scene.record)
    return options.folder, scene, steps


def _steps_at_times(
    folder: Path, scene: Scene, steps: list[Any], text: str | None
) -> list[Any] | None:
    """Return the steps with a frame closest to the given times; None without times."""
    if text is None:
        return None
    schedule = scene.path.schedule(scene.bodies)
    if schedule is None:
        raise ValueError(
            f'--times needs a path of kind = "time", got kind = "{scene.path.kind}"'
        )
    numbers = places_of_steps(folder / "sweep.traj")
    with_frame = [step for step in steps if step.step in numbers]
    times = np.array([step.time for step in with_frame])
    found = set()
    for each in text.split(","):
        try:
            time = float(each)
        except ValueError:
            time = quantity("--times", each, TIMES, "s")
        if not 0.0 <= time <= schedule.duration:
            raise ValueError(
                f"--times must be between 0 and the {schedule.duration:g} s of the "
                f"path, got {time:g} s"
            )
        found.add(int(abs(times - time).argmin()))
    return [with_frame[number] for number in sorted(found)]
