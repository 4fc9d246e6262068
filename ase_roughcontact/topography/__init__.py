"""Indenters: spheres, self-affine roughness and measured height maps.

Lengths are in any consistent unit. `spectrum` measures statistics of heights.
"""

from ase_roughcontact.topography.base import BoundedSurface, Surface
from ase_roughcontact.topography.heightmap import HeightMap
from ase_roughcontact.topography.heterogeneity import Heterogeneity
from ase_roughcontact.topography.known import ROUGHNESSES, Topography
from ase_roughcontact.topography.selfaffine import SelfAffine
from ase_roughcontact.topography.sphere import RoughSphere

__all__ = [
    "ROUGHNESSES",
    "BoundedSurface",
    "HeightMap",
    "Heterogeneity",
    "RoughSphere",
    "SelfAffine",
    "Surface",
    "Topography",
]
