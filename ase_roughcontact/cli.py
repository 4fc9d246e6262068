"""The command ``ase-roughcontact``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from ase.io import read
from ase.units import GPa

from ase_roughcontact.record import LoadStep
from ase_roughcontact.scene import NANONEWTON, Scene, default_text
from ase_roughcontact.theory import hertz_contact_radius

DESCRIPTION = "Contact of a rigid rough sphere with an elastic solid."

RUN = """\
Press the sphere of a scene into its substrate, step by step.

Without a file it runs the built-in scene, which "ase-roughcontact scene" prints: a
template for your own, with every key explained. The folder gets

  curve.csv    one line per step: heights and penetrations in Angstrom, forces in
               eV/Angstrom, areas in Angstrom^2, energies in eV
  sweep.traj   ASE trajectory, one frame per step: tag 1 is an atom in contact, 2 one
               that is attracted; initial charges are pressures in GPa
  curve.png    area against load, beside Eq. (4) of the paper (with matplotlib)
  contact.png  maps of the contact at four loads (with matplotlib)

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


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    options = _parser().parse_args(arguments)
    try:
        return options.action(options)
    except (ValueError, RuntimeError, OSError, MemoryError) as error:
        print(f"ase-roughcontact: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\nstopped; what was calculated is kept", file=sys.stderr)
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser("ase-roughcontact", description=DESCRIPTION)
    commands = parser.add_subparsers(required=True, metavar="command")
    run = commands.add_parser(
        "run",
        help="press the sphere into the substrate and plot area against load",
        description=RUN,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    run_scene = "scene file (TOML); by default the built-in scene"
    run.add_argument("scene", nargs="?", help=run_scene)
    run.add_argument(
        "--out",
        metavar="DIR",
        default="roughcontact-out",
        help="folder of the results, made if it is not there (default: %(default)s)",
    )
    run.set_defaults(action=_run)
    plan = commands.add_parser(
        "plan",
        help="tell windows, memory and time of a scene before it is run",
        description=PLAN,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    plan.add_argument("scene", nargs="?", help=run_scene)
    plan.set_defaults(action=_plan)
    scene = commands.add_parser(
        "scene", help="print the built-in scene, a template for your own"
    )
    scene.set_defaults(action=_print_scene)
    return parser


def _print_scene(options: argparse.Namespace) -> int:
    print(default_text(), end="")
    return 0


def _scene(options: argparse.Namespace) -> Scene:
    return Scene.read(options.scene) if options.scene else Scene.default()


def _plan(options: argparse.Namespace) -> int:
    scene = _scene(options)
    plan = scene.plan()
    heading, unit = {
        "load": ("load (nN)", NANONEWTON),
        "penetration": ("penetration (Å)", 1.0),
        "height": ("height (Å)", 1.0),
    }[scene.path.control]
    print(plan.table(heading, unit))
    return 0 if plan.fits else 1


def _run(options: argparse.Namespace) -> int:
    scene = _scene(options)
    folder = Path(options.out)
    records = []
    total = len(scene.steps)
    print(_heading(scene))
    for record in scene.run(folder):
        records.append(record)
        print(_row(scene, record, total), flush=True)
    pictures = _draw(scene, records, folder)
    print(_farewell(folder, pictures))
    return 0 if all(record.converged for record in records) else 1


def _heading(scene: Scene) -> str:
    return (
        f"{scene.substrate.symbol}, spacing {scene.spacing:.3f} Å, "
        f"E* = {scene.contact_modulus / GPa:.4g} GPa; sphere of radius "
        f"{scene.radius / 10:.4g} nm, {scene.interaction.kind} wall\n\n"
        "   step   load (nN)   area (nm²)   A/A_Hertz   Eq. (4)   iterations   time (s)"
    )


def _row(scene: Scene, record: LoadStep, total: int) -> str:
    force = max(record.normal_force, 0.0)
    hertz = float(scene.hertz_area(force)) or np.nan
    predicted = float(scene.predicted_area(force))
    mark = "" if record.converged else "   NOT CONVERGED"
    return (
        f"{record.step + 1:4d}/{total:<3d}{record.normal_force / NANONEWTON:11.4g}"
        f"{record.contact_area / 100:13.4g}{record.contact_area / hertz:12.4f}"
        f"{predicted / hertz:10.4f}{record.iterations:13d}{record.seconds:11.2f}{mark}"
    )


def _draw(scene: Scene, records: list[LoadStep], folder: Path) -> list[str]:
    try:
        import matplotlib
    except ImportError:
        return []
    matplotlib.use("Agg")
    from matplotlib import pyplot

    from ase_roughcontact.plot import plot_contact, plot_curve

    pushed = [record for record in records if record.normal_force > 0]
    if not pushed:
        return []
    forces = np.array([record.normal_force for record in pushed])
    areas = np.array([record.contact_area for record in pushed])
    figure, axes = pyplot.subplots(figsize=(5, 4), layout="constrained")
    plot_curve(
        axes,
        forces / NANONEWTON,
        areas,
        scene.hertz_area(forces),
        scene.predicted_area(forces),
    )
    figure.savefig(folder / "curve.png", dpi=150)
    pyplot.close(figure)

    chosen = np.unique(np.linspace(0, len(pushed) - 1, 4).round().astype(int))
    figure, panels = pyplot.subplots(
        1,
        len(chosen),
        figsize=(3.2 * len(chosen) + 0.8, 3.6),
        layout="constrained",
        squeeze=False,
    )
    frames = [read(folder / "sweep.traj", index=pushed[i].step) for i in chosen]
    largest = max(frame.get_initial_charges().max() for frame in frames)
    for panel, frame, i in zip(panels[0], frames, chosen, strict=True):
        force = pushed[i].normal_force
        radius = hertz_contact_radius(force, scene.radius, scene.contact_modulus)
        load = np.format_float_positional(
            force / NANONEWTON, precision=3, fractional=False, trim="-"
        )
        image = plot_contact(panel, frame, float(radius), largest, f"{load} nN")
        if panel is not panels[0, 0]:
            panel.set_ylabel("")
    figure.colorbar(image, ax=panels[0], label="pressure (GPa)", shrink=0.8)
    figure.savefig(folder / "contact.png", dpi=110)
    pyplot.close(figure)
    return ["curve.png", "contact.png"]


def _farewell(folder: Path, pictures: list[str]) -> str:
    lines = ["", f"Results are in {folder}:"]
    lines += [f"  {folder / name}" for name in pictures]
    if not pictures:
        lines.append("  (no pictures: matplotlib is not installed)")
    lines += [
        f"  {folder / 'curve.csv'}",
        f"  ase gui {folder / 'sweep.traj'}",
        "In the window of ase gui choose View > Colors > By tag (1: contact) or",
        "By initial charge (pressure in GPa), and step through the frames.",
    ]
    return "\n".join(lines)
