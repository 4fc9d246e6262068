"""Numbers on a page that its script shows: columns, theory, and maps of some steps."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps

from ase_roughcontact._util.units import UNITS, with_unit
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.ensemble.places import PLACE_UNITS, Place, result_units
from ase_roughcontact.results.record import LoadStep, columns_of
from ase_roughcontact.scene import Results, Scene
from ase_roughcontact.scene.printed import units_in_print

# Largest number of maps on a page.
_MAX_MAPS = 8
# Largest number of points along a side of a map on a page.
_MAX_POINTS = 256
# Number of colours of a map.
_COLOURS = 256


def data_of_run(results: Results) -> dict[str, Any]:
    """Return columns of a run in printed units, areas by theory, and maps.

    Parameters
    ----------
    results : Results

    Returns
    -------
    dict
        Lists and texts only, for `as_json`. Maps have at most 256 points along a side:
        of larger ones every second, third, ... point.
    """
    scene, units = results.scene, units_in_print(results.scene)
    names = [
        name
        for name in columns_of(scene.record)
        if results[name].dtype.kind in "fi" and np.isfinite(results[name]).any()
    ]
    columns = []
    for name in names:
        scale = UNITS.get(units[name], 1.0)
        error = results.error_column(name)
        errors = results[error] / scale if error in names else None
        columns.append(chart_column(name, units[name], results[name] / scale, errors))
    y, along = results.usual_columns
    if scene.is_flat:
        along = "nominal_pressure"
    return {
        "columns": columns,
        "rows": "step",
        "failed": _rows_without(results["converged"]),
        "x": along,
        "y": y,
        "lines": bool(scene.path.in_order or scene.path.is_loop),
        "theory": _theory(results, units),
        "maps": _maps(results, along, units),
    }


def data_of_places(scene: Scene, places: Sequence[Place]) -> dict[str, Any]:
    """Return the columns of places on a scan in printed units; see `data_of_run`.

    Parameters
    ----------
    scene : Scene
    places : sequence of Place
    """
    units = {**PLACE_UNITS, **result_units()}
    names = [
        name for name in units if name in PLACE_UNITS or name in scene.path.results
    ]
    values = {
        name: np.array([place.value(name) for place in places]) / UNITS[units[name]]
        for name in names
        if units[name]
    }
    columns = [
        chart_column(
            name, units[name], each, values["area_error"] if name == "area" else None
        )
        for name, each in values.items()
        if np.isfinite(each).any()
    ]
    known = [each["name"] for each in columns]
    y = "pull_off_force" if scene.path.is_loop else "area"
    return {
        "columns": columns,
        "rows": "place",
        "failed": _rows_without([place.converged for place in places]),
        "x": "normal_force" if "normal_force" in known else known[0],
        "y": y if y in known else known[-1],
        "lines": False,
        "theory": None,
        "maps": _map_of_places(places, columns),
    }


def chart_column(
    name: str,
    unit: str,
    values: Iterable[float],
    errors: Iterable[float] | None = None,
    label: str = "",
) -> dict[str, Any]:
    """Return a column of a chart.

    Parameters
    ----------
    name, unit : str
        Name of the column, and the unit of its values.
    values : iterable of float
    errors : iterable of float, optional
        Their errors.
    label : str, optional
        Words for the name.
    """
    return {
        "name": name,
        "label": label or name.replace("_", " "),
        "unit": unit,
        "values": _listed(values),
        "errors": None if errors is None else _listed(errors),
    }


def as_json(data: object) -> str:
    """Return JSON for an element ``script`` of HTML, which no text in it can end."""
    return json.dumps(data, allow_nan=False).replace("<", "\\u003c")


def _listed(values: Iterable[float]) -> list[float | None]:
    """Return numbers for JSON, None in place of numbers that are not finite."""
    return [float(each) if np.isfinite(each) else None for each in values]


def _rows_without(converged: Iterable[Any]) -> list[int]:
    """Return the numbers of the rows that did not converge."""
    return [row for row, each in enumerate(converged) if not each]


def _theory(results: Results, units: dict[str, str]) -> dict[str, Any] | None:
    """Return the areas by theory against force or nominal pressure, None without."""
    forces, areas = results.areas_by_theory()
    if not areas:
        return None
    column, along, loads = results.scene.area_column, "normal_force", forces
    if results.scene.is_flat:
        areas.pop(results.scene.bodies.labelled(results.reference.smooth.label))
        along, loads = "nominal_pressure", forces / results.scene.bodies.nominal_area
    x = _listed(loads / UNITS[units[along]])
    lines = [
        {
            "label": label.replace("$", ""),
            "x": x,
            "y": _listed(area / UNITS[units[column]]),
        }
        for label, area in areas.items()
    ]
    return {"x": along, "y": column, "lines": lines}


def _maps(results: Results, along: str, units: dict[str, str]) -> dict[str, Any] | None:
    """Return maps of some steps in contact, None if there are none.

    Parameters
    ----------
    results : Results
    along : str
        Column that tells where on the path a step is.
    units : dict of str to str
        Units of the columns in print.
    """
    touching = [
        number for number in results.steps_with_map if results[number].repulsive_atoms
    ]
    if not touching:
        return None
    forces = [results[number].normal_force for number in touching]
    chosen = np.linspace(0, len(touching) - 1, _MAX_MAPS).round().astype(int)
    numbers = [touching[i] for i in sorted({*chosen.tolist(), int(np.argmax(forces))})]
    length = units["penetration"].replace("Å", "nm")
    frames = []
    for number in numbers:
        step, frame = results[number], _frame(results.map(number), UNITS[length])
        frames.append({"label": _label(step, along, units), "step": step.step, **frame})
    scanned = results.scene.bodies.scanned
    return {
        "frames": frames,
        "shown": int(np.argmax([results[number].normal_force for number in numbers])),
        "fields": [
            {"name": "pressure", "unit": units["largest_pressure"]},
            {"name": "gap", "unit": length},
            {"name": "contact", "unit": ""},
        ],
        "scales": {
            "pressure": UNITS[units["largest_pressure"]],
            "gap": UNITS[length],
        },
        "length": length,
        "from_zero": True,
        "colours": _colours(),
        "upward": not scanned,
        "rightward": scanned != "indenter",
    }


def _map_of_places(
    places: Sequence[Place], columns: Sequence[Mapping[str, Any]]
) -> dict[str, Any] | None:
    """Return maps of columns over places on a grid, None if there are none."""
    x, y = (np.array([getattr(p, k) for p in places]) / UNITS["nm"] for k in "xy")
    along = [np.unique(each) for each in (x, y)]
    if len(places) < 2 or len(along[0]) * len(along[1]) != len(places):
        return None
    numbers = tuple(np.searchsorted(a, b) for a, b in zip(along, (x, y), strict=True))
    values = {}
    for column in columns:
        if column["name"] not in ("x", "y"):
            grid = np.full((len(along[0]), len(along[1])), np.nan)
            grid[numbers] = [math.nan if v is None else v for v in column["values"]]
            values[column["name"]] = (grid, column["unit"])
    ends = [(float(each[0]), float(each[-1])) for each in along]
    return grid_maps(values, ends[0], ends[1], "nm", upward=False)


def grid_maps(
    values: Mapping[str, tuple[np.ndarray, str]],
    x: tuple[float, float],
    y: tuple[float, float],
    length: str,
    upward: bool = True,
) -> dict[str, Any]:
    """Return maps of quantities on one grid.

    Parameters
    ----------
    values : mapping of str to (ndarray, shape (n, m), str)
        Values with the first index along x, and their unit, by name.
    x, y : (float, float)
        First and last coordinate along each axis.
    length : str
        Unit of the coordinates.
    upward : bool
        Whether y is drawn upward.
    """
    n, m = next(iter(values.values()))[0].shape
    frame: dict[str, Any] = {"label": "", "step": 0, "every": 1}
    frame |= {"x": [*x, n], "y": [*y, m]}
    for name, (grid, _) in values.items():
        frame[name] = _encoded(grid.T.astype("<f4"))
    return {
        "frames": [frame],
        "shown": 0,
        "fields": [{"name": name, "unit": unit} for name, (_, unit) in values.items()],
        "scales": dict.fromkeys(values, 1.0),
        "length": length,
        "from_zero": False,
        "colours": _colours(),
        "upward": upward,
        "rightward": True,
    }


def _colours() -> str:
    """Return the colours of a map, three bytes for each."""
    colours = colormaps["viridis"](np.arange(_COLOURS))[:, :3]
    return _encoded((255.0 * colours).round().astype("u1"))


def _label(step: LoadStep, along: str, units: dict[str, str]) -> str:
    """Return where on the path a step is."""
    parts = []
    for name in dict.fromkeys((along, "normal_force", "penetration")):
        value = with_unit(getattr(step, name), units[name])
        parts.append(f"{name.replace('_', ' ')} {value}")
    failed = "" if step.converged else " (not converged)"
    return f"step {step.step}{failed}: {', '.join(parts)}"


def _frame(seen: ContactMap, length: float) -> dict[str, Any]:
    """Return the fields of a step, in rows along x from the lowest y on."""
    every = -(-max(seen.pressure.shape) // _MAX_POINTS)
    thinned = slice(None, None, every)

    def rows(field: np.ndarray) -> np.ndarray:
        return field[thinned, thinned].T

    x, y = seen.x[thinned] / length, seen.y[thinned] / length
    return {
        "every": every,
        "x": [float(x[0]), float(x[-1]), len(x)],
        "y": [float(y[0]), float(y[-1]), len(y)],
        "pressure": _encoded(rows(seen.pressure).astype("<f4")),
        "gap": None if seen.gap is None else _encoded(rows(seen.gap).astype("<f4")),
        "contact": _encoded(np.packbits(rows(seen.contact), bitorder="little")),
    }


def _encoded(values: np.ndarray) -> str:
    return base64.b64encode(values.tobytes()).decode()
