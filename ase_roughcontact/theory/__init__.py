"""Closed forms for smooth and rough spheres on an elastic half space.

Smooth spheres: `hertz`, `jkr`, `dmt`, `maugis`, and `smooth_sphere`, which chooses
between them. Rough surfaces: `self_affine` (spectral moments), `rough_flats` (kappa,
macroscopic adhesion), `flat_reference` (tabulated contact fraction), `first_asperity`,
`rough_contact` (area of rough spheres), `rough_sphere` (all characteristic numbers of
one) and `regime`, which determines the law.
"""

from ase_roughcontact.theory.dmt import (
    dmt_contact_radius,
    dmt_force,
    dmt_penetration,
    dmt_pull_off_force,
)
from ase_roughcontact.theory.first_asperity import (
    ASPERITY_FACTOR_REPULSIVE,
    asperity_radius,
    asperity_radius_from_curvature,
    first_contact_radius,
    first_contact_radius_from_height,
    low_load_plateau,
)
from ase_roughcontact.theory.flat_reference import FlatReference
from ase_roughcontact.theory.hertz import (
    hertz_contact_area,
    hertz_contact_radius,
    hertz_contact_radius_from_penetration,
    hertz_force,
    hertz_penetration,
    hertz_pressure,
)
from ase_roughcontact.theory.jkr import (
    jkr_contact_radius,
    jkr_contact_radius_from_penetration,
    jkr_force,
    jkr_penetration,
    jkr_pull_off_force,
    jkr_pull_off_penetration,
    jkr_zero_load_area,
)
from ase_roughcontact.theory.maugis import (
    maugis_dugdale,
    maugis_dugdale_contact_radius,
    maugis_dugdale_pull_off_force,
    maugis_dugdale_stability_limit,
    maugis_parameter,
    tabor_parameter,
)
from ase_roughcontact.theory.regime import Regime, regime
from ase_roughcontact.theory.rough_contact import (
    contact_area,
    crossover_load,
    crossover_radius_ratio,
    predicted_area,
)
from ase_roughcontact.theory.rough_flats import (
    KAPPA_HARD,
    KAPPA_REPULSIVE,
    compliant_kappa,
    contact_fraction,
    flattening_energy,
    inverse_kappa_adhesive,
    inverse_kappa_attractive,
    is_sticky,
    mean_contact_pressure,
)
from ase_roughcontact.theory.rough_sphere import Roughness, RoughSphereTheory
from ase_roughcontact.theory.self_affine import rms_height, slope_to_curvature_ratio
from ase_roughcontact.theory.smooth_sphere import (
    DMT_BELOW,
    JKR_ABOVE,
    SmoothContact,
    smooth_contact,
)

__all__ = [
    "ASPERITY_FACTOR_REPULSIVE",
    "DMT_BELOW",
    "JKR_ABOVE",
    "KAPPA_HARD",
    "KAPPA_REPULSIVE",
    "FlatReference",
    "Regime",
    "RoughSphereTheory",
    "Roughness",
    "SmoothContact",
    "asperity_radius",
    "asperity_radius_from_curvature",
    "compliant_kappa",
    "contact_area",
    "contact_fraction",
    "crossover_load",
    "crossover_radius_ratio",
    "dmt_contact_radius",
    "dmt_force",
    "dmt_penetration",
    "dmt_pull_off_force",
    "first_contact_radius",
    "first_contact_radius_from_height",
    "flattening_energy",
    "hertz_contact_area",
    "hertz_contact_radius",
    "hertz_contact_radius_from_penetration",
    "hertz_force",
    "hertz_penetration",
    "hertz_pressure",
    "inverse_kappa_adhesive",
    "inverse_kappa_attractive",
    "is_sticky",
    "jkr_contact_radius",
    "jkr_contact_radius_from_penetration",
    "jkr_force",
    "jkr_penetration",
    "jkr_pull_off_force",
    "jkr_pull_off_penetration",
    "jkr_zero_load_area",
    "low_load_plateau",
    "maugis_dugdale",
    "maugis_dugdale_contact_radius",
    "maugis_dugdale_pull_off_force",
    "maugis_dugdale_stability_limit",
    "maugis_parameter",
    "mean_contact_pressure",
    "predicted_area",
    "regime",
    "rms_height",
    "slope_to_curvature_ratio",
    "smooth_contact",
    "tabor_parameter",
]
