"""Commands and options of ``ase-roughcontact``, and their help texts."""

from __future__ import annotations

import argparse
from importlib.metadata import version
from pathlib import Path
from typing import Any

# Completions of arguments in the format of shtab.
FILE = {"bash": "_shtab_compgen_files", "zsh": "_files", "tcsh": "f"}
DIRECTORY = {"bash": "_shtab_compgen_dirs", "zsh": "_files -/", "tcsh": "d"}

DESCRIPTION = "Contact of a rigid rough sphere with an elastic solid."

RUN = """\
Press the sphere of a scene into the substrate, step by step.

Without a scene file the built-in scene is run. "ase-roughcontact scene" prints it, as a
template with a description of each key. Files in the output folder:

  curve.csv    one line per step: heights and penetrations in Å, forces in eV/Å, areas
               in Å^2, energies in eV
  sweep.traj   ASE trajectory with one frame per step; tags: 1 in contact, 2 attracted;
               initial charges: pressure in GPa
  view.traj    the same for viewing with ase gui: contact in purple, sphere cut open,
               large windows thinned, heights enlarged
  curve.png    contact area against load, with Eq. (4) of Pastewka & Robbins (2016), and
               with adhesion JKR, DMT and Maugis-Dugdale
  force.png    force against penetration or height; for paths of these, and for paths
               with tension
  contact.png  maps of the contact pressure of four steps
  scene.toml   the scene

An interrupted run is resumed by running it again with the same folder.

Steps that exceed a limit of the model, such as the hardness of the substrate, are
marked in the table and in curve.csv. With --strict the run stops at the first of them.

With --preview a part of the steps is calculated on a grid of up to four times the
spacing, in a part of the time, into the folder DIR-preview. The errors of
the areas are estimated, as in any run.

Exit status: 0 all steps converged, 1 some did not, 2 the scene or the folder is
invalid, a file of it is damaged, or a step exceeds a limit with --strict, 130
interrupted (Ctrl-C), 143 terminated (SIGTERM).
"""

PLAN = """\
Print window, FFT grid, memory and time of each step before anything is calculated, and
which approximations are made and why.

The time is extrapolated from FFTs timed on this machine, and correct within a factor of
about three. For a step that can't be calculated the reason is printed.

Exit status: 0 all steps can run in the free memory, 1 some can't, 2 the scene is
invalid.
"""

ENSEMBLE = """\
Run a scene for all combinations of some values, in parallel, and store the steps in an
ASE database. An interrupted ensemble is resumed by running it again. For five
realisations of the roughness on two spheres:

  ase-roughcontact ensemble my.toml --set roughness.seed=0,1,2,3,4 \\
                                    --set sphere.radius=100.0,1000.0

With --error, realisations are added until the standard error of the mean area at every
step is below it. Each load gets as many as it needs, which a pilot of 8 predicts:

  ase-roughcontact ensemble my.toml --error 0.05

With --scheduler, the workers of a Dask cluster calculate, on any number of machines:

  dask scheduler --port 8786
  dask worker tcp://HOST:8786 --nthreads 1
  ase-roughcontact ensemble my.toml --scheduler tcp://HOST:8786

Exit status: 0 all steps are stored, 1 some cases failed or the error is larger, 2 the
scene or the database is invalid or damaged, 130 interrupted (Ctrl-C), 143 terminated
(SIGTERM).
"""

PLACES = """\
Run a scene with the tip at a grid of places on its scan, in parallel, and draw maps of
the contact area and of the pull-off force: DIR/places.csv and DIR/places.png. The
margin of [topography] keeps the places away from the edges. An interrupted run is
resumed by running it again.

Exit status: 0 all places have a result, 1 some have none, 2 the scene or the folder is
invalid.
"""

TRADEOFF = """\
Measure the errors and costs of choices on a few steps of a scene: tolerance or grid,
free or periodic boundary, wall, theory instead of simulation, and number of surfaces.
Print the cheapest numerical settings for a wanted error of the area, check them on
another surface, and draw error against time.

Exit status: 0 the settings have the wanted error, 1 none have, 2 the scene is invalid.
"""

FIT = """\
Fit parameters of a scene to a measured force curve by least squares, with derivatives
from the relaxed states, and draw data, fit and residuals. The curve is a CSV file with
the columns "force (nN)" and "depth (nm)", or "distance (nm)" of the base and
"deflection (nm)" of the cantilever; the zero of the depth is fitted. Beside it, the
work of adhesion of a smooth sphere is fitted by the theory of Maugis and Dugdale.
"""

MAPS = """\
Write the pressure, gap, displacement and contact of each step of a finished or
interrupted run to DIR/maps: as NetCDF (nc), arrays of NumPy (npz) or for ParaView
(vti).
"""

REPORT = """\
Write DIR/report.html: input, warnings, figures and numbers of a finished or interrupted
run on one page that needs no other file.
"""

FIGURE = """\
Draw curve.png, force.png and contact.png of a finished or interrupted run again, and
write view.traj, as "run" does.
"""

SCENE = """\
Print the built-in scene file, a template with a description of each key.
"""

COMPLETION = """\
Print a script that completes commands and options of ase-roughcontact in a shell. It
needs shtab (pip install '.[completion]' in the folder of the source code). For bash:

  ase-roughcontact completion > ~/.ase-roughcontact-completion
  echo 'source ~/.ase-roughcontact-completion' >> ~/.bashrc
"""


