"""The results of a run as printed text: a row for each step, and characteristic values.

The same values and warnings are on its HTML page.
"""

from __future__ import annotations

import math
import time
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ase_roughcontact import theory as theory_of
from ase_roughcontact._util.printing import entries, note, number
from ase_roughcontact._util.rounding import ROUNDING
from ase_roughcontact._util.tables import TableRows
from ase_roughcontact._util.units import UNITS, with_unit
from ase_roughcontact.cli.description import bodies, pull_off_text, theory
from ase_roughcontact.contact.control import HEIGHT, LOAD
from ase_roughcontact.results.limits import failed_checks
from ase_roughcontact.results.record import LoadStep, columns_of, missing_values
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.printed import units_in_print
from ase_roughcontact.scene.reference import Reference

# Error of an area from which a line below the table reports it.
_MIN_REPORTED_ERROR = 0.001
# Columns of the errors.
_ERROR_COLUMNS = "area_error", "force_error", "height_error", "penetration_error"
# Width of the columns of the table of steps.
_COLUMN_WIDTH = 7
# Entry for the time of a step of an earlier run.
_RESTORED = "restored"
# Value in printed units below which it is zero.
_MIN_PRINTED_VALUE = 1e-12
# Share of the largest friction below which a lateral force is a rounding error.
_MIN_FRICTION_SHARE = 1e-9
# Time after which the next step of a path in time has a row (s).
_MAX_PAUSE = 10.0
# Labels of columns in the table of steps, where they differ from the labels in files.
_TABLE_LABELS = {"largest_pressure": "p max"}
# Reason for a ratio to theory that is not known.
_NO_RATIO = "without a contact under compression there is no ratio"
# Reason for an area by theory that is not known.
_NO_THEORY = "theory has no area for this force"


class TableColumn(NamedTuple):
    """Column of the table of steps.

    Attributes
    ----------
    head : str
        Heading with the unit.
    text_of : callable
        Function that returns the text for a step, "-" if the value is not known.
    reason_of : callable
        Function that returns why the value is not known.
    name : str
        Name of the column of the results; empty for other values.
    """

    head: str
    text_of: Callable[[Any], str]
    reason_of: Callable[[Any], str]
    name: str = ""


class StepTable:
    """Table of the steps of a run, printed row by row.

    Parameters
    ----------
    reference : Reference
        Theory for the scene.
    verbose : bool
        Whether solver, grid and errors of a step are printed below its row.
    """

    def __init__(self, reference: Reference, verbose: bool = False) -> None:
        self._scene, self._verbose = reference.scene, verbose
        self._columns = table_columns(reference)
        count = self._scene.path.count(self._scene.bodies)
        self._total = "" if count is None else f"/{count - 1}"
        # the time of a step that an earlier run has taken is not known
        self._unknown = None if self._scene.path.columns else "time (s)"
        heads, widths = ["step"], [max(2 * len(self._total) - 1, 4)]
        for each in self._columns:
            heads.append(each.head)
            is_unknown = each.head == self._unknown
            widths.append(len(_RESTORED) if is_unknown else _COLUMN_WIDTH)
        self._rows = TableRows([*heads, ""], [*widths, 1])
        self._reached = 0  # times of rows up to the last step
        self._last = time.monotonic()
        schedule = self._scene.path.schedule(self._scene.bodies)
        self._times = schedule.sample_times() if schedule else np.zeros(0)
        self._limits: set[str] = set()

    def parts(self, step: LoadStep, restored: bool = False) -> list[Any]:
        """Return the row of a step and notes on it, headings before the first one.

        Limits of the model that the step exceeds are marked by a star, and named where
        they are first exceeded; limits that all steps of a path exceed are not. Some
        steps of a path in time have no row, unless a limit is new, the step has not
        converged, or 10 s have passed.

        Parameters
        ----------
        step : LoadStep
        restored : bool
            Whether the step was calculated by an earlier run.
        """
        row = [f"{step.step}{self._total}"]
        for each in self._columns:
            is_unknown = restored and each.head == self._unknown
            row.append(_RESTORED if is_unknown else each.text_of(step))
        checks = failed_checks(step.validity).values()
        names = [check.name for check in checks if not check.constant]
        row.append("*" if names else "")
        found: list[Any] = []
        new = [name for name in names if name not in self._limits]
        self._limits.update(new)
        if not (self._is_due(step) or new or self._verbose) and step.converged:
            return []
        found.append(self._rows.row(row))
        self._last = time.monotonic()
        if new:
            found.append(note(f"* LIMITS: {', '.join(new)}", 10, "yellow"))
        if not step.converged:
            found.append(note(_failure(self._scene, step), 10, "bold red"))
        if self._verbose:
            found.append(note(_solver(self._scene, step), 10, "dim"))
        return found

    def _is_due(self, step: Any) -> bool:
        """Return whether the step reaches the next time that has a row."""
        if not self._times.size:
            return True
        now = step.time * (1.0 + ROUNDING)
        before = self._reached
        self._reached = int(np.searchsorted(self._times, now, side="right"))
        is_due = self._reached > before
        return is_due or time.monotonic() - self._last > _MAX_PAUSE


