"""Text printed by a run of a scene."""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from operator import attrgetter
from pathlib import Path

from ase_roughcontact._util.text import cell, duration
from ase_roughcontact._util.units import UNITS, printed_unit
from ase_roughcontact.cli.description import description, pull_off_text
from ase_roughcontact.elasticity import Layer
from ase_roughcontact.ensemble import Progress
from ase_roughcontact.paths.limits import failed_checks
from ase_roughcontact.paths.record import LoadStep, TimeStep, columns_of
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import Reference

# Time of a run before which nothing is said about the time left (s).
_START = 2.0
# Error of an area from which a line below the table says so.
_SHOWN_ERROR = 0.001


def print_error(message: object) -> None:
    """Print an error or a warning as a line on the error output."""
    print(f"ase-roughcontact: {message}", file=sys.stderr)


def print_trial(values: Mapping[str, float], residual: float) -> None:
    """Print a trial of a fit as a line on the error output.

    Parameters
    ----------
    values : mapping of str to float
        Parameters by name, in the units of the fit.
    residual : float
        Root mean square of the residuals relative to the noise.
    """
    parameters = ", ".join(f"{name} {value:.5g}" for name, value in values.items())
    print(f"residual/noise {residual:.4g}: {parameters}", file=sys.stderr, flush=True)


def table_header(reference: Reference) -> str:
    """Return a description of the scene, and the header of the table of steps.

    Parameters
    ----------
    reference : Reference
        Theory for the scene.

    Returns
    -------
    str
    """
    scene, smooth = reference.scene, reference.smooth
    lines = [description(reference)]
    if not scene.path.columns:
        ratio = f"A/A_{smooth.symbol}"
        lines += [
            f"{ratio}: contact area relative to theory, {smooth.sphere}{_bare(scene)}",
            *_without_rim(scene),
        ]
    heads = (f"   {head}" for head, _, _ in _columns(reference))
    return "\n".join([*lines, "", f"    step{''.join(heads)}"])


def table_row(
    reference: Reference,
    step: LoadStep,
    progress: Progress | None = None,
    restored: bool = False,
) -> str:
    """Return the row of a step in the table of steps.

    Parameters
    ----------
    reference : Reference
        Theory for the scene.
    step : LoadStep
    progress : Progress, optional
        Of the run. The time left is printed if it is at least a second, and the run has
        taken two: before, most of the time was that of its start.
    restored : bool
        Whether the step is that of an earlier run.

    Returns
    -------
    str
        It begins with the number of the step and, if it is known, of the last one.
    """
    scene, row = reference.scene, f"{step.step:4d}"
    count = scene.path.count(scene)
    if count is not None:
        row += f"/{count - 1}"
    row = f"{row:8}"
    for head, value_of, form in _columns(reference):
        value, width = value_of(step), len(head) + 3
        if restored and head == heading("seconds"):
            row += cell("restored", width)
        else:
            row += cell("-", width) if math.isnan(value) else cell(value, width, form)
    if progress and progress.elapsed > _START and progress.left >= 1.0:
        row += f"   about {duration(progress.left)} left"
    return row + limits(step) + _failure(scene, step)


def _columns(reference: Reference) -> list[tuple[str, Callable, str]]:
    """Return headings, values and formats of the table of steps."""
    path, area = reference.scene.path, reference.scene.area_column

    def printed(name: str, form: str, label: str = "") -> tuple[str, Callable, str]:
        return heading(name, label), lambda step: _printed(step, name), form

    def percent(name: str, error: str, value: str) -> tuple[str, Callable, str]:
        def part(step: LoadStep) -> float:
            return _ratio(100.0 * getattr(step, error), abs(getattr(step, value)))

        return f"{name} error (%)", part, ".2g"

    def ratio(name: str, area_of: Callable) -> tuple[str, Callable, str]:
        def part(step: LoadStep) -> float:
            smooth = float(reference.smooth.contact_area(step.normal_force))
            touches = step.repulsive_atoms > 0
            return _ratio(float(area_of(step)), smooth) if touches else math.nan

        return f"{name:>9}", part, ".4f"

    if path.columns:
        return [
            printed(name, ".2g" if name.endswith("error") else ".5g", label)
            for name, label in path.columns.items()
        ]
    columns = [printed("normal_force", ".4g")]
    if path.control == "load":
        columns.append(printed("height_error", ".2g", "height error"))
    else:
        columns.insert(0, printed(path.control, ".4f"))
        columns.append(percent("load", "force_error", "normal_force"))
    columns += [printed(area, ".4g"), percent("area", "area_error", area)]
    columns.append(ratio(f"A/A_{reference.smooth.symbol}", attrgetter(area)))
    if reference.rough_above is not None:
        columns.append(ratio("Eq. (4)", lambda s: reference.rough_area(s.normal_force)))
    return [*columns, printed("seconds", ".2f")]


def target_unit(scene: Scene) -> str:
    """Return ASE's unit of the targets of a scene's path."""
    control = scene.path.control
    return columns_of()["normal_force" if control == "load" else control].unit


def limits(step: LoadStep) -> str:
    """Return the end of a row: names of the limits of the model that a step exceeds.

    Those that all steps of a path exceed are listed below the table only.
    """
    checks = failed_checks(step.validity).values()
    names = [check.name for check in checks if not check.constant]
    return f"   LIMITS: {', '.join(names)}" if names else ""


def solver_line(step: LoadStep) -> str:
    """Return a line on the work of the solver in a step.

    Parameters
    ----------
    step : LoadStep

    Returns
    -------
    str
    """
    return (
        f"          {step.iterations} iterations, {step.pairs:.0f} FFT pairs; window "
        f"{step.window}, grid {step.grid}, {_printed(step, 'memory'):.2g} GB; largest "
        f"force {step.max_force:.2g} eV/Å, tolerance {step.tolerance:.2g} eV/Å; error "
        f"of the height {step.height_error:.2g} Å"
    )


