"""Results of a run or of places as one HTML page."""

from __future__ import annotations

import base64
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from jinja2 import Environment

from ase_roughcontact._util.printing import number
from ase_roughcontact._util.rounding import ROUNDING
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import report
from ase_roughcontact.cli.answers import answer, answer_of_places
from ase_roughcontact.cli.page_data import as_json, data_of_places
from ase_roughcontact.ensemble.places import PLACE_UNITS, Place, result_units
from ase_roughcontact.results.record import LoadStep, columns_of
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.printed import units_in_print
from ase_roughcontact.scene.reference import Reference

if TYPE_CHECKING:
    from ase_roughcontact.cli.stress_figures import DepthPicture

# Columns of the table of steps, with the columns of their errors.
_ERROR_OF_COLUMN = {
    "step": "",
    "nominal_pressure": "",
    "mean_gap": "",
    "height": "height_error",
    "penetration": "penetration_error",
    "normal_force": "force_error",
    "contact_area": "area_error",
    "continuum_area": "area_error",
    "contact_stiffness": "",
    "conductance": "",
    "mean_pressure": "",
    "largest_pressure": "",
    "repulsive_atoms": "",
    "attractive_atoms": "",
    "plastic_atoms": "",
}
# Relative error below which it is left out, as it is below the last digit.
_MIN_RELATIVE_ERROR = 5e-5
# Number of steps that a warning lists.
_MAX_LISTED_STEPS = 10
# Captions of the figures.
_CAPTIONS = {
    "curve.png": "Contact area, and relative to a smooth sphere without adhesion "
    "(Hertz), beside theory.",
    "force.png": "Normal force along the path; negative forces are tensile.",
    "contact.png": "Pressure on the atoms in contact; circle: smooth sphere under the "
    "same load, around its axis; of a scanned tip around the centre of the load.",
    "stress.png": "Stress below the contact under the largest load: (a) von Mises "
    "stress on a vertical plane through its largest value (cross), with the pressure "
    "above; the first spacing below the surface is left out; (b) at the depth of the "
    "largest value; solid: outline of the contact, dashed: yield strength, dotted: "
    "where the other panel is; (c) on the vertical line through the cross.",
}
# Caption of the pictures of the stress at some depths.
_DEPTHS_CAPTION = (
    "Von Mises stress at a depth, under the largest load, on one scale. Solid: outline "
    "of the contact; dashed: yield strength."
)
# Caption of the figure of places.
_PLACES_CAPTION = "The scan with the places of the tip, and maps of the results."
# Captions of the figures of rough flats.
_FLAT_CAPTIONS = {
    "curve.png": "Contact area relative to the nominal one, beside theory, mean gap, "
    "and contact stiffness and conductance, against the nominal pressure.",
    "contact.png": "Pressure on the points in contact.",
}
# Words in place of warnings.
_GOOD = "All {rows} converged within the limits of the model."
# Words above a table of results.
_EXPLAINED = (
    "± is the estimated error, as bars in the chart; bars in the figures are twice as "
    "long. Errors below the last digit are left out."
)


class PageTable(NamedTuple):
    """Table of a page.

    Attributes
    ----------
    heads : list of (str, str, str)
        Names of the columns, their units, and what they mean; may be empty texts.
    rows : list of (bool, list)
        Whether a row is no result, and its texts with their errors.
    notes : list of str
        Sentences below the table.
    """

    heads: list[tuple[str, str, str]]
    rows: list[tuple[bool, list[tuple[str, str]]]]
    notes: Sequence[str] = ()