def table_columns(reference: Reference) -> list[TableColumn]:
    """Return the columns of the table of steps."""
    scene, units = reference.scene, units_in_print(reference.scene)
    path, area = scene.path, scene.area_column

    def column(name: str, label: str = "", digits: int = 4) -> TableColumn:
        digits, unit = 2 if name.endswith("error") else digits, units[name]

        def text_of(step: LoadStep) -> str:
            if name == "seconds":
                return f"{step.seconds:.2f}"
            return number(_printed(step, name, unit), digits)

        def reason_of(step: LoadStep) -> str:
            return step.not_known.get(name, "")

        head = heading(scene, name, label or _TABLE_LABELS.get(name, ""))
        return TableColumn(head, text_of, reason_of, name)

    def relative(step: LoadStep) -> str:
        smooth = float(reference.smooth.contact_area(step.normal_force))
        touches = step.repulsive_atoms > 0
        return _ratio(getattr(step, area) if touches else math.nan, smooth)

    def expected(step: LoadStep) -> str:
        return number(float(reference.relative_area(max(step.normal_force, 0.0))))

    if scene.is_flat and not path.columns:
        return _with_asked(scene, _flat_columns(scene, column), column)
    if path.columns:
        found = [
            column(area if name == "contact_area" else name, label)
            for name, label in path.columns.items()
            if name in units
        ]
        return _with_asked(scene, found, column)
    names = ["normal_force", "penetration"]
    if scene.control != LOAD:
        names = [scene.control.column, "normal_force"]
    found = [*map(column, names), column(area)]
    head = f"A/A_{reference.smooth.symbol}"
    found.append(TableColumn(head, relative, lambda step: _NO_RATIO))
    if reference.rough_above is not None:
        found.append(TableColumn("theory", expected, lambda step: _NO_THEORY))
    found += [column("largest_pressure"), column("seconds")]
    return _with_asked(scene, found, column)


def _with_asked(
    scene: Scene, usual: list[TableColumn], column: Callable[[str], TableColumn]
) -> list[TableColumn]:
    """Return columns with the numbers that a scene asks for, before the time."""
    shown = [each.name for each in usual]
    missing = missing_values(scene.record)
    asked = [
        name
        for name in scene.output.columns or ()
        if name not in shown and missing[name] != ""
    ]
    end = shown.index("seconds") if "seconds" in shown else len(shown)
    return [*usual[:end], *map(column, asked), *usual[end:]]


def _flat_columns(
    scene: Scene, column: Callable[..., TableColumn]
) -> list[TableColumn]:
    """Return the columns of the table for a rough flat."""
    scale, area = scene.rough.rms_slope * scene.contact_modulus, scene.area_column
    persson = theory_of.mean_contact_pressure(scale, 1.0, theory_of.KAPPA_PERSSON)

    def expected(step: Any) -> str:
        nominal = max(step.nominal_pressure, 0.0)
        return number(float(theory_of.contact_fraction(nominal, float(persson))), 3)

    def derived(head: str, text_of: Callable[[Any], str]) -> TableColumn:
        return TableColumn(head, text_of, lambda step: _NO_RATIO)

    nominal = scene.bodies.nominal_area
    found = [
        column("nominal_pressure", "p"),
        column("mean_gap", "gap", 3),
        derived("A/A_0", lambda s: _ratio(getattr(s, area), nominal, 3)),
        derived("Persson", expected),
        derived("kappa", lambda s: _ratio(getattr(s, area) * scale, s.normal_force)),
        column("contact_stiffness", "k", 3),
    ]
    if "conductance" in columns_of(scene.record):
        found.append(column("conductance", "C", 3))
    return [*found, column("seconds")]


