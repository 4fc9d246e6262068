"""Analysis of contacts: maps, patches, averages, distributions, limits of fine grids.

Units are eV and Å.
"""

from ase_roughcontact.analysis.contact_conductance import conductance
from ase_roughcontact.analysis.contact_map import ContactMap
from ase_roughcontact.analysis.contact_patches import patches
from ase_roughcontact.analysis.distributions import (
    gap_distribution,
    pressure_distribution,
    radial_average,
)
from ase_roughcontact.analysis.first_contact_point import first_contact
from ase_roughcontact.analysis.map_dataset import map_dataset
from ase_roughcontact.analysis.map_files import write_map
from ase_roughcontact.analysis.path_values import (
    dynamic_stiffness,
    extrapolate,
    loop_energies,
    static_friction,
)
from ase_roughcontact.analysis.stress_files import write_stress
from ase_roughcontact.analysis.stresses import (
    FirstYield,
    StressPlane,
    StressSection,
    first_yield,
    stress_field,
    stress_planes,
    stress_section,
)
from ase_roughcontact.analysis.view import view_frames, with_columns, with_indenter

__all__ = [
    "ContactMap",
    "FirstYield",
    "StressPlane",
    "StressSection",
    "conductance",
    "dynamic_stiffness",
    "extrapolate",
    "first_contact",
    "first_yield",
    "gap_distribution",
    "loop_energies",
    "map_dataset",
    "patches",
    "pressure_distribution",
    "radial_average",
    "static_friction",
    "stress_field",
    "stress_planes",
    "stress_section",
    "view_frames",
    "with_columns",
    "with_indenter",
    "write_map",
    "write_stress",
]
