"""Commands and options of ``ase-roughcontact``."""

from __future__ import annotations

import argparse
import ast
import re
from collections.abc import Callable
from difflib import get_close_matches
from importlib import import_module
from pathlib import Path
from textwrap import fill
from typing import Any, NoReturn

from ase_roughcontact._util.parts import found_parts
from ase_roughcontact._util.printing import write

# Completion of names of files, in the format of shtab.
_FILE_COMPLETION = {"bash": "_shtab_compgen_files", "zsh": "_files", "tcsh": "f"}
# Completion of names of folders, in the format of shtab.
_FOLDER_COMPLETION = {"bash": "_shtab_compgen_dirs", "zsh": "_files -/", "tcsh": "d"}
# Options of arguments for a folder.
_FOLDER_OPTIONS: dict[str, Any] = {
    "metavar": "DIR",
    "type": Path,
    "completion": _FOLDER_COMPLETION,
}


class _Parser(argparse.ArgumentParser):
    """Parser that suggests similar words, and imports a command when it is needed."""

    function = ""

    def error(self, message: str) -> NoReturn:
        """Print the message, with a similar command or option, and exit."""
        choice = re.search(r"invalid choice: '(.*?)' \(choose from (.*)\)", message)
        option = re.search(r"unrecognized arguments: (--?[\w-]+)", message)
        similar: list[str] = []
        if choice:
            similar = get_close_matches(choice[1], re.findall(r"[\w-]+", choice[2]))
        elif option:
            options = re.findall(r"--[\w-]+", self.format_usage())
            similar = get_close_matches(option[1], options)
        hint = f"; did you mean {' or '.join(map(repr, similar))}?" if similar else ""
        super().error(message + hint)

    def print_help(self, file: Any = None) -> None:
        """Print the help."""
        write(self.format_help().rstrip())

    def format_help(self) -> str:
        """Return the help, described by the docstring of the command."""
        if self.function:
            parts = _docstring(self.function).replace("::\n", ":\n").split("\n\n")
            for number, part in enumerate(parts):
                is_example = "\n " in part or part.startswith(" ")
                if not is_example:
                    parts[number] = fill(part, 79)
            self.description = "\n\n".join(parts)
        return super().format_help()


def _docstring(name: str) -> str:
    """Return the docstring of a command from its source, as an import takes seconds."""
    module, _, function = name.partition(".")
    source = Path(__file__).with_name(f"{module}.py").read_text(encoding="utf-8")
    for node in ast.parse(source).body:
        if isinstance(node, ast.FunctionDef) and node.name == function:
            return ast.get_docstring(node) or ""
    raise LookupError(f"no function {name}")


def function_of(name: str) -> Callable[[argparse.Namespace], int]:
    """Return the function of a command by its module and name in this package."""
    module, _, function = name.partition(".")
    return getattr(import_module(f"ase_roughcontact.cli.{module}"), function)


