"""Studies: means of a column over a parameter, with errors and scatter, and theory."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ase_roughcontact._util.files import PathName, write_table
from ase_roughcontact._util.units import QUANTITY, UNITS
from ase_roughcontact._util.validation import lookup
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.ensemble.cases import combinations, product
from ase_roughcontact.ensemble.means import MeanValue, mean_values
from ase_roughcontact.results.record import columns_of
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import Reference, reference_for

#: Key of the seeds, over which a study averages; of two bodies it is the seed of both.
SEED = "roughness.seed"
# Sections with keys that are understood without the name of the section.
_PLAIN_SECTIONS = "roughness", "substrate", "interaction", "path"
# Columns of areas, for which there is a theory.
_AREAS = "contact_area", "continuum_area"


@dataclass(frozen=True)
class StudyPoint:
    """Mean of a column for some values of the parameters.

    Attributes
    ----------
    values : mapping
        Values of the parameters by key, as in a scene file.
    mean : MeanValue
        Mean over the realisations.
    unit : str
        ASE's unit of the mean and its scatter.
    theory : float
        Value by theory, NaN without one.
    theory_name : str
        Name of the theory; empty without one.
    """

    values: Mapping[str, Any]
    mean: MeanValue
    unit: str
    theory: float
    theory_name: str


def study_points(
    scene: Scene,
    parameters: Mapping[str, Iterable[Any]],
    database: PathName,
    column: str | None = None,
    together: Sequence[str] = (),
) -> list[StudyPoint]:
    """Return means of a column for all combinations of values of some parameters.

    Parameters
    ----------
    scene : Scene
        Scene with the values of all other keys.
    parameters : mapping
        Values by key; see `product`. Means are over the values of ``roughness.seed``,
        ``tip.roughness.seed`` and ``substrate.roughness.seed``.
    database : path
        Database of `run_ensemble`.
    column : str, optional
        See `mean_values`.
    together : sequence of str
        Keys that vary together; see `product`.

    Returns
    -------
    list of StudyPoint
        The last parameter varies fastest; several targets of a path are one after the
        other.

    Raises
    ------
    ValueError
        If there is no such column, key or value.
    """
    choices = {key: list(values) for key, values in parameters.items()}
    seeds = {key: choices.pop(key) for key in list(choices) if is_seed(key)}
    points = []
    for values in combinations(choices, together):
        variant = scene.with_values(values)
        realisations = product(variant, seeds)
        reference = reference_for(realisations[0])
        for mean in mean_values(realisations, database, column):
            theory, name = _theory(reference, mean)
            unit = unit_of(variant, mean.column)
            points.append(StudyPoint(values, mean, unit, theory, name))
    return points


def is_seed(key: str) -> bool:
    """Return whether a key is the seed of the roughness or scan of a body."""
    return key.endswith(("roughness.seed", "topography.seed"))


def unit_of(scene: Scene, column: str) -> str:
    """Return ASE's unit of a result of the path, or of a column of its steps."""
    if column in scene.path.results:
        return scene.path.results[column].unit
    return columns_of(scene.record)[column].unit


def numeric_values(key: str, values: Sequence[Any]) -> tuple[list[float], str]:
    """Return the values of a parameter as numbers in one unit, and the unit.

    Parameters
    ----------
    key : str
        Name for errors.
    values : sequence
        Numbers, or strings of a number and a unit.

    Raises
    ------
    ValueError
        If a value is not a finite number, or some have units and others not.
    """
    texts = [each for each in values if isinstance(each, str)]
    found = [each for each in map(QUANTITY.fullmatch, texts) if each]
    units = {each[2] for each in found}
    if found and len(found) == len(values) and (len(units) == 1 or units <= {*UNITS}):
        unit = found[0][2]
        scales = {each: UNITS[each] / UNITS[unit] for each in units - {unit}}
        return [float(each[1]) * scales.get(each[2], 1.0) for each in found], unit
    if not all(_is_finite(each) for each in values):
        raise ValueError(
            f"{key} must have finite numbers, all with a unit or none, for a figure, "
            f"got {', '.join(map(str, values))}"
        )
    return [float(each) for each in values], ""


