"""Analysis of contacts: maps, patches, radial averages, distributions, fits of kappa.

Units are eV and Å.
"""

from ase_roughcontact.analysis.conductance import conductance
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.analysis.contact_patches import Patches, patches
from ase_roughcontact.analysis.distributions import (
    Distribution,
    gap_distribution,
    pressure_distribution,
)
from ase_roughcontact.analysis.first_contact_point import FirstContact, first_contact
from ase_roughcontact.analysis.grid_limit import GridLimit, extrapolate
from ase_roughcontact.analysis.kappa_fit import KappaFit, fit_kappa
from ase_roughcontact.analysis.map_files import write_map
from ase_roughcontact.analysis.radial import RadialAverage, radial_average

__all__ = [
    "ContactMap",
    "Distribution",
    "FirstContact",
    "GridLimit",
    "KappaFit",
    "Patches",
    "RadialAverage",
    "conductance",
    "extrapolate",
    "first_contact",
    "fit_kappa",
    "gap_distribution",
    "patches",
    "pressure_distribution",
    "radial_average",
    "write_map",
]
