"""Optimizers for the contact problem, and aids for ASE's optimizers."""

from ase_roughcontact.optimize.base import ContactOptimizer
from ase_roughcontact.optimize.modes import FourierModes
from ase_roughcontact.optimize.optimizers import (
    ActiveSet,
    NewtonKrylov,
    default_optimizer,
)
from ase_roughcontact.optimize.precon import HalfSpacePrecon

__all__ = [
    "ActiveSet",
    "ContactOptimizer",
    "FourierModes",
    "HalfSpacePrecon",
    "NewtonKrylov",
    "default_optimizer",
]