def _is_finite(value: Any) -> bool:
    """Return whether a value is a finite number."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return is_number and math.isfinite(value)


def parameter_label(key: str) -> str:
    """Return the words for a parameter: "rms height" for ``roughness.rms_height``."""
    title, _, name = key.rpartition(".")
    words = name.replace("_", " ")
    return words if title in _PLAIN_SECTIONS else f"{title} {words}".strip()


def drawn_over(parameters: Mapping[str, Sequence[Any]], over: str = "") -> str:
    """Return the parameter of the axis: the given one, or the first with two numbers.

    Parameters
    ----------
    parameters : mapping
        Values by key.
    over : str
        Given key; empty if none is given.

    Returns
    -------
    str
        The key; empty if no parameter has several numbers.

    Raises
    ------
    ValueError
        If the given key is not a parameter, is the seed, or has values that are not
        numbers.
    """
    if is_seed(over):
        raise ValueError(
            f"means are over the values of {over}: give another parameter for the "
            "figure, or omit it"
        )
    if over:
        numeric_values(over, lookup(over, parameters, "parameter of the study"))
        return over
    for key, values in parameters.items():
        if is_seed(key) or len(values) < 2:
            continue
        try:
            numeric_values(key, values)
        except ValueError:
            continue
        return key
    return ""


def write_study(file: PathName, points: Sequence[StudyPoint]) -> None:
    """Write means of a study as CSV: a row for each column and combination of values.

    Parameters
    ----------
    file : path
        File to write; an existing file is overwritten.
    points : sequence of StudyPoint
        Points of one or more columns with the same parameters. Numbers are in ASE's
        units, which a column names, the errors, too.
    """
    keys = list(dict.fromkeys(key for point in points for key in point.values))
    heads = ["column", "unit", *keys, "target", "mean", "standard_error", "scatter"]
    heads += ["realisations", "failed", "value_error", "theory", "validity"]
    heads.append("lower_bounds")
    rows = []
    for point in points:
        mean = point.mean
        size = abs(mean.mean)
        numbers = mean.target, mean.mean, size * mean.error, mean.scatter
        rows.append(
            [
                mean.column,
                point.unit,
                *(point.values.get(key, "") for key in keys),
                *(f"{number:.10g}" for number in numbers),
                mean.realisations,
                mean.failed,
                f"{size * mean.value_error:.10g}",
                f"{point.theory:.10g}",
                mean.validity,
                mean.lower_bounds,
            ]
        )
    write_table(file, heads, rows)


def _theory(reference: Reference, mean: MeanValue) -> tuple[float, str]:
    """Return the value by theory and its name; NaN without one."""
    scene, smooth = reference.scene, reference.smooth
    shape = scene.bodies.shape
    indenter = f"smooth {'sphere' if shape is None else shape.name}"
    result = scene.path.results.get(mean.column)
    if result is not None and result.theory is not None and not scene.is_flat:
        # the work of adhesion of the reference may be reduced by roughness
        adhesion = scene.wall.work_of_adhesion
        smooth = scene.bodies.smooth_theory(scene.contact_modulus, adhesion)
        return float(result.theory(smooth)), f"{smooth.name}, {indenter}"
    name = f"{smooth.name}, {indenter}"
    in_time = scene.path.schedule(scene.bodies) is not None  # targets are times
    with_load = scene.path.controlled == LOAD and mean.target > 0.0 and not in_time
    if result is None and mean.column in _AREAS and with_load and not scene.is_flat:
        area = float(smooth.contact_area(mean.target))
        ratio = float(reference.relative_area(mean.target))
        if scene.rough is None or math.isnan(ratio):
            return area, name
        return area * ratio, "theory of rough spheres"
    return math.nan, ""
