"""The columns of an ensemble: what is stored of each load step, and read again."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from ase_roughcontact._util.files import PathName, write_table
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.ensemble.database import EnsembleDatabase, database_address
from ase_roughcontact.paths.path_records import FlatStep, SlidingStep, TimeStep
from ase_roughcontact.paths.record import MISSING, LoadStep
from ase_roughcontact.scene import Scene


@dataclass(frozen=True)
class _SceneColumns:
    """Columns that the scene determines; lengths but the spacing in units of it.

    Parameters of the wall are also those that follow from named materials.
    """

    control: str
    radius: float
    rms_slope: float
    hurst: float
    short_wavelength: float
    long_wavelength: float
    seed: int
    kind: str
    work_of_adhesion: float
    attraction_range: float
    hardness: float
    permanent: bool
    friction_coefficient: float
    shear_strength: float
    spacing: float
    contact_modulus: float
    rate: float

    @classmethod
    def of(cls, scene: Scene) -> _SceneColumns:
        spacing, wall, friction = scene.spacing, scene.wall, scene.friction
        rate = getattr(scene.path, "rate", None)
        rough: Any = scene.rough
        hard = scene.hardness / UNITS["GPa"]
        return cls(
            scene.path.control,
            scene.radius / spacing,
            getattr(rough, "rms_slope", 0.0),
            getattr(rough, "hurst", math.nan),
            getattr(rough, "short_wavelength", math.nan) / spacing,
            getattr(rough, "long_wavelength", math.nan) / spacing,
            getattr(rough, "seed", MISSING[int]),
            scene.interaction.kind,
            wall.work_of_adhesion / UNITS["J/m^2"] or math.nan,
            wall.attraction_range / spacing or math.nan,
            hard if wall.hardness < math.inf else math.nan,
            wall.permanent,
            getattr(friction, "coefficient", math.nan),
            getattr(friction, "shear_strength", math.nan),
            spacing,
            scene.contact_modulus,
            rate if isinstance(rate, (int, float)) else math.nan,
        )


#: Columns of an ensemble and their types; see `read_ensemble`.
COLUMNS: dict[str, type] = {
    "case": str,
    "step": int,
    "control": str,
    "target": float,
    **{
        name: kind
        for record in (_SceneColumns, LoadStep, TimeStep, FlatStep, SlidingStep)
        for name, kind in get_type_hints(record).items()
    },
    "version": str,
}


def scene_columns(scene: Scene) -> dict[str, Any]:
    """Return the columns that a scene determines, the same for all its steps."""
    values = asdict(_SceneColumns.of(scene))
    return {
        name: MISSING[COLUMNS[name]] if value is None else COLUMNS[name](value)
        for name, value in values.items()
    }


def step_columns(case: str, scene: Scene, record: LoadStep) -> dict[str, Any]:
    """Return all columns of a load step of a case; see `COLUMNS`."""
    return {
        "case": case,
        "target": scene.path.target_of(scene.bodies, record),
        **scene_columns(scene),
        **asdict(record),
        # with a letter, since ASE's databases refuse text that reads as a number
        "version": f"v{version('ase-roughcontact')}",
    }


def read_ensemble(
    database: PathName, selection: str | None = None, **query: Any
) -> dict[str, np.ndarray]:
    """Read the load steps of an ensemble.

    Parameters
    ----------
    database : path
        Of `run_ensemble`.
    selection : str, optional
        Query as for ``ase db``: ``"radius>100,kind=hard"``.
    **query
        Values of keys: ``seed=1``.

    Returns
    -------
    dict of ndarray, shape (steps,)
        By name, see `COLUMNS`, sorted by case and step. Inputs are in the units of the
        scene file: lengths of sphere and roughness in spacings, works of adhesion in
        J/m^2. All else is in ASE's units: ``spacing`` in Å, ``contact_modulus`` in
        eV/Å^3, ``target`` in Å or, for ``control == "load"``, in eV/Å, and the columns
        of `LoadStep`. Missing values are NaN, -1 or "".

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
    ordered = sorted(rows, key=lambda row: (row["case"], row["step"]))
    return {
        name: np.array([row.get(name, MISSING[kind]) for row in ordered], dtype=kind)
        for name, kind in COLUMNS.items()
    }


def write_csv(
    database: PathName, file: PathName, selection: str | None = None, **query: Any
) -> None:
    """Write the load steps of an ensemble as CSV, with ten significant digits.

    Parameters
    ----------
    database, selection, **query
        See `read_ensemble`.
    file : path
        Overwritten if it exists.
    """
    columns = read_ensemble(database, selection, **query)
    texts = [
        [f"{value:.10g}" for value in values] if values.dtype.kind == "f" else values
        for values in columns.values()
    ]
    write_table(file, columns, zip(*texts, strict=True))
