"""Results of a run as one HTML page: warnings, input, results, figures and steps."""

from __future__ import annotations

import base64
import math
from collections.abc import Sequence
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment

from ase_roughcontact._util.printing import number
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import report
from ase_roughcontact.results.record import LoadStep, columns_of
from ase_roughcontact.scene.reference import Reference

# Columns of the table of steps, with the columns of their errors.
_COLUMNS = {
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
# Relative error that is left out, as it is below the last digit.
_NEGLIGIBLE = 5e-5
_CAPTIONS = {
    "curve.png": "Contact area, and relative to a smooth sphere without adhesion "
    "(Hertz), beside theory.",
    "force.png": "Normal force along the path; negative forces are tensile.",
    "contact.png": "Pressure on the atoms in contact; circle: smooth sphere under the "
    "same load, around its axis; of a scanned tip around the centre of the load.",
}
_FLAT_CAPTIONS = {
    "curve.png": "Contact area relative to the nominal one, beside theory, mean gap, "
    "and contact stiffness and conductance, against the nominal pressure.",
    "contact.png": "Pressure on the points in contact.",
}


def page(reference: Reference, steps: Sequence[LoadStep], folder: Path) -> str:
    """Return the page of a run.

    Parameters
    ----------
    reference : Reference
        Theory for the scene.
    steps : sequence of LoadStep
    folder : path
        Folder with ``scene.toml`` and the figures, which become part of the page.

    Returns
    -------
    str
        HTML, without references to other files.
    """
    scene = reference.scene
    record = columns_of(type(steps[0]) if steps else LoadStep)
    other_area = {"contact_area", "continuum_area"} - {scene.area_column}
    first, *others = _COLUMNS
    own = [name for name in scene.path.columns if name not in {"seconds", *others}]
    shown = {
        name: record[name]
        for name in (first, *own, *others)
        if name in record
        and name not in other_area
        # quantities that are not defined for the wall have no column
        and not (record[name].where.constant and steps and _is_unknown(steps, name))
    }
    units = report.units_of(scene)
    captions = _CAPTIONS | (_FLAT_CAPTIONS if scene.is_flat else {})
    captions |= dict(scene.path.captions)
    if scene.roughness is not None and not scene.is_flat:
        captions["curve.png"] += (
            " Other realisations of the roughness scatter about it, most at light "
            "loads, which few asperities carry."
        )
    if scene.scan is not None:
        captions["contact.png"] += " The first line of the scan is at the top."
    template = files("ase_roughcontact.cli").joinpath("report.html").read_text("utf-8")
    environment = Environment(autoescape=True, trim_blocks=True)
    return environment.from_string(template).render(
        title=folder.resolve().name,
        version=version("ase-roughcontact"),
        warnings=[
            *scene.warnings,
            *(scene.path.warnings(scene.bodies, steps) if steps else ()),
            *(
                f"Step {step.step} did not converge: {step.message}"
                for step in steps
                if not step.converged
            ),
            *map(": ".join, report.exceeded_limits(steps).items()),
        ],
        inputs=report.inputs(reference),
        results=report.results(reference, steps)
        | report.unknown_counted(
            {
                name.replace("_", " "): [s.not_known.get(name, "") for s in steps]
                for name in shown
            },
            len(steps),
        ),
        figures=[
            (base64.b64encode((folder / name).read_bytes()).decode(), caption)
            for name, caption in captions.items()
            if (folder / name).is_file()
        ],
        heads=[
            (name.replace("_", " "), units[name], each.description)
            for name, each in shown.items()
        ],
        steps=[
            (not step.converged, [_cell(step, name, units[name]) for name in shown])
            for step in steps
        ],
        scene=(folder / "scene.toml").read_text(encoding="utf-8"),
    )


def _is_unknown(steps: Sequence[LoadStep], name: str) -> bool:
    """Return whether a column is not known in any step."""
    return all(math.isnan(getattr(step, name)) for step in steps)


def _cell(step: LoadStep, name: str, unit: str) -> tuple[str, str]:
    """Return a value of a step and its error as text; no error if it is negligible."""
    value = getattr(step, name) / UNITS[unit] if unit else getattr(step, name)
    of_error = _COLUMNS.get(name)
    error = getattr(step, of_error) / UNITS[unit] if of_error else 0.0
    if math.isnan(value):
        return "not known", ""
    text = number(value).replace("-", "\N{MINUS SIGN}")
    if math.isnan(error):
        return text, "not known"
    return text, number(error, 2) if error > _NEGLIGIBLE * abs(value) else ""