def make_parser() -> argparse.ArgumentParser:
    """Return the parser; its option ``function`` names the function of the command."""
    parser = _Parser(
        "ase-roughcontact",
        description="Contact of a rough sphere, an indenter of another shape, a "
        "measured tip or a rough flat, rigid or elastic, with an elastic, plastic, "
        "layered or viscoelastic solid: at given loads or depths, in loops with "
        "adhesion, in time, and against friction.",
    )
    parser.add_argument("--version", action="store_true", help="print the version")
    text = "with --version: versions of the dependencies"
    parser.add_argument("-v", "--verbose", action="store_true", help=text)
    parser.set_defaults(parser=parser)
    subparsers = parser.add_subparsers(dest="command", metavar="command")

    def command(name: str, summary: str, function: str) -> argparse.ArgumentParser:
        added = subparsers.add_parser(
            name,
            help=summary,
            description=summary,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        added.function = function
        added.set_defaults(function=function, parser=added)
        return added

    _add_run(command("run", "run a scene and draw figures", "runs.run"))
    plan = command("plan", "print windows, memory and time of a run", "commands.plan")
    _add_scene(plan)
    _add_output(plan)
    _add_ensemble(
        command("ensemble", "run many variants of a scene", "ensembles.ensemble")
    )
    _add_places(command("places", "map area and adhesion over a scan", "places.places"))
    if "tradeoff" in found_parts():
        summary = "measure the cost of accuracy in a scene"
        _add_tradeoff(command("tradeoff", summary, "tradeoff.measure_tradeoff"))
    summary = "compare optimizers on a scene"
    _add_optimizers(command("optimizers", summary, "commands.optimizers"))
    if "fitting" in found_parts():
        summary = "read a measured force curve and fit an indenter to it"
        _add_curve(command("curve", summary, "curve.curve"))
        summary = "fit an indenter to many force curves: a map, or a series"
        _add_curves(command("curves", summary, "curves.curves"))
        _add_fit(command("fit", "fit a scene to a measured force curve", "fit.fit"))
    summary = "write maps of pressure and gap of a run"
    maps = command("maps", summary, "runs.write_maps")
    _add_folder(maps)
    maps.add_argument(
        "--format", choices=["nc", "npz", "vti"], default="nc", help="default: nc"
    )
    maps.add_argument(
        "--depths",
        metavar="DEPTHS",
        help="write also the stress at these depths, in nm or with a unit, such as "
        '0.5,1,"20 Å"',
    )
    _add_times(maps)
    summary = "write the results of a run as one HTML page"
    _add_folder(command("report", summary, "runs.write_report"))
    summary = "draw the figures of a run again"
    figure = command("figure", summary, "runs.draw_figures")
    _add_folder(figure)
    formats = ["png", "pdf", "svg", "eps"]
    figure.add_argument("--format", choices=formats, default="png", help="default: png")
    _add_times(figure)
    _add_stress_view(figure)
    summary = "print the built-in scene as a template"
    command("scene", summary, "texts.print_scene")
    summary = "print a completion script"
    command("completion", summary, "texts.completion").add_argument(
        "shell",
        nargs="?",
        choices=["bash", "zsh", "tcsh"],
        default="bash",
        help="default: %(default)s",
    )
    return parser


def _add_run(parser: argparse.ArgumentParser) -> None:
    _add_scene(parser)
    _add_out(parser, "roughcontact-out")
    text = "stop at the first step that exceeds a limit of the model"
    parser.add_argument("--strict", action="store_true", help=text)
    text = "fewer steps on a coarse grid, with their errors, in DIR-preview"
    parser.add_argument("--preview", action="store_true", help=text)
    text = "print iterations, FFTs, residuals and errors"
    output = _add_output(parser)
    output.add_argument("-v", "--verbose", action="store_true", help=text)


def _add_ensemble(parser: argparse.ArgumentParser) -> None:
    _add_scene(parser)
    parser.add_argument(
        "--set",
        metavar="SECTION.KEY=VALUES",
        action="append",
        default=[],
        help="comma-separated values of a key of the scene file, or a range "
        "FIRST:LAST:STEPS[:geometric]",
    )
    parser.add_argument(
        "--error",
        type=float,
        help="relative standard error of the means, for as many seeds as needed",
    )
    text = "largest number of seeds for --error (default: %(default)s)"
    parser.add_argument("--most", type=int, metavar="N", default=1000, help=text)
    parser.add_argument(
        "--column",
        metavar="NAME",
        action="append",
        default=[],
        help="result of the path, or column of its steps, that is averaged over seeds; "
        "may be repeated",
    )
    parser.add_argument(
        "--over",
        metavar="SECTION.KEY",
        default="",
        help="parameter of the figure (default: the first one with several numbers)",
    )
    parser.add_argument(
        "--database",
        metavar="FILE",
        default="roughcontact.db",
        help="SQLite database, or postgresql://... (default: %(default)s)",
    )
    _add_path(
        parser, "--table", metavar="CSV", help="also write all steps to a CSV file"
    )
    _add_path(
        parser,
        "--results",
        metavar="CSV",
        help="also write a row for each case to a CSV file, with results of its path",
    )
    where = parser.add_mutually_exclusive_group()
    _add_workers(where)
    _add_plan(parser)
    where.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="scheduler of Dask with the workers: tcp://HOST:PORT, or the JSON "
        'file of "dask scheduler --scheduler-file"',
    )
    _add_output(parser)