def target_unit(scene: Scene) -> str:
    """Return ASE's unit of the targets of a scene's path, or of its times."""
    if scene.path.schedule(scene.bodies) is not None:
        return "s"
    return columns_of()[scene.control.column].unit


def heading(scene: Scene, column: str, label: str = "") -> str:
    """Return the heading of a column, with the unit in which it is printed."""
    label = label or columns_of(scene.record)[column].label or column.replace("_", " ")
    unit = units_in_print(scene)[column]
    return f"{label} ({unit})" if unit else label


def inputs(reference: Reference) -> dict[str, str]:
    """Return descriptions of the scene and of the theory for it."""
    return bodies(reference.scene) | theory(reference)


def results(reference: Reference, steps: Sequence[LoadStep]) -> dict[str, str]:
    """Return characteristic values of a path by their names."""
    scene = reference.scene
    found = dict(scene.path.summary(scene.bodies, steps))
    if steps and not found:
        found = _results_of_steps(reference, steps)
    found |= _counted(scene, steps)
    return found | unknown_counted({"errors": map(_unknown_errors, steps)}, len(steps))


def unknown_counted(reasons: Mapping[str, Iterable[str]], total: int) -> dict[str, str]:
    """Return in how many steps values are not known, and why, by their names.

    Parameters
    ----------
    reasons : mapping of str to iterable of str
        Reason for each step, by name of the value; empty where the value is known.
    total : int
        Number of steps.
    """
    found = {}
    for name, each in reasons.items():
        counts = Counter(filter(None, each))
        if counts:
            found[f"{name} not known"] = "; ".join(
                f"in {count} of {total} steps: {reason}"
                for reason, count in counts.items()
            )
    return found


def _unknown_errors(step: LoadStep) -> str:
    """Return why errors of a step are not known; empty if all are known."""
    unknown = step.not_known
    return next((unknown[name] for name in _ERROR_COLUMNS if name in unknown), "")


def _unknown_in_table(
    reference: Reference, steps: Sequence[LoadStep]
) -> dict[str, str]:
    """Return why values in the table of steps are not known."""
    reasons = dict[str, list[str]]()
    for column in table_columns(reference):
        unknown = [step for step in steps if column.text_of(step) == "-"]
        name = column.head.partition(" (")[0]
        reasons[name] = [column.reason_of(step) for step in unknown]
    return unknown_counted(reasons, len(steps))


def _results_of_steps(
    reference: Reference, steps: Sequence[LoadStep]
) -> dict[str, str]:
    """Return characteristic values of a path of steps."""
    scene, found = reference.scene, dict[str, str]()
    if scene.control == HEIGHT:
        height = steps[0].height + steps[0].penetration
        found["first contact"] = f"at a height of {height:.4g} Å"
    force = min((step.normal_force for step in steps if step.converged), default=0.0)
    if force < 0.0:
        found["largest tension"] = with_unit(-force, "nN")
        if reference.smooth.pull_off_force:
            found["largest tension"] += f"; pull-off force: {pull_off_text(reference)}"
    area = scene.area_column
    parts = [s.area_error / getattr(s, area) for s in steps if getattr(s, area)]
    parts = [part for part in parts if math.isfinite(part)]
    if parts and max(parts) >= _MIN_REPORTED_ERROR:
        ends = dict.fromkeys(f"{100.0 * part:.2g}" for part in (min(parts), max(parts)))
        found["errors of areas"] = (
            f"{' to '.join(ends)} %, estimated; nine of ten are below twice this"
        )
    return found


def _counted(scene: Scene, steps: Sequence[LoadStep]) -> dict[str, str]:
    """Return that areas are counted, and the last area beside the continuum's."""
    touching = [step for step in steps if step.repulsive_atoms]
    if scene.is_continuum or not touching:
        return {}
    last, unit = touching[-1], units_in_print(scene)["contact_area"]
    counted = number(last.contact_area / UNITS[unit])
    area = number(last.continuum_area / UNITS[unit])
    error = last.continuum_area_error / UNITS[unit]
    continuum = f"{area} {unit}, error not known"
    if math.isfinite(error):
        continuum = f"{area} ± {number(error, 2)} {unit}"
    return {
        "counted areas": f"number of atoms times the area of each, {counted} {unit} "
        f"in step {last.step}; continuum: {continuum}"
    }