def page(
    reference: Reference,
    steps: Sequence[LoadStep],
    folder: Path,
    pictures: Sequence[str] = (),
    stresses: Sequence[DepthPicture] = (),
    data: Mapping[str, Any] | None = None,
) -> str:
    """Return the page of a run.

    Parameters
    ----------
    reference : Reference
        Theory for the scene.
    steps : sequence of LoadStep
    folder : path
        Folder with ``scene.toml`` and the figures.
    pictures : sequence of str, optional
        Names of the figures that become part of the page.
    stresses : sequence of DepthPicture, optional
        Pictures of the stress at some depths, shown one at a time.
    data : mapping, optional
        Numbers for a chart and maps that react, see `data_of_run`.

    Returns
    -------
    str
        HTML, without references to other files.
    """
    scene = reference.scene
    record = columns_of(type(steps[0]) if steps else LoadStep)
    other_area = {"contact_area", "continuum_area"} - {scene.area_column}
    first, *others = _ERROR_OF_COLUMN
    own = [name for name in scene.path.columns if name not in {"seconds", *others}]
    shown = {}
    for name in (first, *own, *others):
        if name not in record or name in other_area:
            continue
        # quantities that are not defined for the wall have no column
        if record[name].where.constant and steps and _is_unknown(steps, name):
            continue
        shown[name] = record[name]
    unknown = {
        name.replace("_", " "): [step.not_known.get(name, "") for step in steps]
        for name in shown
    }
    units = units_in_print(scene)
    captions = dict(_CAPTIONS)
    if scene.is_flat:
        captions.update(_FLAT_CAPTIONS)
    captions.update(scene.path.captions)
    if scene.seed is not None and not scene.is_flat:
        captions["curve.png"] += (
            " Other realisations of the roughness scatter about it, most at light "
            "loads, which few asperities carry."
        )
    if scene.scan is not None:
        captions["contact.png"] += " The first line of the scan is at the top."
    warnings = _warnings(scene, steps)
    if reason := report.reason_without_maps(steps, "contact.png" in pictures):
        warnings.append(f"No contact.png, {reason}.")
    return rendered(
        **_of_folder(folder, captions, pictures),
        rows="steps",
        count=len(steps),
        good=_GOOD.format(rows="steps"),
        explained=_EXPLAINED,
        data=data,
        saved=[folder / "curve.csv", folder / "cantilever.csv"],
        answer=answer(reference, steps),
        warnings=warnings,
        inputs=report.inputs(reference),
        results={
            **report.results(reference, steps),
            **report.unknown_counted(unknown, len(steps)),
        },
        stresses=[(each, _encoded(each.png)) for each in stresses],
        stresses_caption=_DEPTHS_CAPTION,
        tables=[
            PageTable(
                [
                    (name.replace("_", " "), units[name], each.description)
                    for name, each in shown.items()
                ],
                [
                    (not step.converged, [_cell(step, k, units[k]) for k in shown])
                    for step in steps
                ],
            )
        ],
    )


def page_of_places(reference: Reference, places: Sequence[Place], folder: Path) -> str:
    """Return the page of a map of places on a scan.

    Parameters
    ----------
    reference : Reference
        Theory for the scene.
    places : sequence of Place
    folder : path
        Folder with ``scene.toml`` and ``places.png``, which becomes part of the page.

    Returns
    -------
    str
        HTML, without references to other files.
    """
    scene, total = reference.scene, len(places)
    limits = Counter(
        limit for place in places for limit in filter(None, place.validity.split("; "))
    )
    results, units = scene.path.results, result_units()
    shown = {name: results[name].description for name in results if name in units}
    attributes = {k: unit for k, unit in PLACE_UNITS.items() if k != "area_error"}
    heads = [(name.replace("_", " "), unit, "") for name, unit in attributes.items()]
    heads += [(k.replace("_", " "), units[k], text) for k, text in shown.items()]
    return rendered(
        **_of_folder(folder, {"places.png": _PLACES_CAPTION}, ["places.png"]),
        rows="places",
        count=total,
        good=_GOOD.format(rows="places"),
        explained=_EXPLAINED,
        data=data_of_places(scene, places) if places else None,
        saved=[folder / "places.csv"],
        answer=answer_of_places(scene, places),
        warnings=[
            *scene.warnings,
            *(f"{_position(each)}: {each.message}" for each in places if each.message),
            *(
                f"{limit}: in {count} of {total} places"
                for limit, count in limits.items()
            ),
        ],
        inputs=report.inputs(reference),
        results={},
        tables=[
            PageTable(
                heads,
                [
                    (
                        not place.converged,
                        [_place_cell(place, k, unit) for k, unit in attributes.items()]
                        + [_text(place.value(k) / UNITS[units[k]]) for k in shown],
                    )
                    for place in places
                ],
            )
        ],
    )


def _position(place: Place) -> str:
    nm = UNITS["nm"]
    return f"Place at ({place.x / nm:.4g}, {place.y / nm:.4g}) nm"


def _place_cell(place: Place, name: str, unit: str) -> tuple[str, str]:
    """Return an attribute of a place and its error as text."""
    text, _ = _text(place.value(name) / UNITS[unit])
    error = place.area_error / UNITS[unit] if name == "area" else 0.0
    if not math.isnan(place.area) and math.isnan(error):
        return text, "not known"
    return text, number(error, 2) if error > _MIN_RELATIVE_ERROR * place.area else ""