def _add_places(parser: argparse.ArgumentParser) -> None:
    _add_path(parser, "scene", help="scene file (TOML)")
    parser.add_argument(
        "--grid",
        type=_grid,
        default=(8, 8),
        metavar="NxM",
        help="number of places along x and y (default: 8x8)",
    )
    _add_out(parser, "roughcontact-places")
    _add_workers(parser)
    _add_plan(parser)
    parser.add_argument("--quiet", action="store_true", help="print errors only")


def _add_tradeoff(parser: argparse.ArgumentParser) -> None:
    _add_scene(parser)
    text = "wanted relative error (default: %(default)s)"
    parser.add_argument("--error", type=float, default=1e-2, help=text)
    parser.add_argument(
        "--error-of",
        choices=["area", "force", "height"],
        default="area",
        help="answer that has the error; an error of the height is relative to the "
        "penetration (default: %(default)s)",
    )
    _add_picture(parser, "tradeoff.png")
    _add_output(parser, "per choice")


def _add_optimizers(parser: argparse.ArgumentParser) -> None:
    _add_scene(parser)
    parser.add_argument(
        "--names",
        metavar="LIST",
        help='comma-separated names, such as "NewtonKrylov, LBFGS, FIRE on modes", or '
        "all (default: the usual ones)",
    )
    text = "wanted relative error of force and area (default: %(default)s)"
    parser.add_argument("--error", type=float, default=1e-2, help=text)
    text = "largest number of steps of each (default: %(default)s)"
    parser.add_argument("--steps", type=int, default=2000, help=text)
    _add_path(parser, "--table", metavar="CSV", help="also write a CSV file")
    _add_picture(parser, "optimizers.png")
    _add_output(parser, "per optimizer")


def _add_fit(parser: argparse.ArgumentParser) -> None:
    _add_path(parser, "curve", type=Path, help="force curve: table, or export")
    _add_path(parser, "scene", help="scene file (TOML)")
    parser.add_argument(
        "--free",
        metavar="NAMES",
        help="comma-separated: work_of_adhesion, contact_modulus, radius, "
        "attraction_range, force_offset, force_slope (default: work_of_adhesion); of a "
        "path in time also relaxation_moduli, relaxation_times (default: both)",
    )
    _add_which(parser)
    _add_reading(parser)
    _add_picture(parser, "fit.png")
    _add_output(parser, "of the result")


def _add_curve(parser: argparse.ArgumentParser) -> None:
    _add_path(parser, "curve", type=Path, help="force curve: table, or export")
    parser.add_argument(
        "--at",
        metavar="X,Y",
        default="",
        help='the curve of a map that was measured there: "2 um, 3.5 um"',
    )
    _add_indenter(parser)
    _add_which(parser)
    _add_reading(parser)
    _add_picture(parser, "curve.png")
    _add_output(parser, "of the result")


def _add_curves(parser: argparse.ArgumentParser) -> None:
    text = "maps, archives, files of force curves, or folders of them"
    _add_path(parser, "files", nargs="+", type=Path, help=text)
    _add_indenter(parser)
    _add_reading(parser)
    _add_out(parser, "roughcontact-curves")
    _add_workers(parser)
    _add_output(parser, "per curve")


def _add_indenter(parser: argparse.ArgumentParser) -> None:
    """Add the options of the fit of an indenter."""
    parser.add_argument(
        "--indenter",
        metavar="SHAPE",
        default="",
        help='shape to fit, with its dimensions: "sphere 5 um", "cone 35 deg"',
    )
    text = "largest indentation that is fitted"
    parser.add_argument("--deepest", metavar="LENGTH", default="", help=text)
    parser.add_argument(
        "--relaxation",
        metavar="TERMS",
        type=int,
        default=0,
        help="number of relaxation times of a fit of approach and hold over time",
    )
    parser.add_argument(
        "--adhesion",
        choices=["jkr", "dmt"],
        default="",
        help="theory of an adhesive sphere, fitted to the retraction",
    )
    text = "of a layer on a rigid base"
    parser.add_argument("--thickness", metavar="LENGTH", default="", help=text)
    parser.add_argument(
        "--cantilever",
        metavar="STIFFNESS",
        default="",
        help='spring constant: "0.05 N/m" (default: the value in the file)',
    )