def make_parser() -> argparse.ArgumentParser:
    """Return the parser; its option ``command`` is the name of the command."""
    parser = argparse.ArgumentParser("ase-roughcontact", description=DESCRIPTION)
    number = version("ase-roughcontact")
    parser.add_argument("--version", action="version", version=f"%(prog)s {number}")
    commands = parser.add_subparsers(required=True, metavar="command")

    def command(name: str, summary: str, text: str) -> argparse.ArgumentParser:
        added = commands.add_parser(
            name,
            help=summary,
            description=text,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        added.set_defaults(command=name, verbose=False, again="continue")
        return added

    run = command("run", "run a scene and draw figures", RUN)
    _add_scene(run)
    folder = run.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("roughcontact-out"),
        help="output folder, created if necessary (default: %(default)s)",
    )
    run.add_argument(
        "--strict",
        action="store_true",
        help="stop at the first step that exceeds a limit of the model",
    )
    run.add_argument(
        "--preview",
        action="store_true",
        help="fewer steps on a coarse grid, with their errors, in DIR-preview",
    )
    output = _add_output(run)
    output.add_argument(
        "--verbose", action="store_true", help="print iterations, FFTs and residuals"
    )

    plan = command("plan", "print windows, memory and time of a run", PLAN)
    _add_scene(plan)
    _add_output(plan)

    ensemble = command("ensemble", "run many variants of a scene", ENSEMBLE)
    _add_scene(ensemble)
    ensemble.add_argument(
        "--set",
        metavar="SECTION.KEY=VALUES",
        action="append",
        default=[],
        help="comma-separated values of a key of the scene file",
    )
    ensemble.add_argument(
        "--error",
        type=float,
        help="relative standard error of the mean areas, for as many seeds as needed",
    )
    ensemble.add_argument(
        "--database",
        metavar="FILE",
        default="roughcontact.db",
        help="SQLite database, or postgresql://... (default: %(default)s)",
    )
    table = ensemble.add_argument(
        "--table", metavar="CSV", help="also write all steps to a CSV file"
    )
    where = ensemble.add_mutually_exclusive_group()
    where.add_argument(
        "--workers", type=int, help="number of processes (default: one per processor)"
    )
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="scheduler of Dask, whose workers calculate: tcp://HOST:PORT, or the JSON "
        'file of "dask scheduler --scheduler-file"',
    )
    _add_output(ensemble)

    places = command("places", "map area and adhesion over a scan", PLACES)
    places_scene = places.add_argument("scene", help="scene file (TOML)")
    places.add_argument(
        "--grid",
        type=_grid,
        default=(8, 8),
        metavar="NxM",
        help="number of places along x and y (default: 8x8)",
    )
    places_folder = places.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("roughcontact-places"),
        help="output folder, created if necessary (default: %(default)s)",
    )
    places.add_argument(
        "--workers", type=int, help="number of processes (default: one per processor)"
    )
    places.add_argument("--quiet", action="store_true", help="print errors only")

    trade = command("tradeoff", "measure the cost of accuracy in a scene", TRADEOFF)
    _add_scene(trade)
    trade.add_argument(
        "--error",
        type=float,
        default=1e-2,
        help="wanted relative error of the area (default: %(default)s)",
    )
    trade_picture = trade.add_argument(
        "--picture",
        metavar="FILE",
        type=Path,
        default=Path("tradeoff.png"),
        help="figure (default: %(default)s)",
    )
    _add_output(trade, "per choice")

    fit = command("fit", "fit a scene to a measured force curve", FIT)
    curve = fit.add_argument("curve", metavar="CSV", type=Path, help="force curve")
    fit_scene = fit.add_argument("scene", help="scene file (TOML)")
    fit.add_argument(
        "--free",
        metavar="NAMES",
        default="work_of_adhesion",
        help="comma-separated: work_of_adhesion, contact_modulus, radius (default: "
        "%(default)s)",
    )
    fit.add_argument(
        "--branch", choices=["approach", "retraction"], help="rows of a column branch"
    )
    fit.add_argument(
        "--picture",
        metavar="FILE",
        type=Path,
        default=Path("fit.png"),
        help="figure (default: %(default)s)",
    )

    maps = command("maps", "write maps of pressure and gap of a run", MAPS)
    map_folder = maps.add_argument(
        "folder", metavar="DIR", type=Path, help="output folder of the run"
    )
    maps.add_argument(
        "--format", choices=["nc", "npz", "vti"], default="nc", help="default: nc"
    )

    page = command("report", "write the results of a run as one HTML page", REPORT)
    page_folder = page.add_argument(
        "folder", metavar="DIR", type=Path, help="output folder of the run"
    )

    figure = command("figure", "draw the figures of a run again", FIGURE)
    run_folder = figure.add_argument(
        "folder", metavar="DIR", type=Path, help="output folder of the run"
    )
    command("scene", "print the built-in scene as a template", SCENE)
    completion = command("completion", "print a completion script", COMPLETION)
    completion.add_argument(
        "shell",
        nargs="?",
        choices=["bash", "zsh", "tcsh"],
        default="bash",
        help="default: %(default)s",
    )
    for each in (trade_picture, curve, fit_scene, places_scene):
        each.complete = FILE  # type: ignore[attr-defined]
    for each in (folder, run_folder, map_folder, page_folder, places_folder):
        each.complete = DIRECTORY  # type: ignore[attr-defined]
    table.complete = FILE  # type: ignore[attr-defined]
    return parser


def _grid(text: str) -> tuple[int, int]:
    """Return the numbers of a grid ``NxM``."""
    n, m = (int(number) for number in text.split("x"))
    return n, m


def _add_scene(parser: argparse.ArgumentParser) -> None:
    scene = parser.add_argument(
        "scene", nargs="?", help="scene file (TOML); default: the built-in scene"
    )
    scene.complete = FILE  # type: ignore[attr-defined]


def _add_output(parser: argparse.ArgumentParser, line: str = "per step") -> Any:
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--quiet", action="store_true", help="print errors only")
    group.add_argument("--json", action="store_true", help=f"print a JSON line {line}")
    return group
