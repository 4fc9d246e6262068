"""Ensembles: many scenes, calculated by many workers, kept in one ASE database."""

from ase_roughcontact.ensemble.cases import case_of, product
from ase_roughcontact.ensemble.progress import Progress
from ase_roughcontact.ensemble.run import run_ensemble
from ase_roughcontact.ensemble.table import (
    COLUMNS,
    fill_database,
    read_ensemble,
    read_table,
    write_table,
)

__all__ = [
    "COLUMNS",
    "Progress",
    "case_of",
    "fill_database",
    "product",
    "read_ensemble",
    "read_table",
    "run_ensemble",
    "write_table",
]
