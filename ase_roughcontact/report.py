"""What a run of a scene tells: lines of text, and pictures."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from ase.io import Trajectory, read
from ase.parallel import DummyMPI
from ase.units import GPa

from ase_roughcontact.record import LoadStep
from ase_roughcontact.scene import NANONEWTON, Scene
from ase_roughcontact.theory import hertz_contact_radius
from ase_roughcontact.view import centred, with_indenter

# Atoms of a frame to look at: more are slow to draw, and smaller than a pixel.
_SHOWN = 6000
# Maps of the contact in one picture.
_MAPS = 4


def heading(scene: Scene) -> str:
    """Return what is calculated, and the head of the table of steps."""
    return (
        f"{scene.substrate.symbol}, spacing {scene.spacing:.3f} Å, "
        f"E* = {scene.contact_modulus / GPa:.4g} GPa; sphere of radius "
        f"{scene.radius / 10:.4g} nm, {scene.interaction.kind} wall\n\n"
        "   step   load (nN)   area (nm²)   A/A_Hertz   Eq. (4)   iterations   time (s)"
    )


def row(scene: Scene, record: LoadStep, total: int, kept: bool = False) -> str:
    """Return the line of a step.

    Parameters
    ----------
    scene : Scene
    record : LoadStep
    total : int
        Number of steps.
    kept : bool
        Whether it was calculated by an earlier run.

    Returns
    -------
    str
    """
    force = max(record.normal_force, 0.0)
    hertz = float(scene.hertz_area(force)) or np.nan
    predicted = float(scene.predicted_area(force))
    mark = "" if record.converged else f"   NOT CONVERGED: {record.message}"
    time = "       kept" if kept else f"{record.seconds:11.2f}"
    return (
        f"{record.step + 1:4d}/{total:<3d}{record.normal_force / NANONEWTON:11.4g}"
        f"{record.contact_area / 100:13.4g}{record.contact_area / hertz:12.4f}"
        f"{predicted / hertz:10.4f}{record.iterations:13d}{time}{mark}"
    )


def write_view(scene: Scene, folder: Path) -> None:
    """Write view.traj: the path to look at, sphere cut open, large windows thinned.

    Parameters
    ----------
    scene : Scene
    folder : path
        With the ``sweep.traj`` of its run.
    """
    surface = scene.surface
    with (
        Trajectory(folder / "sweep.traj") as frames,
        Trajectory(folder / "view.traj", "w", comm=DummyMPI()) as view,
    ):
        for frame in frames:
            every = math.ceil(math.sqrt(len(frame) / _SHOWN))
            shown = with_indenter(frame, surface, half=True, every=every)
            view.write(centred(shown))


def farewell(folder: Path, pictures: list[str]) -> str:
    """Return where the results are, and how to look at them."""
    lines = ["", f"Results are in {folder}:"]
    lines += [f"  {folder / name}" for name in pictures]
    if not pictures:
        lines.append("  (no pictures: matplotlib is not installed, or nothing touched)")
    lines += [
        f"  {folder / 'curve.csv'}",
        f"  {folder / 'sweep.traj'}, all atoms",
        f"  {folder / 'view.traj'}, to look at:",
        f"    ase gui {folder / 'view.traj'}",
        "In the window of ase gui choose View > Colors > By tag (1: contact) or",
        "By initial charge (pressure in GPa), and step through the frames.",
    ]
    return "\n".join(lines)


def draw(scene: Scene, records: list[LoadStep], folder: Path) -> list[str]:
    """Draw curve.png and contact.png if matplotlib is there; return their names."""
    try:
        import matplotlib
    except ImportError:
        return []
    matplotlib.use("Agg")
    pushed = [record for record in records if record.normal_force > 0]
    if not pushed:
        return []
    _draw_curve(scene, pushed, folder / "curve.png")
    _draw_maps(scene, pushed, folder)
    return ["curve.png", "contact.png"]


def _draw_curve(scene: Scene, pushed: list[LoadStep], file: Path) -> None:
    from matplotlib import pyplot

    from ase_roughcontact.plot import plot_curve

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
    figure.savefig(file, dpi=150)
    pyplot.close(figure)


def _draw_maps(scene: Scene, pushed: list[LoadStep], folder: Path) -> None:
    from matplotlib import pyplot

    from ase_roughcontact.plot import plot_contact

    chosen = np.unique(np.linspace(0, len(pushed) - 1, _MAPS).round().astype(int))
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