def summary(
    reference: Reference,
    steps: Sequence[LoadStep],
    folder: Path,
    pictures: Sequence[str],
) -> str:
    """Return characteristic values of a path, and the files of its results.

    Parameters
    ----------
    reference : Reference
        Theory for the scene.
    steps : sequence of LoadStep
    folder : path
    pictures : sequence of str
        Names of the files of figures.

    Returns
    -------
    str
    """
    scene = reference.scene
    values: tuple[str, ...] = (scene.path.summary(scene, steps),)
    if not any(values):
        values = (
            _first_contact(scene, steps),
            _largest_tension(reference, steps),
            _errors(scene, steps),
        )
    lines = ["", *filter(None, values), *exceeded_limits(steps)]
    return "\n".join([*lines, file_list(folder, pictures)])


def file_list(folder: Path, pictures: Sequence[str]) -> str:
    """Return the list of the files of a run.

    Parameters
    ----------
    folder : path
    pictures : sequence of str
        Names of the files of figures.

    Returns
    -------
    str
    """
    lines = [f"Results are in {folder}:"]
    lines += [f"  {folder / name}" for name in pictures]
    if not pictures:
        lines.append("  (no figures, as nothing touched)")
    lines += [
        f"  {folder / 'curve.csv'}",
        f"  {folder / 'sweep.traj'}, all atoms",
        f"  {folder / 'view.traj'}, for viewing:",
        f"    ase gui -R=-60x {folder / 'view.traj'}",
        "  (purple: in contact, light blue: attracted; heights are enlarged)",
    ]
    return "\n".join(lines)


def _bare(scene: Scene) -> str:
    """Return on what half space theory is, for a layer."""
    if not isinstance(scene.solid, Layer):
        return ""
    if scene.solid.base_modulus is None:
        return ", on the material of the layer"
    return ", on the base without a layer"


def _without_rim(scene: Scene) -> list[str]:
    """Return a line on what the area is under a soft wall with attraction."""
    if scene.wall.hard or not scene.wall.attractive:
        return []
    return [
        "Areas are those of the atoms under pressure; that of theory includes the rim "
        "under tension, and is larger."
    ]


def _first_contact(scene: Scene, steps: Sequence[LoadStep]) -> str:
    if scene.path.control != "height" or not steps:
        return ""
    height = steps[0].height + steps[0].penetration
    return f"The sphere touches the flat surface at a height of {height:.4g} Å."


def _errors(scene: Scene, steps: Sequence[LoadStep]) -> str:
    """Return a line on the estimated errors of the areas of a coarse grid."""
    parts = [
        step.area_error / getattr(step, scene.area_column)
        for step in steps
        if getattr(step, scene.area_column)
    ]
    parts = [part for part in parts if math.isfinite(part)]  # the others are not known
    if not parts or max(parts) < _SHOWN_ERROR:
        return ""
    ends = dict.fromkeys(f"{100.0 * part:.2g}" for part in (min(parts), max(parts)))
    return (
        f"Estimated errors of the areas: {' to '.join(ends)} %; nine of ten are below "
        "twice that."
    )


def _largest_tension(reference: Reference, steps: Sequence[LoadStep]) -> str:
    """Return a line on the largest tension of the converged steps, if there is one."""
    force = min((s.normal_force for s in steps if s.converged), default=0.0)
    if force >= 0.0:
        return ""
    line = f"Largest tension of the path: {-force / UNITS['nN']:.4g} nN"
    if reference.smooth.pull_off_force > 0.0:
        line += f"; pull-off force: {pull_off_text(reference)}"
    return f"{line}."


def exceeded_limits(steps: Sequence[LoadStep]) -> list[str]:
    """Return a line for each limit of the model that a step exceeds.

    Parameters
    ----------
    steps : sequence of LoadStep

    Returns
    -------
    list of str
        With a heading; empty if all limits are kept.
    """
    counts = Counter(
        check for step in steps for check in failed_checks(step.validity).values()
    )
    lines = [
        f"  {check.name} {check.sign} {check.limit:g} in {count} of {len(steps)} "
        f"steps: {check.reason}"
        for check, count in counts.items()
    ]
    return ["Outside of the validity of the model:", *lines] if lines else []


def heading(column: str, label: str = "") -> str:
    """Return the heading of a column, with the unit in which it is printed."""
    entry = columns_of(TimeStep)[column]
    return f"{label or entry.label} ({printed_unit(entry.unit)})"


def _printed(step: LoadStep, column: str) -> float:
    """Return the value of a column in the unit in which it is printed."""
    return (
        getattr(step, column) / UNITS[printed_unit(columns_of(TimeStep)[column].unit)]
    )


def _failure(scene: Scene, step: LoadStep) -> str:
    """Return why a step is no result; empty if it is one."""
    if step.converged:
        return ""
    touches = step.repulsive_atoms or step.attractive_atoms
    if scene.path.control == "load" and not touches:
        target = float(scene.targets[step.step])
        if target < 0.0:
            return f"   PULLED OFF: no contact at {target / UNITS['nN']:.4g} nN"
    unit = " (forces in eV/Å)" if "force" in step.message else ""
    return f"   NOT CONVERGED: {step.message}{unit}"


def _ratio(value: float, reference: float) -> float:
    """Return a ratio, NaN if it is undefined."""
    defined = math.isfinite(value) and reference > 0.0
    return value / reference if defined else math.nan
