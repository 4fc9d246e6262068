"""Shapes of the indenter."""

from ase_roughcontact.topography.base import BoundedSurface, Surface
from ase_roughcontact.topography.heightmap import HeightMap
from ase_roughcontact.topography.selfaffine import SelfAffine
from ase_roughcontact.topography.sphere import RoughSphere

__all__ = ["BoundedSurface", "HeightMap", "RoughSphere", "SelfAffine", "Surface"]
