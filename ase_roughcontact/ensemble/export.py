"""The load steps of an ensemble as arrays, and as a CSV file."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from ase_roughcontact._util.files import PathName, write_table
from ase_roughcontact.ensemble.columns import COLUMNS
from ase_roughcontact.ensemble.database import EnsembleDatabase, database_address
from ase_roughcontact.paths.record import MISSING


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
    return _columns(stored.select(selection, **query))


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


def _columns(rows: Iterable[Any]) -> dict[str, np.ndarray]:
    """Return rows as columns, sorted by case and step."""
    ordered = sorted(rows, key=lambda row: (row["case"], row["step"]))
    return {
        name: np.array([row.get(name, MISSING[kind]) for row in ordered], dtype=kind)
        for name, kind in COLUMNS.items()
    }
