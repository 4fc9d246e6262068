"""Optimizers that know the half space."""

from ase_roughcontact.optimize.modes import FourierModes

__all__ = ["FourierModes"]
