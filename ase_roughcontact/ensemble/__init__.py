"""Ensembles: many scenes, calculated by many workers and kept in one ASE database."""

from ase_roughcontact.ensemble.adaptive import Sampling, sample_ensemble
from ase_roughcontact.ensemble.cases import case_of, product
from ase_roughcontact.ensemble.columns import read_ensemble, write_csv
from ase_roughcontact.ensemble.means import (
    MeanArea,
    MeanValue,
    mean_areas,
    mean_values,
)
from ase_roughcontact.ensemble.places import read_places, run_places
from ase_roughcontact.ensemble.progress import Progress
from ase_roughcontact.ensemble.run import run_ensemble
from ase_roughcontact.ensemble.study import StudyPoint, study_points, write_study
from ase_roughcontact.ensemble.table import EnsembleTable

__all__ = [
    "EnsembleTable",
    "MeanArea",
    "MeanValue",
    "Progress",
    "Sampling",
    "StudyPoint",
    "case_of",
    "mean_areas",
    "mean_values",
    "product",
    "read_ensemble",
    "read_places",
    "run_ensemble",
    "run_places",
    "sample_ensemble",
    "study_points",
    "write_csv",
    "write_study",
]
