"""Commands that evaluate a scene without running it; docstrings are help."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from ase_roughcontact._util.printing import entries, show, write
from ase_roughcontact._util.units import UNITS, printed_unit
from ase_roughcontact.cli import report
from ase_roughcontact.cli.common import checked_scene, json_line
from ase_roughcontact.cli.description import bodies
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.optimize.names import optimizer_names
from ase_roughcontact.paths.planned_steps import TOTAL_UNITS, StartCosts
from ase_roughcontact.results.record import units_of
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.optimizers import compare_on
from ase_roughcontact.scene.run_plan import run_plan

# Units of the columns of a comparison of optimizers.
_UNITS_OF_OPTIMIZERS = {
    "seconds": "s",
    "seconds_to_accuracy": "s",
    "height_error": "Å",
    "energy_error": "eV",
}


def plan(options: argparse.Namespace) -> int:
    """Print window, FFT grid, memory and time of each step before it is calculated.

    The approximations that are made are printed with their reasons. The number of
    steps, their time, the memory and the size of all files follow from a trial, a run
    of the path, or of twelve of its steps, on a grid of up to four times the spacing,
    which takes up to a minute. A path with too many points for a trial is planned from
    FFTs timed on this machine, to a factor of three. Times are of the processor: with
    several threads less passes. For a step that can't be calculated the reason is
    printed. Windows in the table are expected ones; when "run" refuses a
    step it prints a lower bound. Of a loop and of a path in time the table has the
    deepest state. With --json the last line has the numbers of the whole run.

    Exit status, as for "run": 0 all steps can run in the free memory, 2 some can't, or
    the scene is invalid.
    """
    start = StartCosts.now()
    whole = checked_scene(options)
    scene, described = whole.planned, whole.path.describe(whole.bodies)
    planned = run_plan(whole, start.with_scene())
    unit = report.target_unit(scene)
    if options.json:
        units = {**units_of(), "target": unit}
        for step in planned.steps:
            write(json_line(asdict(step), units))
        write(json_line(planned.totals, TOTAL_UNITS))
    elif not options.quiet:
        steps = planned.printed(*_heading(scene, unit))
        about = [described, ""] if described else []
        show(entries(bodies(scene).items()), "", *about, *steps)
    return 0 if planned.runs else 2


def _heading(scene: Scene, unit: str) -> tuple[str, float]:
    """Return name and unit of the targets, and its size; of a flat the pressure."""
    if scene.is_flat and scene.control == LOAD:
        return "pressure (MPa)", UNITS["MPa"] * scene.bodies.nominal_area
    printed = printed_unit(unit)
    return f"{scene.control.name} ({printed})", UNITS[printed]


def optimizers(options: argparse.Namespace) -> int:
    """Compare optimizers of this package and of ASE on the deepest state of a scene.

    Each relaxes the same flat atoms, on the window of this state, to the forces that
    the wanted error of force and area needs. Steps, evaluations, FFT pairs and time,
    the pairs to this error, and the errors at the end are printed. Errors are relative
    to the state found by the solver for the wall: of force and area, the atoms in
    contact in only one of the states, and the difference of the energies. The reasons
    of failures follow. The error against the FFT pairs is drawn.

    Exit status: 0 all have found the state, 1 some have not, 2 the scene or a name is
    invalid.
    """
    from ase_roughcontact.cli import figures  # imports matplotlib
    from ase_roughcontact.plot.files import check_picture

    check_picture(options.picture)
    names = None
    if options.names == "all":
        names = optimizer_names()
    elif options.names:
        names = [name.strip() for name in options.names.split(",")]
    scene = checked_scene(options)
    compared = compare_on(scene, names, options.error, max_steps=options.steps)
    figures.draw_optimizers(compared, options.picture)
    if options.table:
        compared.write_csv(options.table)
    if options.json:
        for result in compared.results:
            values = {k: v for k, v in asdict(result).items() if k != "history"}
            write(json_line(values, _UNITS_OF_OPTIMIZERS))
    elif not options.quiet:
        show(*compared.parts)
        write(str(options.picture))
    found = [r.converged and not r.reason for r in compared.results]
    return 0 if all(found) else 1
