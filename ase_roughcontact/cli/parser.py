"""The commands of ``ase-roughcontact``, their options and what ``--help`` tells."""

from __future__ import annotations

import argparse
from importlib.metadata import version
from pathlib import Path
from typing import Any

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
  curve.png    area against load, beside Eq. (4) of the paper, and with adhesion
               JKR, DMT and Maugis-Dugdale
  force.png    force against penetration or height: for paths of these, and for all
               with tension
  contact.png  maps of the contact at four loads
  scene.toml   the scene

Pictures need matplotlib.

A run that was stopped goes on where it was when started again with the same folder.
Exit status: 0 all steps converged, 1 some did not, 2 the scene or the folder is wrong,
130 interrupted.
"""

PLAN = """\
Tell window, grid, memory and time of every step before anything is calculated, and what
is left out and why that is allowed.

The time comes from a short measurement of the transforms on this machine, and is right
within a factor of about three. A step that can't be calculated tells why. Exit status:
0 all steps can run, and fit into the memory that is free, 1 not all, 2 the scene is
wrong.
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

COMPLETION = """\
Print a line for ~/.bashrc, which lets bash complete commands and options of
ase-roughcontact when Tab is pressed.
"""


def make_parser() -> argparse.ArgumentParser:
    """Return the parser; ``options.action`` is the name of the command."""
    parser = argparse.ArgumentParser("ase-roughcontact", description=DESCRIPTION)
    number = version("ase-roughcontact")
    parser.add_argument("--version", action="version", version=f"%(prog)s {number}")
    commands = parser.add_subparsers(required=True, metavar="command")

    def command(name: str, told: str, text: str) -> argparse.ArgumentParser:
        made = commands.add_parser(
            name,
            help=told,
            description=text,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        made.set_defaults(action=name)
        return made

    def scene_file(made: argparse.ArgumentParser) -> None:
        made.add_argument(
            "scene", nargs="?", help="scene file (TOML); by default the built-in scene"
        )

    def how_to_tell(made: argparse.ArgumentParser, line: str = "per step") -> Any:
        how = made.add_mutually_exclusive_group()
        how.add_argument("--quiet", action="store_true", help="tell errors only")
        how.add_argument("--json", action="store_true", help=f"a line of JSON {line}")
        return how

    run = command("run", "press the sphere in, plot area against load", RUN)
    scene_file(run)
    run.add_argument(
        "--out",
        metavar="DIR",
        type=Path,
        default=Path("roughcontact-out"),
        help="folder of the results, made if it is not there (default: %(default)s)",
    )
    how_to_tell(run).add_argument(
        "--verbose", action="store_true", help="tell how each step was obtained"
    )

    plan = command("plan", "tell windows, memory and time beforehand", PLAN)
    scene_file(plan)
    how_to_tell(plan)

    ensemble = command("ensemble", "run many variants of a scene", ENSEMBLE)
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

    trade = command("tradeoff", "measure what accuracy costs in a scene", TRADEOFF)
    scene_file(trade)
    trade.add_argument(
        "--error",
        type=float,
        default=1e-3,
        help="relative error that is allowed (default: %(default)s)",
    )
    how_to_tell(trade, "per setting")

    figure = command(
        "figure",
        "draw the pictures of a run again",
        "Draw curve.png, force.png and contact.png of a run's folder, and write its "
        'view.traj, as "run" does.',
    )
    figure.add_argument("folder", metavar="DIR", type=Path, help="folder of the run")

    command(
        "scene",
        "print the built-in scene, a template for your own",
        "Print the built-in scene file: every key is explained in it.",
    )

    completion = command(
        "completion", "complete commands and options in bash", COMPLETION
    )
    completion.add_argument("words", nargs=argparse.REMAINDER, help=argparse.SUPPRESS)
    return parser
