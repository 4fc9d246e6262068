"""Maps of area and adhesion: a scene with the tip at a grid of places on a scan."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from concurrent.futures import Executor, as_completed
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from ase_roughcontact._util.checked_rows import CHECKSUM, checked_rows, with_checksum
from ase_roughcontact._util.files import table_writer
from ase_roughcontact._util.lazy import lazy
from ase_roughcontact._util.locks import locked
from ase_roughcontact._util.units import UNITS, printed_unit
from ase_roughcontact._util.workers import worker_pool
from ase_roughcontact.ensemble.foreseen import expected_width, warn_of_problems
from ase_roughcontact.results.limits import exceeded_names
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.file import SceneFile, read_text
from ase_roughcontact.scene.path_kind import PATHS
from ase_roughcontact.scene.path_result import results_of
from ase_roughcontact.scene.results import check_folder, check_inputs, write_inputs
from ase_roughcontact.topography import HeightMap

#: Attributes of a place that are numbers, and their units in the file.
PLACE_UNITS = {
    "x": "nm",
    "y": "nm",
    "normal_force": "nN",
    "area": "nm²",
    "pull_off_force": "nN",
    "penetration": "nm",
    "area_error": "nm²",
}
# Columns of the file that may have the area.
_AREA_COLUMNS = "contact_area", "continuum_area"
# Columns without a unit.
_COLUMNS_WITHOUT_UNIT = "converged", "message", "validity", CHECKSUM


@dataclass(frozen=True)
class Place:
    """Result at a place of the tip on a scan.

    Attributes
    ----------
    x, y : float
        Position from the first point of the scan (Å).
    normal_force, area, penetration : float
        Values at the last step of the path, or at the deepest state of a loop, where it
        turns (eV/Å, Å^2, Å). The area is the column that the scene asks for, and has
        the name of this column in the file.
    pull_off_force : float
        Largest tension of the path or of the retraction (eV/Å).
    converged : bool
        Whether all states have converged.
    message : str
        Reason why there is no result, such as a place too close to an edge, or why the
        pull-off force is a lower bound; otherwise empty.
    area_error : float
        Estimated error of the area (Å^2), without effects of the pixels and the noise
        of the scan.
    validity : str
        Names of the limits of the model that states exceed; empty if none.
    results : dict of float
        Further results of the kind of path, see `PathKind.results`.
    """

    x: float
    y: float
    normal_force: float = math.nan
    area: float = math.nan
    pull_off_force: float = math.nan
    penetration: float = math.nan
    converged: bool = False
    message: str = ""
    area_error: float = math.nan
    validity: str = ""
    results: Mapping[str, float] = field(default_factory=dict)

    def value(self, name: str) -> float:
        """Return an attribute that is a number, or a result."""
        if name in PLACE_UNITS:
            return float(getattr(self, name))
        return self.results.get(name, math.nan)


def result_units() -> dict[str, str]:
    """Return the units of results in the file, by name, of all kinds of path."""
    return {
        name: printed_unit(result.unit)
        for kind in PATHS.values()
        for name, result in kind.results.items()
        if name not in PLACE_UNITS
    }


@lazy
def run_places(
    scene: Scene,
    shape: tuple[int, int],
    folder: str | Path,
    executor: Executor | None = None,
    workers: int | None = None,
) -> Iterator[Place]:
    """Run a scene with the tip at a grid of places on the scan.

    The places are `HeightMap.places`, with the `margin` of ``[topography]``; by default
    half the window that is expected at the deepest step. A run that was interrupted
    goes on where it ended, and tries places without a converged result again.

    Parameters
    ----------
    scene : Scene
        Scene with a scan and a path of steps or a loop.
    shape : (int, int)
        Numbers of places along x and y.
    folder : path
        Folder for ``scene.toml`` and ``places.csv``, which gets a row in nm and nN for
        each `Place` as soon as it is calculated.
    executor : Executor, optional
        See `run_ensemble`.
    workers : int, optional
        Number of processes of the default pool.

    Yields
    ------
    Place
        Result at each place, including places of an earlier run.

    Raises
    ------
    ValueError
        If the scene has no scan or is invalid, one of its files has the name of a
        result, or the folder contains another scene.
    RuntimeError
        If another run is writing the folder.

    Warns
    -----
    UserWarning
        If places will probably have no result, as they are too close to an edge.
    """
    folder = Path(folder)
    places, table = _grid(scene, shape), folder / "places.csv"
    check_inputs(scene)
    folder.mkdir(parents=True, exist_ok=True)
    with locked(table):
        found = _earlier_places(scene, folder)
        yield from (found[place] for place in places if place in found)
        missing = [place for place in places if place not in found]
        warn_of_problems(
            (_place_name(place), scene.with_values(_center(scene, *place)))
            for place in missing
        )
        units = {
            _column_of(k, scene.area_column): unit for k, unit in PLACE_UNITS.items()
        }
        results = {k: v for k, v in result_units().items() if k in scene.path.results}
        row_of = partial(_row, area=scene.area_column, results=results)
        units |= results
        heads = {k: f"{k} ({unit})" if unit else k for k, unit in units.items()}
        heads |= {name: name for name in _COLUMNS_WITHOUT_UNIT}
        rows = table_writer(table, heads, map(row_of, found.values()))
        with worker_pool(executor, workers) as running, rows as write:
            tasks = [running.submit(_calculate, scene, *place) for place in missing]
            try:
                for task in as_completed(tasks):
                    write(row_of(task.result()))
                    yield task.result()
            finally:
                for task in tasks:
                    task.cancel()


def read_places(file: str | Path) -> list[Place]:
    """Return the places of a file ``places.csv``.

    Parameters
    ----------
    file : path
        The file.

    Returns
    -------
    list of Place
        Places in the order of the file.

    Raises
    ------
    ValueError
        If the file is damaged.
    """
    with checked_rows(file) as rows:
        return [_place(row) for row in rows]


def _grid(scene: Scene, shape: tuple[int, int]) -> list[tuple[float, float]]:
    """Return the positions of the places, rounded as in the file."""
    scene.check()
    scan = scene.scans[scanned_section(scene)]
    surface, margin = scan.surface, scan.edge
    if scan.margin is None and not surface.periodic:
        margin = 0.5 * min(expected_width(scene), *_sides(surface))
    x, y = surface.places(*shape, margin=margin)
    return [(round(i, 6), round(j, 6)) for i in x.tolist() for j in y.tolist()]


def _sides(surface: HeightMap) -> list[float]:
    """Return the distances between opposite edges of a scan (Å)."""
    return [
        (n - 1) * step for n, step in zip(surface.shape, surface.spacing, strict=True)
    ]


def _place_name(place: tuple[float, float]) -> str:
    """Return the position of a place as text."""
    x, y = (each / UNITS["nm"] for each in place)
    return f"the place at ({x:.4g}, {y:.4g}) nm"


def places_of(scene: Scene, shape: tuple[int, int]) -> list[Scene]:
    """Return the scene with the tip at each place of a grid; see `run_places`."""
    grid = _grid(scene, shape)
    return [scene.with_values(_center(scene, *place)) for place in grid]


def scanned_section(scene: Scene) -> str:
    """Return the title of the scan with the places; of the substrate if both have one.

    Raises
    ------
    ValueError
        If the scene has no scan.
    """
    if not scene.scans:
        raise ValueError("places are on a scan: the scene needs [topography]")
    return next(iter(scene.scans))


def _center(scene: Scene, x: float, y: float) -> dict[str, tuple[str, str]]:
    """Return the key of a scene that moves the tip to a place."""
    return {f"{scanned_section(scene)}.center": (f"{x!r} Å", f"{y!r} Å")}


def _earlier_places(scene: Scene, folder: Path) -> dict[tuple[float, float], Place]:
    """Return the converged places of an earlier run of the scene in a folder.

    The earlier run may have had other `max_steps` or another optimizer.
    """
    results, file = folder / "places.csv", folder / "scene.toml"
    if not results.exists():
        check_folder(scene, folder)
        write_inputs(scene, file)
        return {}
    same = scene  # as in the file, apart from the solver
    with suppress(ValueError):  # `check_folder` raises it with its reason
        old = SceneFile.parse(read_text(file), str(file), copied=True).solver
        changes = {"max_steps": old.max_steps, "optimizer": old.optimizer}
        same = scene.with_values({f"solver.{k}": v for k, v in changes.items()})
    check_folder(same, folder)
    places = [place for place in read_places(results) if place.converged]
    if same.solver != scene.solver:
        write_inputs(scene, file)
    return {(place.x, place.y): place for place in places}


def _calculate(scene: Scene, x: float, y: float) -> Place:
    """Return the result at a place; an error becomes the message of the place."""
    try:
        here = scene.with_values(_center(scene, x, y))
        states = tuple(here.relax(validity="ignore", scan_errors=False))
        last, tension = here.path.extremes(here.bodies, states)
        results = results_of(here.path, here.bodies, states)
    except (ValueError, RuntimeError, MemoryError) as error:
        return Place(x, y, message=str(error))
    failed = next((state for state in states if not state.converged), None)
    messages = [] if failed is None else [f"not converged: {failed.message}"]
    messages += here.path.warnings(here.bodies, states)
    return Place(
        x,
        y,
        normal_force=last.normal_force,
        area=getattr(last, scene.area_column),
        pull_off_force=tension,
        penetration=last.penetration,
        converged=failed is None,
        message="; ".join(messages),
        area_error=last.area_error,
        validity="; ".join(exceeded_names(state.validity for state in states)),
        results={k: v for k, v in results.items() if k not in PLACE_UNITS},
    )


def _column_of(attribute: str, area: str) -> str:
    """Return the name of an attribute of a place in the file."""
    return area if attribute == "area" else attribute


def _row(place: Place, area: str, results: Mapping[str, str]) -> dict[str, str]:
    """Return the row of a place, with its checksum; results have units by name."""
    row = {
        _column_of(attribute, area): f"{getattr(place, attribute) / UNITS[unit]:.12g}"
        for attribute, unit in PLACE_UNITS.items()
    }
    for name, unit in results.items():  # NaN of a place without a result
        row[name] = f"{place.results.get(name, math.nan) / UNITS[unit]:.12g}"
    row |= {"converged": str(place.converged), "message": place.message}
    return with_checksum(row | {"validity": place.validity})


def _place(row: dict[str, str]) -> Place:
    """Return the place of a row."""
    area = next((name for name in _AREA_COLUMNS if name in row), _AREA_COLUMNS[0])
    numbers = {
        attribute: UNITS[unit] * float(row.get(_column_of(attribute, area), "nan"))
        for attribute, unit in PLACE_UNITS.items()
    }
    units = {name: unit for name, unit in result_units().items() if name in row}
    results = {name: UNITS[unit] * float(row[name]) for name, unit in units.items()}
    x, y = (round(numbers.pop(name), 6) for name in ("x", "y"))  # as in `_grid`
    return Place(
        x,
        y,
        **numbers,
        converged=row.get("converged") == "True",
        message=row.get("message") or "",
        validity=row.get("validity") or "",
        results=results,
    )


def as_map(places: list[Place], name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return an attribute of places as a map.

    Parameters
    ----------
    places : list of Place
        The places.
    name : str
        Name of the attribute, or of a result.

    Returns
    -------
    x, y : ndarray, shapes (n,) and (m,)
        Positions of the places (Å).
    values : ndarray, shape (n, m)
        Values of the attribute; NaN where there is no converged result.
    """
    x, i = np.unique([place.x for place in places], return_inverse=True)
    y, j = np.unique([place.y for place in places], return_inverse=True)
    values = np.full((len(x), len(y)), np.nan)
    values[i, j] = [p.value(name) if p.converged else math.nan for p in places]
    return x, y, values
