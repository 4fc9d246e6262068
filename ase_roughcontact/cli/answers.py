"""The main result of a run in one sentence, with its error."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ase_roughcontact._util.printing import number
from ase_roughcontact._util.units import UNITS, printed_unit, with_unit
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.ensemble.places import PLACE_UNITS, Place, result_units
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.path_result import lower_bounds_of, results_of
from ase_roughcontact.scene.printed import units_in_print
from ase_roughcontact.scene.reference import Reference

# Number of results of a path in its sentence.
_RESULTS = 2
# Probabilities of the quartiles.
_QUARTILES = 0.25, 0.5, 0.75


def answer(reference: Reference, steps: Sequence[LoadStep]) -> str:
    """Return what a run was made for: results of its path, or its largest contact.

    Parameters
    ----------
    reference : Reference
        Theory for the scene.
    steps : sequence of LoadStep

    Returns
    -------
    str
        A sentence for people, with errors as far as they are estimated.
    """
    converged = [step for step in steps if step.converged]
    if not converged:
        return "There is no result, as no step has converged."
    if reference.scene.path.results and len(converged) == len(steps):
        return _of_path(reference, steps)
    return _of_step(reference, max(converged, key=lambda step: step.normal_force))


def answer_of_places(scene: Scene, places: Sequence[Place]) -> str:
    """Return the median pull-off force of loops, or area, of places with a result.

    Parameters
    ----------
    scene : Scene
    places : sequence of Place
    """
    name = "pull_off_force" if scene.path.is_loop else "area"
    values = np.array([place.value(name) for place in places if place.converged])
    values = values[np.isfinite(values)]
    if not values.size:
        return f"There is no result in any of {len(places)} places."
    words = "pull-off force" if scene.path.is_loop else "contact area"
    unit = {**PLACE_UNITS, **result_units()}[name]
    text = median_in_words(words, np.quantile(values, _QUARTILES), unit, "places")
    missing = len(places) - len(values)
    return f"{text}; {missing} of {len(places)} places have no result."


def median_in_words(
    name: str, quartiles: Sequence[float] | np.ndarray, unit: str, rows: str
) -> str:
    """Return the median of a quantity with its quartiles, without a full stop.

    Parameters
    ----------
    name : str
        Words for the quantity.
    quartiles : sequence of float, shape (3,)
        Lower quartile, median and upper quartile in ASE's units.
    unit : str
        Unit in print.
    rows : str
        What has a value each: "places".
    """
    low, middle, high = (number(float(value) / UNITS[unit]) for value in quartiles)
    return (
        f"The median {name} is {middle} {unit}, half of the {rows} are between {low} "
        f"and {high} {unit}"
    )


def _of_path(reference: Reference, steps: Sequence[LoadStep]) -> str:
    """Return the first results that are defined, and theory for them."""
    scene, found = reference.scene, []
    path, bodies = scene.path, scene.bodies
    values = results_of(path, bodies, steps)
    bounds = lower_bounds_of(path, bodies, steps)
    errors = {result.error for result in path.results.values()}
    for name, result in path.results.items():
        if name in errors or not result.unit or math.isnan(values[name]):
            continue
        unit = printed_unit(result.unit, scene.contact_modulus)
        text = with_unit(values[name], unit)
        if error := values.get(result.error):
            digits, _, unit = text.rpartition(" ")
            text = f"{digits} ± {number(error / UNITS[unit], 2)} {unit}"
        words = "is at least" if name in bounds else "is"
        found.append(f"the {result.label or name.replace('_', ' ')} {words} {text}")
        if result.theory is not None and not scene.is_flat:
            theory = float(result.theory(reference.smooth))
            if theory:
                found[-1] += f" ({with_unit(theory, unit)} of a smooth sphere)"
        if len(found) == _RESULTS:
            break
    if not found:
        return _of_step(reference, max(steps, key=lambda step: step.normal_force))
    return _sentence(", and ".join(found))


def _of_step(reference: Reference, step: Any) -> str:
    """Return the area of a contact under its load, and the force if it follows."""
    scene = reference.scene
    column, units = scene.area_column, units_in_print(scene)
    if not step.repulsive_atoms:
        return "Nothing is pressed: no atom is in contact in any step."
    place = f"at {with_unit(step.normal_force, 'nN')}"
    parts = []
    if scene.is_flat:
        unit = units["nominal_pressure"]
        place = f"at a nominal pressure of {with_unit(step.nominal_pressure, unit)}"
    elif scene.control != LOAD:
        along = scene.path.along
        place = f"at a {along} of {with_unit(getattr(step, along), 'nm')}"
        force = _with_error(step, "normal_force", "force_error", units["normal_force"])
        parts.append(f"the normal force is {force}")
    area = _with_error(step, column, "area_error", units[column])
    parts.append(f"the contact area is {area}")
    smooth = reference.smooth
    smooth_area = float(smooth.contact_area(step.normal_force))
    if smooth_area > 0.0 and not scene.is_flat:
        ratio = getattr(step, column) / smooth_area
        parts[-1] += f", {ratio:.3f} times the area of a smooth sphere ({smooth.name})"
    if scene.is_flat:
        part = getattr(step, column) / scene.bodies.nominal_area
        parts[-1] += f", {100.0 * part:.3g} % of the nominal area"
    if scene.scan is not None and math.isfinite(step.area_error):
        parts[-1] += "; the error contains the pixels and the noise of the scan"
    return _sentence(f"{place} {', and '.join(parts)}")


def _with_error(step: LoadStep, column: str, error_column: str, unit: str) -> str:
    """Return a value with its error in a unit, or why the error is not known."""
    scale, error = UNITS[unit], getattr(step, error_column)
    value = number(getattr(step, column) / scale)
    if math.isnan(error):
        reason = step.not_known.get(error_column, "")
        return f"{value} {unit} (error not known: {reason})"
    if not error:
        return f"{value} {unit}"
    return f"{value} ± {number(error / scale, 2)} {unit}"


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}."
