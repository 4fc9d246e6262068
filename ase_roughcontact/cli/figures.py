"""Pictures of a run of a scene, and the trajectory to look at."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from ase import Atoms
from ase.io import Trajectory, read
from ase.parallel import DummyMPI
from ase.units import GPa

from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.atoms.snapshot import pressure_of
from ase_roughcontact.atoms.view import centred, with_indenter
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.trajectory import count_steps
from ase_roughcontact.scene import NANONEWTON, Scene
from ase_roughcontact.scene.reference import Reference
from ase_roughcontact.scene.sphere_theory import SphereTheory

# Atoms of a frame to look at: more are slow to draw, and smaller than a pixel.
_SHOWN = 6000
# Maps of the contact in one picture.
_MAPS = 4
# Maps whose widths differ by no more than this factor get one range.
_ALIKE = 3.0
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
        for number in range(count_steps(folder / "sweep.traj")):
            frame = frames[number]
            every = math.ceil(math.sqrt(len(frame) / _SHOWN))
            shown = with_indenter(frame, surface, half=True, every=every)
            view.write(centred(shown))


def draw(
    scene: Scene, laws: Reference, records: Sequence[LoadStep], folder: Path
) -> list[str]:
    """Draw what can be drawn of a run, if matplotlib is there.

    Parameters
    ----------
    scene : Scene
    laws : Reference
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
    tension = any(record.normal_force < -record.tolerance for record in records)
    if tension or (scene.path.control != "load" and made):
        _draw_force(scene, laws, records, folder / "force.png")
        made.append("force.png")
    touching = [record for record in records if record.repulsive_atoms]
    if touching:
        titles = [_title(scene, records, record) for record in touching]
        _draw_maps(laws, touching, titles, folder)
        made.append("contact.png")
    return made


def _pushes(record: LoadStep) -> bool:
    """Whether a step pushes by more than was left to the optimizer."""
    least = record.tolerance if record.converged else 0.0
    return record.normal_force > least and record.repulsive_atoms > 0


def _converged(records: Sequence[LoadStep]) -> list[bool]:
    return [record.converged for record in records]


def _draw_curve(
    scene: Scene, laws: Reference, records: Sequence[LoadStep], file: Path
) -> None:
    from matplotlib import pyplot

    from ase_roughcontact.plot import plot_curve

    pushed = [record for record in records if _pushes(record)]
    forces = np.array([record.normal_force for record in pushed])
    areas = np.array([record.contact_area for record in pushed])
    predicted = laws.rough_area(forces)
    along = np.geomspace(forces.min() / _BEYOND, _BEYOND * forces.max(), _POINTS)
    sticky = [law for law in _drawn(laws) if law.pull_off_force < 0.0]
    figure, axes = pyplot.subplots(
        figsize=(5, 5 if sticky else 4), layout="constrained"
    )
    plot_curve(
        axes,
        forces / NANONEWTON,
        areas,
        scene.hertz_area(forces),
        None if np.isnan(predicted).all() else predicted,
        {
            law.label: (
                along / NANONEWTON,
                law.contact_area(along) / scene.hertz_area(along),
            )
            for law in sticky
        },
        _converged(pushed),
        _hertz_label(laws),
    )
    if len(pushed) < len(records):
        axes.set_title("steps that push", fontsize="medium")
    if sticky:
        _legend_below(figure, [axes])
    figure.savefig(file, dpi=150)
    pyplot.close(figure)


