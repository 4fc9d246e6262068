"""The steps of an ensemble as columns: read from the database, kept as a CSV file."""

from __future__ import annotations

import csv
import math
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np

from ase_roughcontact.ensemble.ledger import Ledger, PathName, address, open_database
from ase_roughcontact.paths.record import LoadStep

#: Columns of a table of steps, and their types; see `read_ensemble`.
COLUMNS: dict[str, type] = {
    "case": str,
    "step": int,
    "control": str,
    "target": float,
    "radius": float,
    "rms_slope": float,
    "hurst": float,
    "short_wavelength": float,
    "long_wavelength": float,
    "seed": int,
    "kind": str,
    "work_of_adhesion": float,
    "spacing": float,
    "contact_modulus": float,
    **{name: kind for name, kind in get_type_hints(LoadStep).items() if name != "step"},
    "version": str,
}
_MISSING: dict[type, Any] = {str: "", float: math.nan, int: -1, bool: False}


def read_ensemble(
    database: PathName, selection: str | None = None, **query: Any
) -> dict[str, np.ndarray]:
    """Read the steps of an ensemble as columns.

    Parameters
    ----------
    database : path
        Of `run_ensemble`.
    selection : str, optional
        Query as for ``ase db``: ``"radius>100,kind=hard"``.
    **query
        Values that keys must have: ``seed=1``.

    Returns
    -------
    dict of ndarray, shape (steps,)
        By name, see `COLUMNS`, sorted by case and step. Inputs are in the units of the
        scene file: lengths of sphere and roughness in spacings, works of adhesion in
        J/m^2; all else is in ASE's: ``spacing`` in Å, ``contact_modulus`` in eV/Å^3,
        ``target`` in Å or, under ``control == "load"``, eV/Å, and what `LoadStep` has.
        What a case does not have is NaN, -1 or "".

    Raises
    ------
    ValueError
        If there is no such database.
    """
    name = address(database)
    if "://" not in name and not Path(name).exists():
        raise ValueError(f"there is no database {name}")
    rows = open_database(name).select(
        selection, record="step", include_data=False, **query
    )
    return _columns(
        {name: row.get(name, _MISSING[kind]) for name, kind in COLUMNS.items()}
        for row in rows
    )


def write_table(
    database: PathName, table: PathName, selection: str | None = None, **query: Any
) -> None:
    """Write the steps of an ensemble as CSV, numbers to ten digits.

    Parameters
    ----------
    database, selection, **query
        See `read_ensemble`.
    table : path
        File to be written.
    """
    columns = read_ensemble(database, selection, **query)
    texts = [
        [f"{value:.10g}" for value in values] if values.dtype.kind == "f" else values
        for values in columns.values()
    ]
    with open(table, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*texts, strict=True))


def read_table(table: PathName) -> dict[str, np.ndarray]:
    """Read what `write_table` wrote, as `read_ensemble` does.

    Parameters
    ----------
    table : path

    Returns
    -------
    dict of ndarray

    Raises
    ------
    ValueError
        If the table has unknown columns, or values that are not of their types. What it
        does not have is missing, as in `read_ensemble`.
    """
    with open(table, newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file, restval="")
        given = reader.fieldnames or []
        if not {"case", "step"} <= set(given) <= set(COLUMNS):
            raise ValueError(
                f"{os.fspath(table)} must have the columns {', '.join(COLUMNS)}, or "
                f"some of them, case and step among them; got {', '.join(given)}"
            )
        return _columns(
            {
                name: _parsed(row[name], kind) if name in given else _MISSING[kind]
                for name, kind in COLUMNS.items()
            }
            for row in reader
        )


def fill_database(database: PathName, table: PathName) -> int:
    """Put the steps of a table into a database, so that a run can go on from them.

    Parameters
    ----------
    database : path
        Made if it is not there. Cases that it has already stay as they are.
    table : path
        From `write_table`.

    Returns
    -------
    int
        Number of steps added.

    Raises
    ------
    ValueError
        If the table is not what `read_table` reads, or has a step twice.
    """
    columns = read_table(table)
    steps: dict[str, list[dict[str, Any]]] = {}
    for values in zip(*(x.tolist() for x in columns.values()), strict=True):
        row = dict(zip(columns, values, strict=True))
        of_case = steps.setdefault(row["case"], [])
        if of_case and of_case[-1]["step"] == row["step"]:  # they are sorted
            raise ValueError(
                f"{os.fspath(table)} must have every step once, got step "
                f"{row['step']} of case {row['case']} again"
            )
        of_case.append(row)
    ledger = Ledger(address(database))
    ledger.prepare()
    return ledger.fill(steps)


def _columns(rows: Iterable[dict[str, Any]]) -> dict[str, np.ndarray]:
    """Columns of rows, sorted by case and step."""
    ordered = sorted(rows, key=lambda row: (row["case"], row["step"]))
    return {
        name: np.array([row[name] for row in ordered], dtype=kind)
        for name, kind in COLUMNS.items()
    }


def _parsed(text: str, kind: type) -> Any:
    """Value of a table's field."""
    try:
        return {"True": True, "False": False}[text] if kind is bool else kind(text)
    except (KeyError, ValueError) as error:
        raise ValueError(
            f"a table of steps has {text!r} where a {kind.__name__} is expected"
        ) from error