def _add_which(parser: argparse.ArgumentParser) -> None:
    """Add the option that chooses one of several curves."""
    parser.add_argument(
        "--curve",
        dest="curve_number",
        metavar="NUMBER",
        type=lambda text: int(text) if text.isdecimal() else text,
        help="which curve of a map or an archive, from 1, or its name in an archive",
    )


def _add_reading(parser: argparse.ArgumentParser) -> None:
    """Add the options by which a measured curve is read."""
    parser.add_argument(
        "--branch", choices=["approach", "retraction"], help="one branch of the curve"
    )
    parser.add_argument(
        "--sensitivity",
        metavar="LENGTH",
        default="",
        help='of the deflection: "50 nm/V" (default: the value in the file)',
    )
    parser.add_argument(
        "--columns",
        metavar="NAMES",
        type=lambda text: [name.strip() for name in text.split(",")],
        default=[],
        help='names and units of all columns in place of the heading: "height '
        '(m), deflection (V)"',
    )


def _grid(text: str) -> tuple[int, int]:
    """Return the numbers of a grid ``NxM``."""
    try:
        n, m = (int(number) for number in text.split("x"))
    except ValueError as error:
        message = f"must be NxM, such as 4x4, got {text!r}"
        raise argparse.ArgumentTypeError(message) from error
    return n, m


def _add_path(
    parser: argparse.ArgumentParser,
    *names: str,
    completion: dict[str, str] = _FILE_COMPLETION,
    **options: Any,
) -> None:
    """Add an argument for the name of a file or folder."""
    added: Any = parser.add_argument(*names, **options)
    added.complete = completion


def _add_scene(parser: argparse.ArgumentParser) -> None:
    text = "scene file (TOML); default: the built-in scene"
    _add_path(parser, "scene", nargs="?", help=text)


def _add_folder(parser: argparse.ArgumentParser) -> None:
    _add_path(parser, "folder", help="output folder of the run", **_FOLDER_OPTIONS)


def _add_times(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--times",
        metavar="LIST",
        help='comma-separated times of maps of a path in time, in s or "20 ms"',
    )


def _add_stress_view(parser: argparse.ArgumentParser) -> None:
    """Add the options of the figure of stresses."""
    text = "horizontal axis of the section in stress.png (default: x)"
    parser.add_argument("--along", choices=["x", "y"], help=text)
    for name, where in (
        ("at", "position of this section along the other axis"),
        ("depth", "depth of the map in stress.png"),
    ):
        parser.add_argument(
            f"--{name}",
            metavar="LENGTH",
            help=f"{where}, in nm or with a unit (default: where the von Mises stress "
            "is largest)",
        )


def _add_out(parser: argparse.ArgumentParser, default: str) -> None:
    text = "output folder, created if necessary (default: %(default)s)"
    _add_path(parser, "--out", default=Path(default), help=text, **_FOLDER_OPTIONS)


def _add_picture(parser: argparse.ArgumentParser, default: str) -> None:
    parser.add_argument(
        "--picture",
        metavar="FILE",
        type=Path,
        default=Path(default),
        help="figure; its ending is the format (default: %(default)s)",
    )


def _add_workers(parser: Any) -> None:
    text = "number of processes (default: one per processor)"
    parser.add_argument("--workers", type=int, help=text)


def _add_plan(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--plan",
        action="store_true",
        help="print number of cases, time, memory and files, and calculate nothing",
    )


def _add_output(parser: argparse.ArgumentParser, line: str = "per step") -> Any:
    group = parser.add_mutually_exclusive_group()
    group.add_argument("--quiet", action="store_true", help="print errors only")
    group.add_argument("--json", action="store_true", help=f"print a JSON line {line}")
    return group
