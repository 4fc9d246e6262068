"""Optimizers that know the half space."""

from ase_roughcontact.optimize.modes import FourierModes
from ase_roughcontact.optimize.precon import HalfSpacePrecon
from ase_roughcontact.optimize.solvers import HardWallCG, NewtonKrylov

__all__ = ["FourierModes", "HalfSpacePrecon", "HardWallCG", "NewtonKrylov"]
