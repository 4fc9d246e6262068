"""Optimizers that know the half space."""

from ase_roughcontact.optimize.modes import FourierModes
from ase_roughcontact.optimize.optimizers import ActiveSet, NewtonKrylov
from ase_roughcontact.optimize.precon import HalfSpacePrecon

__all__ = ["ActiveSet", "FourierModes", "HalfSpacePrecon", "NewtonKrylov"]