def exceeded_limits(steps: Sequence[LoadStep]) -> dict[str, str]:
    """Return the limits of the model that steps exceed, and why they are limits."""
    counts = Counter(
        check for step in steps for check in failed_checks(step.validity).values()
    )
    return {
        check.condition: f"in {count} of {len(steps)} steps: {check.reason}"
        for check, count in counts.items()
    }


def summary(reference: Reference, steps: Sequence[LoadStep]) -> list[Any]:
    """Return characteristic values of a path, and the limits that it exceeds."""
    parts: list[Any] = []
    values, limits = results(reference, steps), exceeded_limits(steps)
    values |= _unknown_in_table(reference, steps)
    if values:
        parts += ["", entries(values.items())]
    scene = reference.scene
    for warning in scene.path.warnings(scene.bodies, steps) if steps else ():
        parts += ["", note(f"warning: {warning}", style="yellow")]
    if limits:
        title = note("Outside of the validity of the model:", style="yellow")
        parts += ["", title, entries(limits.items())]
    return [*parts, ""]


def reason_without_maps(steps: Sequence[LoadStep], has_maps: bool) -> str:
    """Return why contact.png is left out of the figures of a run; empty if it is not.

    Parameters
    ----------
    steps : sequence of LoadStep
        All steps.
    has_maps : bool
        Whether there is a contact.png.
    """
    if has_maps:
        return ""
    if not any(step.repulsive_atoms for step in steps):
        return "as nothing touched"
    return (
        'as no step with a frame is in contact: run with keep = "all" in a new folder'
    )


def files_table(pictures: Sequence[str], steps: Sequence[LoadStep]) -> Any:
    """Return the table of the files of a run, with the names of its figures."""
    view = (
        "for viewing, with heights enlarged; purple: in contact, light blue: attracted"
    )
    if "friction.png" in pictures:
        view += ", green: slips"
    files = {
        "curve.csv": "all columns of the table",
        "sweep.traj": "frames for looking",
        "sweep.restart.npz": "all steps, from which a run is resumed",
        "view.traj": view,
        **dict.fromkeys(pictures, "figure"),
        "scene.toml": "the scene",
    }
    if "cantilever.png" in pictures:
        files["cantilever.csv"] = "force curve of the cantilever"
    if reason := reason_without_maps(steps, "contact.png" in pictures):
        files["no contact.png,"] = reason
    return entries(files.items())


def _solver(scene: Scene, step: LoadStep) -> str:
    """Return the work of the solver in a step, and the errors of its results."""
    errors = {
        "area": _ratio(step.area_error, getattr(step, scene.area_column), 2),
        "load": _ratio(step.force_error, abs(step.normal_force), 2),
        "height": f"{number(step.height_error, 2)} Å",
    }
    memory = number(step.memory / UNITS["GB"], 2)
    text = (
        f"{step.iterations} iterations, {step.pairs:.0f} FFT pairs; window "
        f"{step.window}, grid {step.grid}, {memory} GB; largest "
        f"force {step.max_force:.2g} eV/Å, tolerance {step.tolerance:.2g} eV/Å; errors "
        "(area and load are relative): "
    )
    text += ", ".join(f"{name} {error}" for name, error in errors.items())
    reason = _unknown_errors(step)
    if reason:
        text += f"; -: not known, {reason}"
    return text


def _failure(scene: Scene, step: LoadStep) -> str:
    """Return why a step failed."""
    touches = step.repulsive_atoms or step.attractive_atoms
    if scene.control == LOAD and not touches:
        target = scene.path.target_of(scene.bodies, step)
        if target < 0.0:
            return f"PULLED OFF: no contact at {with_unit(target, 'nN')}"
    return f"NOT CONVERGED: {step.message}"


def _printed(step: Any, column: str, unit: str) -> float:
    """Return the value of a column in the unit in which it is printed."""
    value: float = getattr(step, column) / UNITS[unit]
    least = _MIN_PRINTED_VALUE
    if column.startswith("lateral_force"):
        largest: float = step.largest_friction
        least = max(least, _MIN_FRICTION_SHARE * largest / UNITS[unit])
    return 0.0 if abs(value) < least else value


def _ratio(value: float, reference: float, digits: int = 4) -> str:
    """Return a ratio as text, "-" if it is undefined."""
    return number(value / reference if reference > 0.0 else math.nan, digits)
