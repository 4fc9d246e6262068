"""What a contact looks like: radial averages, first contact, distributions, kappa.

Units are those of the atoms (eV and Å); any consistent ones will do.
"""

from ase_roughcontact.analysis.distributions import (
    Distribution,
    gap_distribution,
    pressure_distribution,
)
from ase_roughcontact.analysis.first_contact_point import FirstContact, first_contact
from ase_roughcontact.analysis.kappa_fit import KappaFit, fit_kappa
from ase_roughcontact.analysis.radial import RadialAverage, radial_average

__all__ = [
    "Distribution",
    "FirstContact",
    "KappaFit",
    "RadialAverage",
    "first_contact",
    "fit_kappa",
    "gap_distribution",
    "pressure_distribution",
    "radial_average",
]
