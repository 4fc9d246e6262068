"""Optimizers for the contact problem, and aids for ASE's optimizers."""

from ase_roughcontact.optimize.base import ContactOptimizer
from ase_roughcontact.optimize.modes import FourierModes
from ase_roughcontact.optimize.optimizers import (
    ActiveSet,
    NewtonKrylov,
    default_optimizer,
)
from ase_roughcontact.optimize.precon import HalfSpacePrecon
from ase_roughcontact.solvers.relaxation import Relaxation
from ase_roughcontact.solvers.status import Status

__all__ = [
    "ActiveSet",
    "ContactOptimizer",
    "FourierModes",
    "HalfSpacePrecon",
    "NewtonKrylov",
    "Relaxation",
    "Status",
    "default_optimizer",
]