def _draw_force(
    scene: Scene, laws: Reference, records: Sequence[LoadStep], file: Path
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
            lines[law.label] = first_contact - depth if high else depth, force
    pull_off = None if lines else laws.smooth.pull_off_force or None
    figure, axes = pyplot.subplots(figsize=(5, 4.6), layout="constrained")
    plot_force(
        axes,
        [record.height if high else record.penetration for record in records],
        [record.normal_force for record in records],
        lines,
        pull_off,
        "height of the indenter (Å)" if high else "penetration (Å)",
        _converged(records),
        f"pull-off: theory, {laws.smooth.sphere}",
    )
    _legend_below(figure, [axes])
    figure.savefig(file, dpi=150)
    pyplot.close(figure)


def _drawn(laws: Reference) -> tuple[SphereTheory, ...]:
    return laws.smooth, *laws.limits


def _hertz_label(laws: Reference) -> str:
    sticky = " without adhesion" if laws.smooth.work_of_adhesion else ""
    return f"Hertz: theory, smooth sphere{sticky}"


def _title(scene: Scene, records: Sequence[LoadStep], record: LoadStep) -> str:
    """Tell where on the path a step is."""
    residue = abs(record.normal_force) <= record.tolerance
    force = 0.0 if residue else record.normal_force / NANONEWTON
    told = f"{_short(force)} nN"
    if scene.path.control != "load":
        told = f"{scene.path.control} {_short(getattr(record, scene.path.control))} Å"
        told += f", {_short(force)} nN"
    sinks = np.diff([each.penetration for each in records]) > 0.0
    sinks = np.append(True, sinks)  # it comes from above
    if sinks.any() and not sinks.all():
        told += "\napproach" if sinks[records.index(record)] else "\nretraction"
    return told if record.converged else f"{told}\nNOT CONVERGED"


def _short(value: float) -> str:
    return np.format_float_positional(value, precision=3, fractional=False, trim="-")


def _draw_maps(
    laws: Reference, touching: Sequence[LoadStep], titles: Sequence[str], folder: Path
) -> None:
    from matplotlib import pyplot

    chosen = np.unique(np.linspace(0, len(touching) - 1, _MAPS).round().astype(int))
    height = 4.1 + 0.3 * max(title.count("\n") for title in titles)
    figure, panels = pyplot.subplots(
        1,
        len(chosen),
        figsize=(3.2 * len(chosen) + 0.8, height),
        layout="constrained",
        squeeze=False,
    )
    frames = [read(folder / "sweep.traj", index=touching[i].step) for i in chosen]
    largest = max(pressure_of(frame).max() for frame in frames) / GPa
    for panel, frame, i in zip(panels[0], frames, chosen, strict=True):
        image = _draw_map(laws, touching[i], frame, panel, largest)
        panel.set_title(titles[i])
        if panel is not panels[0, 0]:
            panel.set_ylabel("")
    _share_range(panels[0])
    figure.colorbar(image, ax=panels[0], label="pressure (GPa)", shrink=0.8)
    _legend_below(figure, panels[0])
    figure.savefig(folder / "contact.png", dpi=110)
    pyplot.close(figure)


def _legend_below(figure: Any, panels: Sequence[Any]) -> None:
    """Put one legend of all panels below them, where it hides nothing."""
    handles = {
        label: line
        for panel in panels
        for line, label in zip(*panel.get_legend_handles_labels(), strict=True)
    }
    for panel in panels:
        if panel.get_legend():
            panel.get_legend().remove()
    if handles:
        figure.legend(
            handles.values(), handles.keys(), loc="outside lower center", frameon=False
        )


def _draw_map(
    laws: Reference, record: LoadStep, frame: Atoms, panel: Any, largest: float
) -> Any:
    """Draw a step, and the contact of a smooth sphere under its load."""
    from ase_roughcontact.plot import plot_contact

    area = float(laws.smooth.contact_area(np.array(record.normal_force)))
    radius = math.sqrt(area / np.pi) if area > 0.0 else None
    return plot_contact(panel, frame, radius, largest, circle=laws.smooth.label)


def _share_range(panels: Sequence[Any]) -> None:
    """Give maps one range, unless contacts would be too small to be seen."""
    reaches = [panel.get_xlim()[1] for panel in panels]
    if max(reaches) <= _ALIKE * min(reaches):
        for panel in panels:
            panel.set_xlim(-max(reaches), max(reaches))
            panel.set_ylim(-max(reaches), max(reaches))