def _text(value: float) -> tuple[str, str]:
    """Return a number without an error as text."""
    if math.isnan(value):
        return "not known", ""
    return number(value).replace("-", "\N{MINUS SIGN}"), ""


def rendered(
    data: Mapping[str, Any] | None,
    saved: Iterable[Path],
    figures: Iterable[tuple[str, bytes, str]],
    **values: Any,
) -> str:
    """Return a page from the template ``report.html``.

    Parameters
    ----------
    data : mapping or None
        Numbers for the chart and the maps.
    saved : iterable of path
        Tables to save, as far as they exist.
    figures : iterable of (str, bytes, str)
        Names, pictures and captions.
    **values
        Further values of the template.
    """
    parts = files("ase_roughcontact.cli")
    environment = Environment(autoescape=True, trim_blocks=True)
    template = environment.from_string(parts.joinpath("report.html").read_text("utf-8"))
    return template.render(
        version=version("ase-roughcontact"),
        data=as_json(data),
        has_chart=bool(data),
        has_maps=bool(data and data["maps"]),
        script=parts.joinpath("report.js").read_text("utf-8"),
        saved=[
            (file.name, _encoded(file.read_bytes())) for file in saved if file.is_file()
        ],
        figures=[(name, _encoded(image), caption) for name, image, caption in figures],
        **values,
    )


def _of_folder(
    folder: Path, captions: Mapping[str, str], pictures: Sequence[str]
) -> dict[str, Any]:
    """Return title, scene and figures of the page of a folder."""
    found = [
        (name, (folder / name).read_bytes(), text)
        for name, text in captions.items()
        if name in pictures and (folder / name).is_file()
    ]
    scene = (folder / "scene.toml").read_text(encoding="utf-8")
    return {"title": folder.resolve().name, "scene": scene, "figures": found}


def _encoded(picture: bytes) -> str:
    return base64.b64encode(picture).decode()


def _warnings(scene: Scene, steps: Sequence[LoadStep]) -> list[str]:
    """Return the warnings about a scene, its results, and their validity."""
    found = [*scene.warnings, *_missing(scene, steps)]
    if steps:
        found += scene.path.warnings(scene.bodies, steps)
    failed: dict[str, list[int]] = {}
    for step in steps:
        if not step.converged:
            failed.setdefault(step.message, []).append(step.step)
    for message, numbers in failed.items():
        found.append(f"{_steps_in_words(numbers)} did not converge: {message}")
    for limit, text in report.exceeded_limits(steps).items():
        found.append(f"{limit}: {text}")
    return found


def _missing(scene: Scene, steps: Sequence[Any]) -> list[str]:
    """Return a warning if a run of known length is not finished."""
    count, schedule = scene.path.count(scene.bodies), scene.path.schedule(scene.bodies)
    reached = ""
    if count is not None and len(steps) < count:
        reached = f"{len(steps)} of {count} steps"
    elif schedule is not None and steps:
        time, end = steps[-1].time, schedule.duration
        if time < (1.0 - ROUNDING) * end:
            reached = f"{number(time)} of {number(end)} s"
    if not reached:
        return []
    return [f"The run is not finished: {reached}. The same command continues it"]


def _steps_in_words(numbers: Sequence[int]) -> str:
    """Return "Steps 1, 2, 3 and 4 more": the first of several steps by number."""
    shown = ", ".join(map(str, numbers[:_MAX_LISTED_STEPS]))
    more = len(numbers) - _MAX_LISTED_STEPS
    rest = f" and {more} more" if more > 0 else ""
    return f"Step{'s' if len(numbers) > 1 else ''} {shown}{rest}"


def _is_unknown(steps: Sequence[LoadStep], name: str) -> bool:
    """Return whether a column is not known in any step."""
    return all(math.isnan(getattr(step, name)) for step in steps)


def _cell(step: LoadStep, name: str, unit: str) -> tuple[str, str]:
    """Return a value of a step and its error as text; no error if it is negligible."""
    value = getattr(step, name) / UNITS[unit] if unit else getattr(step, name)
    error_column = _ERROR_OF_COLUMN.get(name)
    error = getattr(step, error_column) / UNITS[unit] if error_column else 0.0
    text, _ = _text(value)
    if math.isnan(value):
        return text, ""
    if math.isnan(error):
        return text, "not known"
    return text, number(error, 2) if error > _MIN_RELATIVE_ERROR * abs(value) else ""
