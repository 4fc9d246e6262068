"""Columns of an ensemble: the numbers of each load step in the database."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from ase_roughcontact._util.files import PathName, check_different, write_table
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.ensemble.database import EnsembleDatabase, database_address
from ase_roughcontact.ensemble.table import EnsembleTable
from ase_roughcontact.results.flat_record import FlatStep
from ase_roughcontact.results.record import (
    MISSING,
    LoadStep,
    columns_of,
    columns_on_request,
    units_of,
)
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.path_kind import PATHS
from ase_roughcontact.scene.path_result import lower_bounds_of, results_of

# Types of the columns of the roughness of one of two bodies, after "tip_" for instance.
_BODY_COLUMNS: dict[str, type] = {
    "rms_slope": float,
    "rms_height": float,
    "rms_curvature": float,
    "seed": int,
}
# Bodies that may be rough, each with its own columns.
_BODIES = "tip", "substrate"
# Types of the columns of the roughness of single bodies.
_TYPES_BY_BODY: dict[str, type] = {
    f"{body}_{name}": kind for body in _BODIES for name, kind in _BODY_COLUMNS.items()
}
# Types of the columns that the scene determines.
_SCENE_COLUMNS: dict[str, type] = {
    "control": str,
    "radius": float,
    "rms_slope": float,
    "rms_height": float,
    "rms_curvature": float,
    "hurst": float,
    "short_wavelength": float,
    "long_wavelength": float,
    "seed": int,
    **_TYPES_BY_BODY,
    "kind": str,
    "work_of_adhesion": float,
    "attraction_range": float,
    "hardness": float,
    "permanent": bool,
    "friction_coefficient": float,
    "shear_strength": float,
    "spacing": float,
    "contact_modulus": float,
    "rate": float,
}
# Units of the columns that the scene determines.
_SCENE_UNITS = {
    "radius": "a0",
    "rms_height": "a0",
    "rms_curvature": "1/a0",
    **{f"{body}_rms_height": "a0" for body in _BODIES},
    **{f"{body}_rms_curvature": "1/a0" for body in _BODIES},
    "short_wavelength": "a0",
    "long_wavelength": "a0",
    "work_of_adhesion": "J/m^2",
    "attraction_range": "a0",
    "hardness": "GPa",
    "shear_strength": "GPa",
    "spacing": "Å",
    "contact_modulus": "eV/Å^3",
}
# Columns of the row of a case beside the input and the results; see `read_ensemble`.
_CASE_COLUMNS: dict[str, type] = {
    "state": str,
    "message": str,
    "steps": int,
    "unconverged": int,
    "validity": str,
    "lower_bounds": str,
}


def step_types() -> dict[str, type]:
    """Return the types of the columns of load steps, of all kinds of path."""
    columns: dict[str, type] = {"case": str, "step": int, "control": str}
    columns["target"] = float
    columns.update(_SCENE_COLUMNS)
    for record in _records():
        types = get_type_hints(record)
        names = columns_of(record)
        columns.update({name: types[name] for name in types if name in names})
    columns["version"] = str
    return columns


def case_types() -> dict[str, type]:
    """Return the types of the columns of cases, with results of all kinds of path."""
    columns = {"case": str, **_CASE_COLUMNS, **_SCENE_COLUMNS}
    results = {name: float for kind in PATHS.values() for name in kind.results}
    return columns | results


def column_units() -> dict[str, str]:
    """Return the units of all columns that have one."""
    units = dict(_SCENE_UNITS)
    for record in _records():
        units.update(units_of(record))
    for kind in PATHS.values():
        units.update({name: each.unit for name, each in kind.results.items()})
    return {name: unit for name, unit in units.items() if unit}


def _records() -> list[type[LoadStep]]:
    """Return the records of all kinds of path, with columns on request."""
    steps: list[type[LoadStep]] = [kind.record for kind in PATHS.values()]
    steps.append(FlatStep)
    return [step.with_columns(list(columns_on_request(step))) for step in steps]


def scene_columns(scene: Scene) -> dict[str, Any]:
    """Return the columns that a scene determines, the same for all its steps.

    Lengths are in units of the spacing, which is in Å. Parameters of the wall include
    those that follow from named materials.
    """
    spacing, wall, nan = scene.spacing, scene.wall, math.nan
    hardness = scene.hardness / UNITS["GPa"]
    rate = getattr(scene.path, "rate", None)
    values = {
        "control": scene.path.control,
        "radius": scene.radius / spacing,
        **_roughness_columns(scene),
        **_body_columns(scene),
        "kind": scene.interaction.kind,
        "work_of_adhesion": wall.work_of_adhesion / UNITS["J/m^2"] or nan,
        "attraction_range": wall.attraction_range / spacing or nan,
        "hardness": hardness if wall.hardness < math.inf else nan,
        "permanent": wall.permanent,
        "friction_coefficient": scene.friction.coefficient if scene.friction else nan,
        "shear_strength": scene.friction.shear_strength if scene.friction else nan,
        "spacing": spacing,
        "contact_modulus": scene.contact_modulus,
        "rate": rate if isinstance(rate, (int, float)) else nan,
    }
    return {
        name: MISSING[kind] if values[name] is None else kind(values[name])
        for name, kind in _SCENE_COLUMNS.items()
    }


def _roughness_columns(scene: Scene) -> dict[str, Any]:
    """Return the columns of the roughness, which a smooth sphere does not have.

    Rms height and curvature are of random roughness.
    """
    rough, nan = scene.rough, math.nan
    if rough is None:
        # the slope of a scanned tip is not due to roughness alone
        slope = nan if scene.whole_tip else 0.0
        unknown = dict.fromkeys(("hurst", "short_wavelength", "long_wavelength"), nan)
        unknown |= {"rms_height": slope, "rms_curvature": slope}
        return {"rms_slope": slope, **unknown, "seed": None}
    height = curvature = nan
    if scene.seed is not None:
        statistics = rough.statistics()
        height, curvature = statistics.rms_height, statistics.rms_curvature
    return {
        "rms_slope": rough.rms_slope,
        "rms_height": height / scene.spacing,
        "rms_curvature": curvature * scene.spacing,
        "hurst": rough.hurst,
        "short_wavelength": rough.short_wavelength / scene.spacing,
        "long_wavelength": rough.long_wavelength / scene.spacing,
        "seed": scene.seed,
    }


def _body_columns(scene: Scene) -> dict[str, Any]:
    """Return the columns of the roughness of each of two bodies."""
    values: dict[str, Any] = {
        name: None if kind is int else math.nan for name, kind in _TYPES_BY_BODY.items()
    }
    for part in scene.bodies.parts:
        body = part.section.title.rpartition(".")[0]
        if body:
            statistics = part.surface.statistics()
            values[f"{body}_rms_slope"] = statistics.rms_slope
            values[f"{body}_rms_height"] = statistics.rms_height / scene.spacing
            values[f"{body}_rms_curvature"] = statistics.rms_curvature * scene.spacing
            values[f"{body}_seed"] = getattr(part.section, "seed", None)
    return values


def step_columns(case: str, scene: Scene, record: LoadStep) -> dict[str, Any]:
    """Return all columns of a load step of a case; see `step_types`."""
    return {
        "case": case,
        "target": scene.path.target_of(scene.bodies, record),
        **scene_columns(scene),
        **asdict(record),
        # with a letter, since ASE's databases refuse text that reads as a number
        "version": f"v{version('ase-roughcontact')}",
    }


def case_columns(scene: Scene, steps: Sequence[LoadStep]) -> dict[str, Any]:
    """Return the columns of a case with a finished path; see `case_types`.

    The message has the warnings of the path, such as a pull-off force that is a lower
    bound.
    """
    path, bodies = scene.path, scene.bodies
    return {
        "message": "; ".join(path.warnings(bodies, steps)),
        "lower_bounds": "; ".join(lower_bounds_of(path, bodies, steps)),
        **scene_columns(scene),
        **results_of(path, bodies, steps),
    }


def read_ensemble(
    database: PathName, selection: str | None = None, **query: Any
) -> EnsembleTable:
    """Read the load steps of an ensemble, or its cases with the results of their paths.

    Parameters
    ----------
    database : path
        Database of `run_ensemble`.
    selection : str, optional
        Query as for ``ase db``: ``"radius>100,kind=hard"``.
    **query
        Values of keys: ``seed=1``; ``record="case"`` for cases in place of steps.

    Returns
    -------
    EnsembleTable
        A dict of columns by name, sorted by case and step, with `units`, `to_pandas`
        and `figure`. Inputs are in the units of the scene
        file: lengths of sphere and roughness in spacings, works of adhesion in J/m^2.
        Everything else is in ASE's units: ``spacing`` in Å, ``contact_modulus`` in
        eV/Å^3, ``target`` in Å or, for ``control == "load"``, in eV/Å, and the columns
        of `LoadStep`. Missing values are NaN, -1 or "".

        The row of a case has the ``state`` in which it ended, "done" or "failed", a
        ``message`` with reasons, the number of its ``steps`` and of the ``unconverged``
        ones, all limits of the model that they exceed (``validity``), the names of
        results that are ``lower_bounds``, and the results that the kinds of path
        declare (`PathKind.results`), such as ``pull_off_force``; NaN
        where a case failed or a result is not defined.

    Raises
    ------
    ValueError
        If the database does not exist or is damaged.
    """
    address = database_address(database)
    file = Path(address)
    # a file of one byte is an empty database to SQLite
    if "://" not in address and not (file.exists() and file.stat().st_size > 1):
        raise ValueError(f"there is no database {address}, or it is empty")
    stored = EnsembleDatabase(address)
    stored.check()
    rows = stored.select(selection, **query)
    of_cases = query.get("record") == "case"
    ordered = sorted(rows, key=lambda row: (row["case"], row.get("step", 0)))
    columns: dict[str, np.ndarray] = {}
    for name, kind in (case_types() if of_cases else step_types()).items():
        values = [row.get(name, MISSING[kind]) for row in ordered]
        columns[name] = np.array(values, dtype=kind)
    return EnsembleTable(columns, column_units())


def write_csv(
    database: PathName, file: PathName, selection: str | None = None, **query: Any
) -> None:
    """Write steps or cases of an ensemble as CSV, with ten significant digits.

    Heads of columns include their units, except targets and rates, where the unit
    depends on the control.

    Parameters
    ----------
    database, selection, **query
        See `read_ensemble`.
    file : path
        File to write; an existing file is overwritten.
    """
    check_different(database=database, file=file)
    columns = read_ensemble(database, selection, **query)
    texts: list[Any] = []
    for values in columns.values():
        is_float = values.dtype.kind == "f"
        texts.append([f"{value:.10g}" for value in values] if is_float else values)
    units = columns.units
    heads = [f"{name} ({units[name]})" if name in units else name for name in columns]
    write_table(file, heads, zip(*texts, strict=True))
