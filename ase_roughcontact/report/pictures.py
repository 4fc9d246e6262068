"""Pictures of a run of a scene, and the trajectory to look at."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from ase.io import Trajectory, read
from ase.parallel import DummyMPI

from ase_roughcontact.checks import FloatArray
from ase_roughcontact.record import LoadStep
from ase_roughcontact.report.laws import Law, Laws
from ase_roughcontact.scene import NANONEWTON, Scene
from ase_roughcontact.view import centred, with_indenter

# Atoms of a frame to look at: more are slow to draw, and smaller than a pixel.
_SHOWN = 6000
# Maps of the contact in one picture.
_MAPS = 4
# Points of a line of theory.
_POINTS = 60
# Lines of theory go this many times beyond the steps.
_BEYOND = 1.2


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


def draw(
    scene: Scene, laws: Laws, records: Sequence[LoadStep], folder: Path
) -> list[str]:
    """Draw what can be drawn of a run, if matplotlib is there.

    Parameters
    ----------
    scene : Scene
    laws : Laws
        Of the scene.
    records : sequence of LoadStep
        All steps.
    folder : path
        With the ``sweep.traj`` of the run.

    Returns
    -------
    list of str
        Of the pictures that were made: curve.png, if a step pushes; force.png, of
        paths of penetrations and heights, and of all with tension; contact.png, if
        atoms touch.
    """
    try:
        import matplotlib
    except ImportError:
        return []
    matplotlib.use("Agg")
    made = []
    if any(_pushes(record) for record in records):
        _draw_curve(scene, laws, records, folder / "curve.png")
        made.append("curve.png")
    tension = any(record.normal_force < 0.0 for record in records)
    if tension or (scene.path.control != "load" and made):
        _draw_force(scene, laws, records, folder / "force.png")
        made.append("force.png")
    touching = [record for record in records if record.repulsive_atoms]
    if touching:
        _draw_maps(laws, touching, folder)
        made.append("contact.png")
    return made


def _pushes(record: LoadStep) -> bool:
    return record.normal_force > 0.0 and record.repulsive_atoms > 0


def _draw_curve(
    scene: Scene, laws: Laws, records: Sequence[LoadStep], file: Path
) -> None:
    from matplotlib import pyplot

    from ase_roughcontact.plot import plot_curve

    pushed = [record for record in records if _pushes(record)]
    forces = np.array([record.normal_force for record in pushed])
    areas = np.array([record.contact_area for record in pushed])
    predicted = None if laws.predicts_force else scene.predicted_area(forces)
    if predicted is not None and np.isnan(predicted).all():
        predicted = None
    along = np.geomspace(forces.min() / _BEYOND, _BEYOND * forces.max(), _POINTS)
    sticky = [law for law in _drawn(laws) if law.pull_off_force < 0.0]
    figure, axes = pyplot.subplots(figsize=(5, 4), layout="constrained")
    plot_curve(
        axes,
        forces / NANONEWTON,
        areas,
        scene.hertz_area(forces),
        predicted,
        {
            law.name: (along / NANONEWTON, law.area(along) / scene.hertz_area(along))
            for law in sticky
        },
    )
    if len(pushed) < len(records):
        axes.set_title("steps that push (force.png has all)", fontsize="medium")
    figure.savefig(file, dpi=150)
    pyplot.close(figure)


def _draw_force(
    scene: Scene, laws: Laws, records: Sequence[LoadStep], file: Path
) -> None:
    from matplotlib import pyplot

    from ase_roughcontact.plot import plot_force

    high = scene.path.control == "height"
    first_contact = records[0].height + records[0].penetration
    lines: dict[str, tuple[FloatArray, FloatArray]] = {}
    # the penetration of a rough sphere counts from its highest peak, not from its mean
    if scene.roughness is None:
        area = max(record.contact_area for record in records)
        largest = _BEYOND * math.sqrt(area / np.pi) + scene.spacing
        for law in _drawn(laws):
            depth, force = law.curve(largest)
            lines[law.name] = first_contact - depth if high else depth, force
    pull_off = None if lines else laws.smooth.pull_off_force or None
    figure, axes = pyplot.subplots(figsize=(5, 4), layout="constrained")
    plot_force(
        axes,
        [record.height if high else record.penetration for record in records],
        [record.normal_force for record in records],
        lines,
        pull_off,
        "height of the indenter (Å)" if high else "penetration (Å)",
    )
    figure.savefig(file, dpi=150)
    pyplot.close(figure)


def _drawn(laws: Laws) -> tuple[Law, ...]:
    return laws.smooth, *laws.limits


def _draw_maps(laws: Laws, touching: Sequence[LoadStep], folder: Path) -> None:
    from matplotlib import pyplot

    from ase_roughcontact.plot import plot_contact

    chosen = np.unique(np.linspace(0, len(touching) - 1, _MAPS).round().astype(int))
    figure, panels = pyplot.subplots(
        1,
        len(chosen),
        figsize=(3.2 * len(chosen) + 0.8, 3.8),
        layout="constrained",
        squeeze=False,
    )
    frames = [read(folder / "sweep.traj", index=touching[i].step) for i in chosen]
    largest = max(frame.get_initial_charges().max() for frame in frames)
    circle = f"smooth sphere ({laws.smooth.name})"
    for panel, frame, i in zip(panels[0], frames, chosen, strict=True):
        force = touching[i].normal_force
        radius = math.sqrt(float(laws.smooth.area(np.array(force))) / np.pi)
        load = np.format_float_positional(
            force / NANONEWTON, precision=3, fractional=False, trim="-"
        )
        image = plot_contact(
            panel,
            frame,
            radius if radius > 0.0 else None,
            largest,
            f"{load} nN",
            circle=circle,
        )
        if panel is not panels[0, 0]:
            panel.set_ylabel("")
    figure.colorbar(image, ax=panels[0], label="pressure (GPa)", shrink=0.8)
    handles = {
        label: line
        for panel in panels[0]
        for line, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    if handles:
        figure.legend(
            handles.values(), handles.keys(), loc="outside lower center", frameon=False
        )
    figure.savefig(folder / "contact.png", dpi=110)
    pyplot.close(figure)
