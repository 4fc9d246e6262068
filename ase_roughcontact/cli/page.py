"""Results of a run as one HTML page: input, warnings, figures and numbers."""

from __future__ import annotations

import base64
import html
import math
from collections.abc import Sequence
from pathlib import Path

from ase_roughcontact._util.units import UNITS, printed_unit
from ase_roughcontact.cli import report
from ase_roughcontact.cli.description import description
from ase_roughcontact.paths.record import LoadStep, columns_of
from ase_roughcontact.scene.reference import Reference

# Columns of the table.
_COLUMNS = (
    "step",
    "penetration",
    "normal_force",
    "force_error",
    "contact_area",
    "area_error",
    "penetration_error",
    "contact_stiffness",
    "mean_pressure",
    "largest_pressure",
    "repulsive_atoms",
    "attractive_atoms",
    "plastic_atoms",
)
_STYLE = """
body { font-family: sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; font-size: 85%; }
th, td { padding: 0.2em 0.6em; text-align: right; border-bottom: 1px solid #ddd; }
td { white-space: nowrap; } .wide { overflow-x: auto; }
p { white-space: pre-line; }
pre { background: #f4f4f4; padding: 1em; overflow-x: auto; }
figure { display: inline-block; margin: 1em 1%; width: 47%; vertical-align: top; }
figure.maps { width: 98%; } img { max-width: 100%; } figcaption { font-size: 85%; }
.warning { border-left: 4px solid #d55e00; padding-left: 1em; white-space: pre-line; }
.failed { color: #d55e00; }
"""


def page(reference: Reference, steps: Sequence[LoadStep], folder: Path) -> str:
    """Return the page of a run.

    Parameters
    ----------
    reference : Reference
        Theory for the scene.
    steps : sequence of LoadStep
    folder : path
        Contains ``scene.toml`` and the figures, which become part of the page.

    Returns
    -------
    str
        HTML, without references to other files.
    """
    scene, path = reference.scene, reference.scene.path
    figures = {
        "curve.png": "Contact area relative to a smooth sphere without adhesion.",
        "force.png": "Normal force along the path.",
        **path.captions,
        "contact.png": "Pressure on the atoms in contact.",
    }
    scene_text = (folder / "scene.toml").read_text(encoding="utf-8")
    parts = [
        f"<h1>{html.escape(folder.resolve().name)}</h1>",
        _paragraphs(description(reference)),
        _paragraphs(path.summary(scene, steps)),
        _warnings(scene.warnings, steps),
        *(_figure(folder / name, text) for name, text in figures.items()),
        "<h2>Steps</h2>",
        _table(steps),
        "<h2>Scene</h2>",
        f"<pre>{html.escape(scene_text)}</pre>",
    ]
    body = "\n".join(filter(None, parts))
    title = html.escape(folder.resolve().name)
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">\n'
        f"<title>{title}</title><style>{_STYLE}</style></head>\n"
        f"<body>{body}</body></html>\n"
    )


def _paragraphs(text: str) -> str:
    return f"<p>{html.escape(text)}</p>" if text else ""


def _warnings(warnings: Sequence[str], steps: Sequence[LoadStep]) -> str:
    """Return warnings, steps that are no results, and the limits of the model."""
    lines = [
        *warnings,
        *(
            f"Step {step.step} did not converge: {step.message}"
            for step in steps
            if not step.converged
        ),
        *report.exceeded_limits(steps),
    ]
    if not lines:
        return "<p>All steps converged within the limits of the model.</p>"
    return f'<div class="warning">{html.escape(chr(10).join(lines))}</div>'


def _figure(file: Path, caption: str) -> str:
    """Return a figure with its data; empty if there is no such file."""
    if not file.is_file():
        return ""
    kind = "maps" if file.name == "contact.png" else "curve"
    data = base64.b64encode(file.read_bytes()).decode("ascii")
    image = f'<img alt="{caption}" src="data:image/png;base64,{data}">'
    text = f"<figcaption>{caption}</figcaption>"
    return f'<figure class="{kind}">{image}{text}</figure>'


def _table(steps: Sequence[LoadStep]) -> str:
    """Return the table of steps, in the units in which columns are printed."""
    columns = columns_of(type(steps[0])) if steps else {}
    shown = {name: columns[name] for name in _COLUMNS if name in columns}
    units = {name: printed_unit(each.unit) for name, each in shown.items()}
    heads = "".join(
        f'<th title="{html.escape(each.description)}">{name.replace("_", " ")}'
        + (f" ({units[name]})" if units[name] else "")
        + "</th>"
        for name, each in shown.items()
    )
    rows = [
        f"<tr{'' if step.converged else ' class=failed'}>"
        + "".join(
            f"<td>{_cell(getattr(step, name), UNITS[units[name]])}</td>"
            for name in shown
        )
        + "</tr>"
        for step in steps
    ]
    body = "\n".join(rows)
    return f'<div class="wide"><table><tr>{heads}</tr>\n{body}</table></div>'


def _cell(value: float, unit: float) -> str:
    if isinstance(value, int):
        return str(value)
    return f"{value / unit:.4g}".replace("e-0", "e-") if math.isfinite(value) else "–"
