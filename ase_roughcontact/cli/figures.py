"""Figures of a run of a scene, and its trajectory for viewing."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from ase.io import write

from ase_roughcontact import plot
from ase_roughcontact._util.files import replaced
from ase_roughcontact._util.units import UNITS, printed_unit, with_unit
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.analysis.view import with_indenter
from ase_roughcontact.cli.stress_figures import (
    DepthPicture,
    StressView,
    depth_pictures,
    draw_stress,
)
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.loading.trajectory import (
    frame_of_step,
    frames_of_steps,
    places_of_steps,
)
from ase_roughcontact.optimize.comparison_result import OptimizerComparison
from ase_roughcontact.plot.files import written
from ase_roughcontact.plot.style import (
    BRANCHES,
    LINES,
    legend_below,
    letter,
    letters,
)
from ase_roughcontact.plot.surfaces import map_panels
from ase_roughcontact.results.record import LoadStep, columns_of
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.printed import units_in_print
from ase_roughcontact.scene.reference import Reference

# Number of maps in a figure.
_MAPS_PER_FIGURE = 4
# Maps share their range if their widths differ by at most this factor.
_MAX_WIDTH_RATIO = 3.0
# Ratio of the largest pressures of maps from which small pressures have more colours.
_MAX_PEAK_RATIO = 1.5
# Number of points of a curve of theory.
_CURVE_POINTS = 60
# Factor by which a curve of theory exceeds the steps.
_CURVE_EXTENT = 1.2


def write_view(scene: Scene, steps: Sequence[Any], folder: Path) -> None:
    """Write view.traj: few atoms, contact in colour, indenter cut open.

    For a path in time it has the steps that are printed.

    Parameters
    ----------
    scene : Scene
    steps : sequence of LoadStep
        All steps.
    folder : path
        Folder with the ``sweep.traj`` of the run.
    """
    surface, schedule = scene.sampled_surface, scene.path.schedule(scene.bodies)
    file = folder / "sweep.traj"
    # a run that was killed may have left the frame of a step that is not finished
    shown = [n for n in places_of_steps(file) if n < len(steps)]
    if not shown:
        return
    if schedule:
        kept = schedule.sampled_steps([step.time for step in steps])
        shown = sorted({min(shown, key=lambda n: abs(n - step)) for step in kept})
    views = [with_indenter(frame, surface) for frame in frames_of_steps(file, shown)]
    with replaced(folder / "view.traj") as name:
        write(name, views, format="traj")


def draw(
    reference: Reference,
    steps: Sequence[LoadStep],
    folder: Path,
    shown: Sequence[LoadStep] | None = None,
    stress_view: StressView | None = None,
    ending: str = "png",
) -> list[str]:
    """Draw the figures of a run.

    Parameters
    ----------
    reference : Reference
        Theory for the scene.
    steps : sequence of LoadStep
        All steps.
    folder : path
        Folder with the ``sweep.traj`` of the run.
    shown : sequence of LoadStep, optional
        Steps with a frame, in order. Those in contact have maps; by default four.
    stress_view : StressView, optional
        What stress.png shows. It is drawn for the largest load if this is given, or
        stresses below the surface are asked for.
    ending : str
        Ending of the names of the files, which is their format.

    Returns
    -------
    list of str
        Names of the files, here with png: curve.png, if a force is compressive;
        force.png, for paths of penetrations or heights and paths with tension, but not
        for loops, which have a figure of their own; contact.png, if atoms are in
        contact; stress.png, if stresses below the surface are asked for. Paths in time
        have the last two only.
    """
    names, scene = [], reference.scene
    path = scene.path
    if not path.in_order and any(_is_compressive(step) for step in steps):
        draw_area = _draw_flat if scene.is_flat else _draw_curve
        if path.is_loop:
            draw_area = _draw_loop_area
        names.append(f"curve.{ending}")
        draw_area(reference, steps, folder / names[-1])
    tension = any(step.normal_force < -step.tolerance for step in steps)
    force = tension or (path.controlled != LOAD and names)
    if force and not (path.in_order or path.is_loop):
        names.append(f"force.{ending}")
        _draw_force(reference, steps, folder / names[-1])
    touching = _touching(_with_frames(steps, folder) if shown is None else shown)
    if touching:
        maps = _chosen_steps(touching) if shown is None else touching
        names.append(f"contact.{ending}")
        _draw_maps(reference, steps, maps, folder / names[-1])
    if touching and (stress_view or _has_stress(scene)):
        step = _of_largest_load(touching)
        seen, title = _contact_map(step, folder), _title(scene, step, "")
        view = stress_view or StressView()
        names.append(f"stress.{ending}")
        draw_stress(scene, seen, title, folder / names[-1], view)
    return names


def stress_pictures(
    scene: Scene, steps: Sequence[LoadStep], folder: Path
) -> list[DepthPicture]:
    """Return pictures of the stress at some depths below the largest load.

    Parameters
    ----------
    scene : Scene
    steps : sequence of LoadStep
        All steps.
    folder : path
        Folder with the ``sweep.traj`` of the run.

    Returns
    -------
    list of DepthPicture
        Empty unless stresses below the surface are asked for, and atoms in contact.
    """
    touching = _touching(_with_frames(steps, folder))
    if not touching or not _has_stress(scene):
        return []
    seen = _contact_map(_of_largest_load(touching), folder)
    return list(depth_pictures(scene, seen))


def _has_stress(scene: Scene) -> bool:
    """Return whether stresses below the surface are asked for and known."""
    return scene.asks_for_stress and scene.solid.has_subsurface


def _with_frames(steps: Sequence[LoadStep], folder: Path) -> list[LoadStep]:
    """Return the steps that have a frame in the trajectory."""
    numbers = places_of_steps(folder / "sweep.traj")
    return [step for step in steps if step.step in numbers]


def _of_largest_load(steps: Sequence[LoadStep]) -> LoadStep:
    return max(steps, key=lambda step: step.normal_force)


def _contact_map(step: LoadStep, folder: Path) -> ContactMap:
    """Return the map of a step that has a frame."""
    return ContactMap.from_frame(frame_of_step(folder / "sweep.traj", step.step))


def _column(steps: Sequence[LoadStep], name: str) -> FloatArray:
    """Return a column of some steps."""
    return np.array([getattr(step, name) for step in steps])


def draw_optimizers(compared: OptimizerComparison, file: Path) -> None:
    """Draw the errors of optimizers against their costs."""
    with written(file, 3.2, width=6.0) as figure:
        plot.plot_optimizers(figure.subplots(), compared)


def _is_compressive(step: LoadStep) -> bool:
    """Return whether the force is larger than the tolerance of the optimizer."""
    tolerance = step.tolerance if step.converged else 0.0
    return step.normal_force > tolerance and step.repulsive_atoms > 0


def _draw_curve(reference: Reference, steps: Sequence[LoadStep], file: Path) -> None:
    """Draw the area, and relative to Hertz, against load beside theory."""
    scene = reference.scene
    (force_scale, area_scale), labels = _scales(scene)
    shown = [step for step in steps if _is_compressive(step)]
    forces, areas = _column(shown, "normal_force"), _column(shown, scene.area_column)
    errors, converged = _column(shown, "area_error"), _column(shown, "converged")
    along = np.geomspace(
        forces.min() / _CURVE_EXTENT, _CURVE_EXTENT * forces.max(), _CURVE_POINTS
    )
    hertz, rough = scene.bodies.hertz_area(along), reference.rough_area(along)
    spheres = reference.smooth, *reference.limits
    adhesive = {c.label: c.contact_area(along) for c in spheres if c.pull_off_force}
    factor = scene.wall.asperity_factor
    curvature = r"\rho/R" if factor == 1.0 else rf"{factor:g}\rho/R"
    first = np.where(rough <= reference.plateau * hertz, reference.plateau, np.nan)
    theory = {
        "Eq. (4): theory, rough sphere": rough,
        **adhesive,
        rf"first asperity: theory, $({curvature})^{{2/3}}$": first * hertz,
    }
    absolute, relative = {}, {}
    for name, area in theory.items():
        if np.isfinite(area).any():
            labelled = scene.bodies.labelled(name)
            absolute[labelled] = along / force_scale, area / area_scale
            relative[labelled] = along / force_scale, area / hertz
    label = _simulation(scene)
    plain = scene.bodies.nonadhesive
    smooth = plain.label
    if adhesive:
        smooth += " without adhesion"
    smooth = scene.bodies.labelled(smooth)
    with written(file, 5.4) as figure:
        upper, lower = panels = figure.subplots(2, 1, sharex=True)
        upper.plot(along / force_scale, hertz / area_scale, color=plot.GREY, lw=1)
        loads = forces / force_scale
        values, bars = areas / area_scale, errors / area_scale
        of_hertz = scene.bodies.hertz_area(forces) / area_scale
        plot.plot_area(upper, loads, values, absolute, converged, bars, label)
        plot.plot_curve(
            lower, loads, values, of_hertz, relative, converged, smooth, bars, label
        )
        upper.set_ylabel(labels[1])
        lower.set_xlabel(labels[0])
        lower.set_ylabel(rf"contact area $A/A_\mathrm{{{plain.symbol}}}$")
        upper.label_outer()
        letter(panels)
        if len(shown) < len(steps):
            upper.set_title("steps under compression")
        legend_below(figure, panels)


def _scales(scene: Scene) -> tuple[tuple[float, float], tuple[str, str]]:
    """Return the printed units of force and area, and labels of axes with them."""
    units = units_in_print(scene)
    force, area = units["normal_force"], units["contact_area"]
    labels = (
        f"normal force $N$ ({force})",
        f"contact area ({area.replace('²', '$^2$')})",
    )
    return (UNITS[force], UNITS[area]), labels


def _simulation(scene: Scene) -> str:
    """Return the label of simulated areas: wall, grid, and whether they are random."""
    grid = "continuum" if scene.is_continuum else "atoms"
    spacing = with_unit(scene.grid_change.spacing(scene.spacing), "nm")
    name = "simulation" if scene.seed is None else "simulation (one realisation)"
    return f"{name}:\n{scene.wall.label}, {grid}, spacing {spacing}"


def _draw_loop_area(
    reference: Reference, steps: Sequence[LoadStep], file: Path
) -> None:
    """Draw the area over the force along a whole loop, beside theory."""
    scene = reference.scene
    (force_scale, area_scale), labels = _scales(scene)
    forces, areas = _column(steps, "normal_force"), _column(steps, scene.area_column)
    errors, converged = _column(steps, "area_error"), _column(steps, "converged")
    branches = np.array(scene.path.branch_names(scene.bodies, steps))
    along = np.linspace(forces.min(), forces.max(), 10 * _CURVE_POINTS)
    theory = {
        each.label: each.contact_area(along)
        for each in (reference.smooth, *reference.limits)
    }
    push = np.maximum(along, 0.0)
    if reference.smooth.pull_off_force:
        hertz = np.where(along > 0.0, scene.bodies.hertz_area(push), np.nan)
        theory[f"{scene.bodies.nonadhesive.label} without adhesion"] = hertz
    rough = np.where(along > 0.0, reference.rough_area(push), np.nan)
    theory["Eq. (4): theory, rough sphere"] = rough
    with written(file, 3.8) as figure:
        axes = figure.subplots()
        shown = {name: area for name, area in theory.items() if np.isfinite(area).any()}
        for number, (name, area) in enumerate(shown.items()):
            line, label = f"k{LINES[number % len(LINES)]}", scene.bodies.labelled(name)
            axes.plot(along / force_scale, area / area_scale, line, lw=0.8, label=label)
        for name, colour, width in BRANCHES:
            part = (branches == name) & converged
            points = forces[part] / force_scale, areas[part] / area_scale
            axes.plot(*points, ".-", color=colour, lw=width, ms=3, label=name)
            bars = 2.0 * errors[part] / area_scale
            axes.errorbar(*points, bars, fmt="none", ecolor=colour, lw=0.8)
        axes.axvline(0.0, color=plot.GREY, lw=0.6)
        axes.set(xlabel=labels[0], ylabel=labels[1])
        axes.set_ylim(bottom=0.0)
        legend_below(figure, [axes])


def _draw_flat(reference: Reference, steps: Sequence[Any], file: Path) -> None:
    """Draw area, mean gap and stiffness of a rough flat against nominal pressure."""
    scene: Any = reference.scene
    shown = [step for step in steps if _is_compressive(step)]
    pressure = _column(shown, "normal_force") / scene.bodies.nominal_area
    area, error = _column(shown, scene.area_column), _column(shown, "area_error")
    modulus, nominal = scene.contact_modulus, scene.bodies.nominal_area
    with written(file, 6.0) as figure:
        panels = upper, middle, lower = figure.subplots(3, 1)
        scale = scene.rough.rms_slope * modulus
        plot.plot_flat_area(upper, pressure, area / nominal, scale, error / nominal)
        plot.plot_flat_gap(middle, pressure, _column(shown, "mean_gap"))
        stiffness, conductance = _column(shown, "contact_stiffness"), None
        if "conductance" in columns_of(scene.record):
            conductance = _column(shown, "conductance")
        plot.plot_flat_conductance(lower, pressure, stiffness, modulus, conductance)
        upper.legend(
            title=scene.bodies.labelled("theory") if scene.solid.half_space else None
        )
        letter(panels)


def _draw_force(reference: Reference, steps: Sequence[LoadStep], file: Path) -> None:
    scene = reference.scene
    along = scene.path.along
    by_height = along == "height"
    label = scene.path.columns.get(along, along)  # as in the table
    first_contact = steps[0].height + steps[0].penetration
    spheres = reference.smooth, *reference.limits
    curves = {scene.bodies.labelled(each.label): each for each in spheres}
    theory = scene.bodies.forces_over_depth(curves, steps)
    if by_height:
        for name, (depth, force) in theory.items():
            theory[name] = first_contact - depth, force
    unit = units_in_print(scene)[along]
    scale, error = UNITS[unit], f"{along}_error"
    theory = {name: (depth / scale, force) for name, (depth, force) in theory.items()}
    with written(file, 3.4) as figure:
        axes = figure.subplots()
        plot.plot_force(
            axes,
            _column(steps, along) / scale,
            [step.normal_force for step in steps],
            theory,
            None if theory else reference.smooth.pull_off_force or None,
            f"{label} ({unit})",
            [step.converged for step in steps],
            scene.bodies.labelled(f"pull-off: theory, {reference.smooth.sphere}"),
            _column(steps, error) / scale,
            _column(steps, "force_error"),
        )
        legend_below(figure, [axes])


def _touching(steps: Sequence[LoadStep]) -> list[LoadStep]:
    """Return the steps in contact."""
    return [step for step in steps if step.repulsive_atoms]


def _chosen_steps(steps: Sequence[LoadStep]) -> list[LoadStep]:
    """Return at most four different steps, with the deepest one."""
    states = {(s.height, s.normal_force, s.contact_area): s for s in steps}
    touching = list(states.values())
    chosen = np.linspace(0, len(touching) - 1, _MAPS_PER_FIGURE).round().astype(int)
    deepest = int(np.argmax(_column(touching, "penetration")))
    chosen[np.argmin(abs(chosen - deepest))] = deepest
    return [touching[i] for i in np.unique(chosen)]


def _draw_maps(
    reference: Reference,
    steps: Sequence[LoadStep],
    shown: Sequence[LoadStep],
    file: Path,
) -> None:
    """Draw maps of some steps, with the contact of a smooth sphere under their load."""
    branches = reference.scene.path.branch_names(reference.scene.bodies, steps)
    titles = []
    for letter_of_map, step in zip(letters(len(shown)), shown, strict=True):
        branch = branches[steps.index(step)]
        titles.append(f"({letter_of_map}) {_title(reference.scene, step, branch)}")
    scene, smooth = reference.scene, reference.smooth
    unit = printed_unit("eV/Å^3", scene.contact_modulus)
    peaks = [step.largest_pressure / UNITS[unit] for step in shown]
    exponent = 0.5 if max(peaks) > _MAX_PEAK_RATIO * min(peaks) else 1.0
    label = scene.bodies.labelled(smooth.label)
    if scene.solid.creep is not None:
        label += ",\ninstantaneous modulus"
    rows, columns = -(-len(shown) // 2), min(len(shown), 2)
    lines = 1 + max(title.count("\n") for title in titles)
    height = 0.5 + rows * (2.6 / columns + 0.16 * lines)
    with written(file, height) as figure:
        panels = map_panels(figure, len(shown))
        numbers = [step.step for step in shown]
        frames = frames_of_steps(file.parent / "sweep.traj", numbers)
        maps = zip(panels, frames, shown, titles, strict=True)
        for panel, frame, step, title in maps:
            area = float(smooth.contact_area(step.normal_force))
            circle = area > 0.0 and not scene.is_flat
            plot.plot_contact(
                panel,
                frame,
                math.sqrt(area / np.pi) if circle else None,
                max(peaks),
                title,
                circle_label=label,
                around_load=scene.whole_tip is not None,
                unit=unit,
                exponent=exponent,
            )
            image = panel.images[0]
            if scene.is_flat:  # the whole cell
                left, right, bottom, top = image.get_extent()
                panel.set(xlim=(left, right), ylim=(bottom, top))
        if not scene.is_flat:
            _share_range(panels)
        for panel in panels:
            plot.show_as_scanned(panel, scene.bodies.scanned)
            plot.scale_bar(panel, "nm")
        figure.colorbar(image, ax=panels, label=f"pressure ({unit})", shrink=0.7)
        legend_below(figure, panels)


def _title(scene: Scene, step: Any, branch: str) -> str:
    """Return the position of a step on the path."""
    is_zero = abs(step.normal_force) <= step.tolerance
    units = units_in_print(scene)  # the same for all maps
    unit = units["normal_force"]
    lines = [f"{_short(0.0 if is_zero else step.normal_force / UNITS[unit])} {unit}"]
    if scene.is_flat:
        pressure, unit = step.nominal_pressure, units["nominal_pressure"]
        lines = [f"{_short(pressure / UNITS[unit])} {unit}"]
    if scene.path.in_time:
        lines.insert(0, f"{_short(step.time)} s")
    elif scene.control != LOAD:
        along = scene.path.along
        value, unit = getattr(step, along), units[along]
        lines.insert(0, f"{along} {_short(value / UNITS[unit])} {unit}")
    lines[-1] += f", {branch}" if branch else ""
    return "\n".join(lines if step.converged else [*lines, "NOT CONVERGED"])


def _short(value: float) -> str:
    return np.format_float_positional(value, precision=3, fractional=False, trim="-")


def _share_range(panels: Sequence[Any]) -> None:
    """Give maps the same range, unless contacts would be too small to be seen."""
    limits = np.array([(panel.get_xlim(), panel.get_ylim()) for panel in panels])
    halves = np.ptp(limits[:, 0], axis=1) / 2.0
    if halves.max() <= _MAX_WIDTH_RATIO * halves.min():
        half = np.array([-1.0, 1.0]) * halves.max()
        for panel, (x, y) in zip(panels, limits.mean(axis=2), strict=True):
            panel.set(xlim=x + half, ylim=y + half)
