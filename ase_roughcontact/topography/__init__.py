"""Indenters: spheres, self-affine roughness and measured height maps.

Lengths are in any consistent unit.

================================  ====================================================
``base``, ``topography``          heights of an indenter, and its further properties
``sphere``, ``shaped_indenter``   the rough sphere; cones, pyramids and punches
``random_waves``                  random roughness, by its spectrum: ``selfaffine``,
                                  with ``amplitudes``, and ``tabulated_spectrum``,
                                  from ``spectrum_files`` and ``profile_spectrum``
``heightmap``, ``interpolation``  a map of heights, and splines through it
``realisation``                   other realisations of a scan
``composite``                     the roughness of two bodies
``heterogeneity``                 a work of adhesion that varies over the surface
``spectrum``, ``lowest_point``    statistics of heights, and their lowest point
``scan_files``                    scans from files, by ``scan_text``, ``scan_points``,
                                  ``channels`` and SurfaceTopography (``raw_scan``)
``scan``, ``profile``             units of scans, and lines that are no maps
``levelling``, ``bad_lines``      from measured to levelled heights, with
``noise``, ``square_grid``        ``pressed_scan``, which orders these steps
``measurement``                   copies of a scan with its errors
``tip_fit``                       radius of a scanned tip
``self_affine_fit``               self-affine parameters of a scan
================================  ====================================================
"""

from ase_roughcontact.topography.base import BoundedSurface, Surface
from ase_roughcontact.topography.composite import CompositeRoughness, Inverted
from ase_roughcontact.topography.heightmap import HeightMap
from ase_roughcontact.topography.heterogeneity import Heterogeneity
from ase_roughcontact.topography.random_waves import RandomWaves
from ase_roughcontact.topography.raw_scan import RawScan
from ase_roughcontact.topography.scan_files import SCAN_FORMATS, ScanFormat
from ase_roughcontact.topography.selfaffine import SelfAffine
from ase_roughcontact.topography.shaped_indenter import ShapedIndenter
from ase_roughcontact.topography.sphere import RoughSphere
from ase_roughcontact.topography.tabulated_spectrum import TabulatedSpectrum
from ase_roughcontact.topography.topography import ROUGHNESSES, Topography

__all__ = [
    "ROUGHNESSES",
    "SCAN_FORMATS",
    "BoundedSurface",
    "CompositeRoughness",
    "HeightMap",
    "Heterogeneity",
    "Inverted",
    "RandomWaves",
    "RawScan",
    "RoughSphere",
    "ScanFormat",
    "SelfAffine",
    "ShapedIndenter",
    "Surface",
    "TabulatedSpectrum",
    "Topography",
]
