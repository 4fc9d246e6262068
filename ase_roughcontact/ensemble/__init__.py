"""Ensembles: many scenes, calculated by many workers and kept in one ASE database."""

from ase_roughcontact.ensemble.adaptive import (
    MeanArea,
    Sampling,
    mean_areas,
    sample_ensemble,
)
from ase_roughcontact.ensemble.cases import case_of, product
from ase_roughcontact.ensemble.columns import read_ensemble, write_csv
from ase_roughcontact.ensemble.places import read_places, run_places
from ase_roughcontact.ensemble.progress import Progress
from ase_roughcontact.ensemble.run import run_ensemble

__all__ = [
    "MeanArea",
    "Progress",
    "Sampling",
    "case_of",
    "mean_areas",
    "product",
    "read_ensemble",
    "read_places",
    "run_ensemble",
    "run_places",
    "sample_ensemble",
    "write_csv",
]
